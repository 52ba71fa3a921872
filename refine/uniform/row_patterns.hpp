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

/// Stencil rows that the scheme's rules give on the template of one kind of corner.
struct CornerRows {
    CornerTemplate corner;
    std::vector<int> row;  ///< number of the row in `rows`, by place of the results' level; -1: none
    RuleLimits rows;       ///< rows of limits; for a refinement step only `positions`, the rows of the finer points
};

/// Stencil rows of one refinement step, or of limits, which are the same on every level that is fine enough. There is
/// one set for the interior of roots and their ghosts, one for each sharp side and one for each special corner. They
/// are read off a template of each kind of corner; the points that they combine are found by lattice arithmetic.
class RowPatterns {
  public:
    enum class Kind {
        points,  ///< one row per result, which is a point
        normals  ///< two tangent rows for each surface at the point; the result is the mean of their unit normals
    };
    /// @param net     is referred to and must outlive this object
    /// @param factor  segments of the results' level per segment of the points' level; 1: both are the same level
    RowPatterns(const RootLattices& net, std::uint32_t factor, Kind kind);

    /// Stencil rows whose points are given as offsets in a root's grid.
    using GridRows = std::vector<std::vector<GridTerm>>;

    /// Returns false if the rows do not repeat, or if the templates are too small to decide this.
    /// @param corners  kinds of the corners of the net
    /// @param sources  rows of each of these kinds, in their order, and last those of a regular corner
    bool learn(const CornerKinds& corners, std::span<const std::shared_ptr<const CornerRows>> sources);
    /// Largest distance from a template's corner, in segments of the finer level, at which its rows are examined.
    static constexpr std::uint32_t zone(std::uint32_t factor, std::uint32_t segments) {
        return factor * segments * 2 / 3;
    }
    std::uint32_t factor() const { return factor_; }
    /// Number of terms in the rows of the interior result at a coarse point.
    std::size_t terms_inside() const {
        return std::accumulate(regular_.begin(), regular_.begin() + rows_inside(), std::size_t{0},
                               [](std::size_t sum, const RowOf<Step>& row) { return sum + row.size(); });
    }

    /// Whether the lattices of a level are large enough for the rows.
    bool fits(const RootLayout& coarse) const;

    /// Range of progress values that a call reports.
    struct Progress {
        const RunContext& context;
        double from, to;
    };
    /// Computes the results at all places of level `fine` from the points `in` of level `coarse`. A unit normal is zero
    /// where there are no rows. Where a point has several places (RootLattices::point_numbers), the normal at each is
    /// that of its side of the crease. The same bytes for any number of threads.
    void apply(const RootLayout& coarse, const RootLayout& fine, const Vec3d* in, Vec3d* out,
               const Progress& progress) const;
    /// Calls term(row, place, weight) for each term of one result, on a level of any depth. A point has only row 0; a
    /// normal has two rows or four.
    /// @param segments  segments of a root's side on the points' level
    /// @param at        own place (RootLattices::own_place) of the result on its level
    template <class Term>
    void read(std::uint32_t segments, const RootPlace& at, const Term& term) const;
    /// The unit normal from the sums of its four rows.
    static Vec3d normal_of(const Vec3d* sums);

  private:
    static constexpr std::uint32_t none = RootLattices::none;
    /// Lattice offset from a result's place to a point: along x and y, or along a side and away from it.
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
    /// Rows of the places near a side, rows_per_point() for each place.
    using SidePattern = std::vector<RowOf<Step>>;
    struct CornerPlace {
        std::uint32_t x, y;
        std::vector<RowOf<RootLattices::Seen>> rows;
    };
    using CornerPattern = std::vector<CornerPlace>;

    /// A normal has two tangent rows for each surface at the point; at most two surfaces meet there.
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
    /// Calls visit(half-edge, place seen from it, weight) for the terms of a row near a corner.
    template <class Visit>
    void for_each_seen(std::uint32_t h, const RowOf<RootLattices::Seen>& row, const Visit& visit) const {
        // Terms are sorted by their turn; negative turns, which are clockwise, come first.
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
    /// Interior rows, sorted by y modulo `factor_`, then x modulo `factor_`, then the number of the row.
    std::vector<RowOf<Step>> regular_;
    bool kernel_ = false;      ///< whether RowKernels has compiled loops for the interior rows
    std::uint32_t rings_ = 0;  ///< rings of ghosts that the rows read
    std::uint32_t depth_ = 0;  ///< results less than this far from a sharp side use the side's rows
    std::uint32_t reach_ = 0;  ///< results less than this far from a special corner use the corner's rows
    /// Each is sorted by the distance from the side, then by the place along it modulo `factor_`.
    std::vector<SidePattern> side_patterns_;
    std::vector<CornerPattern> corner_patterns_;
    std::vector<std::uint32_t> side_pattern_, corner_pattern_;  ///< index by half-edge; none: interior rows hold there
    std::int16_t farthest_ = 0;                                 ///< distance of the farthest point in a corner's rows
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
