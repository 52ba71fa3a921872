#include "tetrakis/refine/repeated_rows.hpp"

#include "tetrakis/hier/parallel.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <map>
#include <utility>

// What a step of the rules says, in terms that hold for all later ones.
namespace tetrakis::detail {

namespace {

constexpr std::uint32_t k_roots_per_task = 16;
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
bool RepeatedRows::learn_inside(const Lesson& lesson) {
    const std::uint32_t m = lesson.fine.segments(), sides = side_count(), last = last_place(m);
    inside_.assign(std::size_t{factor_} * factor_, {});
    const auto offsets = [&](std::uint32_t f, std::uint32_t x, std::uint32_t y, std::vector<Offset>& out) {
        out.clear();
        const int row = lesson.fine_vertex[number_at(lesson.fine, f, {x, y})];
        const auto points = lesson.rows.points(row);
        for (std::size_t i = 0; i < points.size(); ++i) {
            const auto p = place_in(lesson.coarse, f, lesson.number(points[i]));
            if (!p) return false;
            out.push_back({static_cast<int>(p->x) - static_cast<int>(x / factor_),
                           static_cast<int>(p->y) - static_cast<int>(y / factor_), lesson.rows.weights(row)[i]});
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
    std::atomic<std::uint32_t> depth = least;
    for_each_block(base_.face_count, k_roots_per_task, [&](std::uint32_t begin, std::uint32_t end) {
        std::vector<Offset> found;
        std::uint32_t deepest = least;
        for (std::uint32_t f = begin; f < end; ++f)
            for (std::uint32_t y = least; y + least <= last; ++y)
                for (std::uint32_t x = least; x + least + (sides == 4 ? 0 : y) <= last; ++x) {
                    const std::uint32_t nearest =
                        sides == 4 ? std::min({x, y, last - x, last - y}) : std::min({x, y, last - x - y});
                    if (nearest < deepest) continue;
                    if (!offsets(f, x, y, found) || !same(found, inside_[y % factor_ * factor_ + x % factor_]))
                        deepest = nearest + 1;
                }
        for (std::uint32_t known = depth; known < deepest && !depth.compare_exchange_weak(known, deepest);) {
        }
    });
    depth_ = depth;
    return true;
}

template <class TermAt>
bool RepeatedRows::row_of(const Lesson& lesson, std::uint32_t h, const Place& place, const TermAt& term_at,
                          Row& out) const {
    out.clear();
    const int row = lesson.fine_vertex[number(lesson.fine, h, place.x, place.y)];
    const auto points = lesson.rows.points(row);
    for (std::size_t i = 0; i < points.size(); ++i) {
        std::optional<Term> term = term_at(lesson.number(points[i]));
        if (!term) return false;
        term->weight = lesson.rows.weights(row)[i];
        out.push_back(*term);
    }
    std::sort(out.begin(), out.end());
    return true;
}

bool RepeatedRows::corner_rows(const Lesson& lesson, std::uint32_t h, Pattern& out) const {
    out.resize(corner_places_.size());
    const auto term_at = [&](std::uint32_t number) { return at_corner(lesson.coarse, h, number); };
    for (std::size_t i = 0; i < corner_places_.size(); ++i)
        if (!row_of(lesson, h, corner_places_[i], term_at, out[i])) return false;
    return true;
}

bool RepeatedRows::side_rows(const Lesson& lesson, std::uint32_t h, Pattern& out) const {
    const std::uint32_t m = last_place(lesson.fine.segments());
    out.resize(std::size_t{depth_} * factor_);
    const auto term_at = [&](std::uint32_t number) { return at_side(lesson.coarse, h, number); };
    const auto same = [](const Term& s, const Term& t) {
        return s.turn == t.turn && s.a == t.a && s.b == t.b && std::abs(s.weight - t.weight) <= k_same_weight;
    };
    Row other;
    for (std::uint32_t b = 0; b < depth_; ++b)
        for (std::uint32_t a = reach_; a + b <= m && rest(m, a, b) >= reach_; ++a) {
            Row& row = out[b * factor_ + (a - reach_) % factor_];
            if (a < reach_ + factor_) {
                if (!row_of(lesson, h, {a, b}, term_at, row)) return false;
                continue;
            }
            // Another place of the same kind: the rows there must be the same ones.
            const int shift = static_cast<int>((a - reach_) / factor_);
            if (!row_of(lesson, h, {a, b}, term_at, other)) return false;
            for (Term& term : other) term.a = static_cast<std::int16_t>(term.a + (term.turn == 0 ? -shift : shift));
            std::sort(other.begin(), other.end());
            if (!std::equal(row.begin(), row.end(), other.begin(), other.end(), same)) return false;
        }
    return true;
}

bool RepeatedRows::learn(const Lesson& lesson) {
    const std::uint32_t m = last_place(lesson.fine.segments());
    if (!learn_inside(lesson)) return false;
    // Along a side there must be places for all remainders, as far from one corner as from the other, and one more to
    // compare with: a corner's influence would be seen there from one side only. Rules that reach one ring need none.
    const std::uint32_t longest = side_count() == 4 ? m : m - depth_ + 1, places = factor_ + (depth_ > 1 ? 1 : 0);
    if (depth_ < 1 || longest + 1 < places + 2 * depth_) return false;
    reach_ = (longest + 1 - places) / 2;
    corner_places_.clear();
    for (std::uint32_t b = 0; b < reach_; ++b)
        for (std::uint32_t a = 0; a < reach_; ++a)
            if (a < depth_ || b < depth_) corner_places_.push_back({a, b});

    // Block by block, so that patterns have the same numbers whatever the threads; few of them differ.
    struct Found {
        std::map<Pattern, std::uint32_t> number;
        std::vector<std::uint32_t> of;  // of each of the block's half-edges

        void add(const Pattern& pattern) {
            of.push_back(number.try_emplace(pattern, static_cast<std::uint32_t>(number.size())).first->second);
        }
        /// Adds them to all, and says which each half-edge has.
        void join(std::map<Pattern, std::uint32_t>& all, std::vector<std::uint32_t>& of_all) const {
            std::vector<const Pattern*> in_order(number.size());
            for (const auto& [pattern, i] : number) in_order[i] = &pattern;
            std::vector<std::uint32_t> renamed;
            for (const Pattern* pattern : in_order)
                renamed.push_back(all.try_emplace(*pattern, static_cast<std::uint32_t>(all.size())).first->second);
            for (const std::uint32_t i : of) of_all.push_back(renamed[i]);
        }
    };
    constexpr std::uint32_t k_block = 256;
    const std::uint32_t halfedges = base_.halfedge_count(), blocks = (halfedges + k_block - 1) / k_block;
    std::vector<Found> corners(blocks), sides(blocks);
    std::atomic<bool> fits = true;
    for_each_index(
        blocks,
        [&](std::uint32_t i) {
            Pattern pattern;
            for (std::uint32_t h = i * k_block; h < std::min(halfedges, (i + 1) * k_block) && fits; ++h) {
                if (!corner_rows(lesson, h, pattern)) fits = false;
                corners[i].add(pattern);
                if (!side_rows(lesson, h, pattern)) fits = false;
                sides[i].add(pattern);
            }
        },
        1);
    if (!fits) return false;
    const auto join = [&](const std::vector<Found>& found, std::vector<Pattern>& patterns,
                          std::vector<std::uint32_t>& of) {
        std::map<Pattern, std::uint32_t> all;
        of.clear();
        for (const Found& block : found) block.join(all, of);
        patterns.resize(all.size());
        for (const auto& [pattern, i] : all) patterns[i] = pattern;
    };
    join(corners, corner_patterns_, corner_pattern_);
    join(sides, side_patterns_, side_pattern_);
    return true;
}

}  // namespace tetrakis::detail
