#pragma once

#include "../../hier/base/vec.hpp"
#include "../../schemes/core/stencil_table.hpp"
#include "../lattices/ghost_grid.hpp"
#include "../lattices/root_lattices.hpp"
#include "../rules/rule_limit.hpp"
#include "corner_templates.hpp"
#include "row_kernels.hpp"

#include <cstdint>
#include <memory>
#include <numeric>
#include <span>
#include <vector>

namespace tetrakis::detail {

/// What the rules say of one kind of corner.
struct CornerRows {
    CornerTemplate corner;
    std::vector<int> row;  ///< at the results' places; -1: none
    RuleLimits rows;       ///< of limits; of a step: its rows are the positions
};

/// Rows of weights that repeat themselves from level to level: the same all over a root's lattice and its ghosts; along
/// each sharp side; and around each corner that is special, at the same places counted from there. Learned around each
/// kind of corner by itself, they are read on every level that is fine enough, at places found by arithmetic.
class RowPatterns {
  public:
    enum class Kind {
        points,  ///< a row per point: the point
        normals  ///< pairs of rows, tangents t1 and t2 of each surface that meets there: the mean of their unit normals
    };
    /// @param net     must live as long
    /// @param factor  segments of the level of the results to one of the level of the points; 1: the same level
    RowPatterns(const RootLattices& net, std::uint32_t factor, Kind kind);

    /// Rows of a level, by the places of a root's grid.
    using GridRows = std::vector<std::vector<GridTerm>>;

    /// False where the rows do not repeat, or templates are too small to see whether they do.
    /// @param corners  of the net
    /// @param sources  one of each kind, then that of a regular corner
    bool learn(const CornerKinds& corners, std::span<const std::shared_ptr<const CornerRows>> sources);
    /// Results that far from the corner, in the places of the finer level, are looked at in its template.
    static constexpr std::uint32_t zone(std::uint32_t factor, std::uint32_t segments) {
        return factor * segments * 2 / 3;
    }
    std::uint32_t factor() const { return factor_; }
    /// Points that a result inside is made of.
    std::size_t terms_inside() const {
        return std::accumulate(regular_.begin(), regular_.begin() + rows_inside(), std::size_t{0},
                               [](std::size_t sum, const RowOf<Step>& row) { return sum + row.size(); });
    }

    /// Whether a level's points are enough for the rows.
    bool fits(const RootLayout& coarse) const;

    /// What is told of the progress of a call.
    struct Progress {
        const RunContext& context;
        double from, to;
    };
    /// Results at a level's places from the points of the one above, or of the same one: unit normals are zero where
    /// there are no rows; at places of the same point (RootLattices::point_numbers) each is of its own side of a
    /// crease. The same bytes for any number of threads.
    void apply(const RootLayout& coarse, const RootLayout& fine, const Vec3d* in, Vec3d* out,
               const Progress& progress) const;
    /// One result by itself, at a level of any depth: calls term(row, place, weight) for all points that it is made of.
    /// A point has row 0 alone; a normal two rows, or four.
    /// @param segments  of the points' level
    /// @param at        its own place on the results' level
    template <class Term>
    void read(std::uint32_t segments, const RootPlace& at, const Term& term) const;
    /// The unit normal of four rows' sums.
    static Vec3d normal_of(const Vec3d* sums);

  private:
    static constexpr std::uint32_t none = RootLattices::none;
    /// A point seen from the place of a result, in the directions of its lattice or side.
    struct Step {
        std::int16_t a, b;
        auto operator<=>(const Step&) const = default;
    };
    template <class At>
    struct TermOf {
        At at;
        double weight;
    };
    template <class At>
    using RowOf = std::vector<TermOf<At>>;
    /// Rows of a number of places, rows_per_point() each.
    using SidePattern = std::vector<RowOf<Step>>;
    struct CornerPlace {
        std::uint32_t x, y;
        std::vector<RowOf<RootLattices::Seen>> rows;
    };
    using CornerPattern = std::vector<CornerPlace>;

    /// At most two surfaces with tangents meet.
    std::uint32_t rows_per_point() const { return kind_ == Kind::points ? 1 : 4; }
    std::uint32_t rows_inside() const { return kind_ == Kind::points ? 1 : 2; }
    double tolerance() const;
    template <class At>
    bool same(const RowOf<At>& a, const RowOf<At>& b) const;

    template <class At, class SeenAt>
    bool rows_of(const CornerRows& source, int row, const SeenAt& seen_at, std::span<RowOf<At>> out,
                 bool seen_only = false) const;
    bool learn_regular(const CornerRows& source);
    bool has_kernel() const;
    class TemplateReader;

    struct Work;
    template <class Finish>
    void apply_to_all(const RootLayout& coarse, const RootLayout& fine, const Vec3d* in, Vec3d* out,
                      const Progress& progress) const;
    template <class Finish>
    void regular(const GhostGrid& grid, const GridRows& rows, const RootLayout& fine, std::uint32_t f, Vec3d* out,
                 Work& work) const;
    template <class Finish>
    void side(const GhostGrid& grid, const RootLayout& fine, std::uint32_t h, Vec3d* out, Work& work) const;
    template <class Finish>
    void corner(const RootLayout& coarse, const RootLayout& fine, std::uint32_t h, const Vec3d* in, Vec3d* out) const;
    /// Calls visit(half-edge, point seen from there, weight) for the terms of a row at a corner.
    template <class Visit>
    void for_each_seen(std::uint32_t h, const RowOf<RootLattices::Seen>& row, const Visit& visit) const {
        // Terms come by turns, those against the clock first.
        std::uint32_t g = h;
        int turn = 0;
        for (const auto& [at, weight] : row) {
            for (; turn > at.turn; --turn) g = next_side(net_.side_count() == 4, net_.base().twin(g));
            for (; turn < at.turn; ++turn) g = net_.turned(g);
            visit(g, at, weight);
        }
    }
    std::uint32_t distance(std::uint32_t a, std::uint32_t b) const {
        return net_.side_count() == 4 ? std::max(a, b) : a + b;
    }

    const RootLattices& net_;
    std::uint32_t factor_;
    Kind kind_;
    std::vector<char> regular_corners_;
    /// By the place modulo the factor: y, then x, then the row.
    std::vector<RowOf<Step>> regular_;
    bool kernel_ = false;      ///< whether RowKernels has one for them
    std::uint32_t rings_ = 0;  ///< of ghosts
    std::uint32_t depth_ = 0;  ///< results nearer than that to a sharp side have rows of their own
    std::uint32_t reach_ = 0;  ///< and those nearer than that to a special corner
    /// By the distance from the side, then the place along it modulo the factor.
    std::vector<SidePattern> side_patterns_;
    std::vector<CornerPattern> corner_patterns_;
    std::vector<std::uint32_t> side_pattern_, corner_pattern_;  ///< of each half-edge; none: as inside
    std::int16_t farthest_ = 0;                                 ///< place that a corner's rows see
};

template <class Term>
void RowPatterns::read(std::uint32_t segments, const RootPlace& at, const Term& term) const {
    const std::uint32_t sides = net_.side_count(), last = net_.last_place(factor_ * segments);
    const auto coarse_last = static_cast<std::int64_t>(net_.last_place(segments));
    for (std::uint32_t s = 0, h = sides * at.root; s < sides; ++s, ++h) {
        if (corner_pattern_[h] == none) continue;
        const RootLattices::Place seen = net_.seen_from(last, s, {at.x, at.y});
        if (distance(seen.x, seen.y) >= reach_) continue;
        for (const CornerPlace& place : corner_patterns_[corner_pattern_[h]]) {
            if (place.x != seen.x || place.y != seen.y) continue;
            for (std::uint32_t r = 0; r < place.rows.size(); ++r)
                for_each_seen(h, place.rows[r], [&](std::uint32_t g, const RootLattices::Seen& of, double weight) {
                    term(r,
                         net_.own_place(segments, net_.place_seen(segments, g, static_cast<std::uint32_t>(of.a),
                                                                  static_cast<std::uint32_t>(of.b))),
                         weight);
                });
            return;
        }
    }
    for (std::uint32_t s = 0, h = sides * at.root; s < sides; ++s, ++h) {
        if (side_pattern_[h] == none) continue;
        const auto [a, b] = net_.seen_from(last, s, {at.x, at.y});
        if (b >= depth_ || a + reach_ > last || a < (sides == 4 ? reach_ : reach_ - std::min(reach_, b))) continue;
        const SidePattern& pattern = side_patterns_[side_pattern_[h]];
        for (std::uint32_t r = 0; r < rows_per_point(); ++r)
            for (const auto& [to, weight] : pattern[(b * factor_ + a % factor_) * rows_per_point() + r]) {
                const auto there = turned_place<FarPlace>(sides == 4, coarse_last, s, std::int64_t{a / factor_} + to.a,
                                                          std::int64_t{to.b});
                term(r, net_.place_beyond(segments, at.root, there.x, there.y), weight);
            }
        return;
    }
    const std::size_t kind = (at.y % factor_ * factor_ + at.x % factor_) * std::size_t{rows_inside()};
    const auto x = std::int64_t{at.x / factor_}, y = std::int64_t{at.y / factor_};
    for (std::uint32_t r = 0; r < rows_inside(); ++r)
        for (const auto& [to, weight] : regular_[kind + r])
            term(r, net_.place_beyond(segments, at.root, x + to.a, y + to.b), weight);
}

}  // namespace tetrakis::detail
