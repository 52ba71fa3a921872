#include "tetrakis/refine/repeated_rows.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

// What a step of the rules says, in terms that hold for all later ones.
namespace tetrakis::detail {

namespace {

constexpr std::uint32_t none = MeshLevel::none;

/// Weights of one row found in two places differ by rounding at most.
constexpr double k_same_weight = 1e-13;

}  // namespace

/// Where a point is in the lattice of root f, sides included; nothing if it is not there.
std::optional<RepeatedRows::Place> RepeatedRows::place_in(const RootLayout& at, std::uint32_t f,
                                                          std::uint32_t number) const {
    const std::uint32_t n = at.segments(), sides = side_count(), inner = n - 1;
    if (in_cells_) {
        if (number / (n * n) != f) return std::nullopt;
        return Place{number % n, number / n % n};
    }
    if (number < base_.vertex_count) {
        for (std::uint32_t s = 0; s < sides; ++s)
            if (base_.origin[sides * f + s] == number) return turned(n, s, 0, 0);
        return std::nullopt;
    }
    if (number < at.face_begin(0)) {
        const std::uint32_t e = (number - base_.vertex_count) / inner, j = (number - base_.vertex_count) % inner + 1;
        for (std::uint32_t s = 0; s < sides; ++s) {
            const std::uint32_t side = base_.edge_side[sides * f + s];
            if (side >> 1 == e) return turned(n, s, (side & 1) == 0 ? j : n - j, 0);
        }
        return std::nullopt;
    }
    if (number < at.face_begin(f) || number >= at.face_begin(f) + at.root_points()) return std::nullopt;
    std::uint32_t i = number - at.face_begin(f);
    if (sides == 4) return Place{i % inner + 1, i / inner + 1};
    std::uint32_t y = 1;
    for (; i >= n - 1 - y; ++y) i -= n - 1 - y;
    return Place{i + 1, y};
}

std::optional<RepeatedRows::Term> RepeatedRows::at_corner(const RootLayout& at, std::uint32_t h,
                                                          std::uint32_t number) const {
    const std::uint32_t n = at.segments();
    const auto in = [&](std::uint32_t g, int turn) -> std::optional<Term> {
        const std::uint32_t f = g / side_count();
        const std::optional<Place> p = place_in(at, f, number);
        if (!p) return std::nullopt;
        const Place seen = seen_from(last_place(n), g % side_count(), *p);
        // What lies on the far sides belongs to other corners as well.
        if (!in_cells_ && (seen.x == n || seen.y == n || rest(n, seen.x, seen.y) == 0)) return std::nullopt;
        return Term{static_cast<std::int16_t>(turn), static_cast<std::int16_t>(seen.x),
                    static_cast<std::int16_t>(seen.y), 0};
    };
    std::uint32_t g = h;
    int turn = 0;
    do {
        if (const auto term = in(g, turn)) return term;
        g = base_.twin[base_.prev(g)];
        ++turn;
    } while (g != none && g != h);
    if (g == h) return std::nullopt;
    // A boundary: the other way round, too.
    turn = 0;
    for (g = base_.twin[h]; g != none; g = base_.twin[g]) {
        g = base_.next(g);
        if (const auto term = in(g, --turn)) return term;
    }
    return std::nullopt;
}

std::optional<RepeatedRows::Term> RepeatedRows::at_side(const RootLayout& at, std::uint32_t h,
                                                        std::uint32_t number) const {
    const std::uint32_t n = at.segments();
    int beyond = 0;
    for (const std::uint32_t g : {h, base_.twin[h]}) {
        if (g == none) break;
        if (const std::optional<Place> p = place_in(at, g / side_count(), number)) {
            const Place seen = seen_from(last_place(n), g % side_count(), *p);
            if (!in_cells_ && seen.y == n) return std::nullopt;
            return Term{static_cast<std::int16_t>(beyond), static_cast<std::int16_t>(seen.x),
                        static_cast<std::int16_t>(seen.y), 0};
        }
        ++beyond;
    }
    return std::nullopt;
}

/// The rows inside, and how far from the sides they hold.
bool RepeatedRows::learn_inside(const RootLayout& coarse, const RootLayout& fine, std::span<const int> coarse_number,
                                std::span<const int> fine_vertex, const StencilTable& rows) {
    const std::uint32_t m = fine.segments(), sides = side_count(), last = last_place(m);
    inside_.assign(std::size_t{factor_} * factor_, {});
    const auto offsets = [&](std::uint32_t f, std::uint32_t x, std::uint32_t y, std::vector<Offset>& out) {
        out.clear();
        const int row = fine_vertex[number_at(fine, f, {x, y})];
        const auto points = rows.points(row);
        for (std::size_t i = 0; i < points.size(); ++i) {
            const auto p = place_in(coarse, f, static_cast<std::uint32_t>(coarse_number[points[i]]));
            if (!p) return false;
            out.push_back({static_cast<int>(p->x) - static_cast<int>(x / factor_),
                           static_cast<int>(p->y) - static_cast<int>(y / factor_), rows.weights(row)[i]});
        }
        std::sort(out.begin(), out.end(),
                  [](const Offset& s, const Offset& t) { return std::pair(s.dy, s.dx) < std::pair(t.dy, t.dx); });
        return true;
    };
    // From the middle of the first root.
    const std::uint32_t middle = sides == 4 ? m / 2 - (in_cells_ ? 1 : 0) : m / 3;
    for (std::uint32_t y = middle; y < middle + factor_; ++y)
        for (std::uint32_t x = middle; x < middle + factor_; ++x)
            if (!offsets(0, x, y, inside_[y % factor_ * factor_ + x % factor_])) return false;
    const auto same = [&](const std::vector<Offset>& s, const std::vector<Offset>& t) {
        return std::equal(s.begin(), s.end(), t.begin(), t.end(), [](const Offset& a, const Offset& b) {
            return a.dx == b.dx && a.dy == b.dy && std::abs(a.weight - b.weight) <= k_same_weight;
        });
    };
    const std::uint32_t least = in_cells_ ? 0 : 1;
    depth_ = least;
    std::vector<Offset> found;
    for (std::uint32_t f = 0; f < base_.face_count; ++f)
        for (std::uint32_t y = least; y + least <= last; ++y)
            for (std::uint32_t x = least; x + least + (sides == 4 ? 0 : y) <= last; ++x) {
                const std::uint32_t nearest =
                    sides == 4 ? std::min({x, y, last - x, last - y}) : std::min({x, y, last - x - y});
                if (nearest < depth_) continue;
                if (!offsets(f, x, y, found) || !same(found, inside_[y % factor_ * factor_ + x % factor_]))
                    depth_ = nearest + 1;
            }
    return true;
}

bool RepeatedRows::learn(const RootLayout& coarse, const RootLayout& fine, std::span<const int> coarse_number,
                         std::span<const int> fine_vertex, const StencilTable& rows) {
    const std::uint32_t m = last_place(fine.segments()), sides = side_count();
    if (!learn_inside(coarse, fine, coarse_number, fine_vertex, rows)) return false;
    // Along a side there must be places for all remainders, as far from one corner as from the other.
    const std::uint32_t longest = sides == 4 ? m : m - depth_ + 1;
    if (depth_ < 1 || longest + 1 < factor_ + 2 * depth_) return false;
    reach_ = (longest + 1 - factor_) / 2;
    corner_places_.clear();
    for (std::uint32_t b = 0; b < reach_; ++b)
        for (std::uint32_t a = 0; a < reach_; ++a)
            if (a < depth_ || b < depth_) corner_places_.push_back({a, b});

    const auto add_row = [&](std::uint32_t h, std::uint32_t a, std::uint32_t b, auto&& term_at, Row& out) {
        out.clear();
        const int row = fine_vertex[number(fine, h, a, b)];
        const auto points = rows.points(row);
        for (std::size_t i = 0; i < points.size(); ++i) {
            std::optional<Term> term = term_at(coarse, h, static_cast<std::uint32_t>(coarse_number[points[i]]));
            if (!term) return false;
            term->weight = rows.weights(row)[i];
            out.push_back(*term);
        }
        std::sort(out.begin(), out.end());
        return true;
    };
    const auto corner_term = [&](auto&&... args) { return at_corner(args...); };
    const auto side_term = [&](auto&&... args) { return at_side(args...); };
    const std::uint32_t halfedges = base_.halfedge_count();
    std::map<Pattern, std::uint32_t> corners, along;
    const auto kept = [](std::map<Pattern, std::uint32_t>& patterns, Pattern& pattern) {
        return patterns.try_emplace(pattern, static_cast<std::uint32_t>(patterns.size())).first->second;
    };
    corner_pattern_.resize(halfedges);
    side_pattern_.resize(halfedges);
    Pattern pattern;
    Row other;
    for (std::uint32_t h = 0; h < halfedges; ++h) {
        pattern.resize(corner_places_.size());
        for (std::size_t i = 0; i < corner_places_.size(); ++i)
            if (!add_row(h, corner_places_[i].x, corner_places_[i].y, corner_term, pattern[i])) return false;
        corner_pattern_[h] = kept(corners, pattern);

        pattern.resize(std::size_t{depth_} * factor_);
        for (std::uint32_t b = 0; b < depth_; ++b)
            for (std::uint32_t a = reach_; rest(m, a, b) >= reach_ && a + b <= m; ++a) {
                Row& row = pattern[b * factor_ + (a - reach_) % factor_];
                if (a < reach_ + factor_) {
                    if (!add_row(h, a, b, side_term, row)) return false;
                    continue;
                }
                // Another place of the same kind: the rows there must be the same ones.
                const int shift = static_cast<int>((a - reach_) / factor_);
                if (!add_row(h, a, b, side_term, other)) return false;
                for (Term& term : other) term.a = static_cast<std::int16_t>(term.a + (term.turn == 0 ? -shift : shift));
                std::sort(other.begin(), other.end());
                if (!std::equal(row.begin(), row.end(), other.begin(), other.end(), [](const Term& s, const Term& t) {
                        return s.turn == t.turn && s.a == t.a && s.b == t.b &&
                               std::abs(s.weight - t.weight) <= k_same_weight;
                    }))
                    return false;
            }
        side_pattern_[h] = kept(along, pattern);
    }
    const auto listed = [](std::map<Pattern, std::uint32_t>& patterns) {
        std::vector<Pattern> list(patterns.size());
        for (const auto& [rows_of, i] : patterns) list[i] = rows_of;
        return list;
    };
    corner_patterns_ = listed(corners);
    side_patterns_ = listed(along);
    return true;
}

}  // namespace tetrakis::detail
