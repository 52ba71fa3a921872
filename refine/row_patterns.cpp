#include "tetrakis/refine/row_patterns.hpp"

#include "tetrakis/hier/parallel.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <map>
#include <utility>

// What the rules say of a level, in terms that hold for all finer ones.
namespace tetrakis::detail {

namespace {

constexpr std::uint32_t k_roots_per_task = 16;

/// Weights of one row found in two places differ by rounding at most; tangents come from numeric eigenvectors.
double same_weight(RowPatterns::Kind kind) { return kind == RowPatterns::Kind::points ? 1e-13 : 1e-11; }

/// Two rows of weights of the same points, turned and mixed until they are the same ones whichever base of their plane
/// they were given as (with its orientation): with 1, 0 in the first column that is large, 0, +-1 in the second one.
template <class Column>
void make_canonical(std::vector<Column>& columns) {
    constexpr double k_large = 0.1;
    const auto first_large = [&](const auto& size) {
        double largest = 0;
        for (const Column& c : columns) largest = std::max(largest, size(c));
        return std::find_if(columns.begin(), columns.end(),
                            [&](const Column& c) { return size(c) > 0 && size(c) >= k_large * largest; });
    };
    const auto pivot = first_large([](const Column& c) { return std::hypot(c.w1, c.w2); });
    if (pivot == columns.end()) return;
    const double length = std::hypot(pivot->w1, pivot->w2), c1 = pivot->w1 / length, c2 = pivot->w2 / length;
    for (Column& c : columns) {
        const double along = (c1 * c.w1 + c2 * c.w2) / length, across = (c1 * c.w2 - c2 * c.w1) / length;
        c.w1 = along;
        c.w2 = across;
    }
    pivot->w1 = 1;
    pivot->w2 = 0;
    const auto other = first_large([](const Column& c) { return std::abs(c.w2); });
    if (other == columns.end()) return;
    const double scale = 1 / std::abs(other->w2), factor = other->w1 / other->w2;
    for (Column& c : columns) {
        c.w1 -= factor * c.w2;
        c.w2 *= scale;
    }
    other->w1 = 0;
}

}  // namespace

RowPatterns::Places::Places(std::span<const int> vertices) : next(vertices.size(), -1) {
    for (std::size_t i = vertices.size(); i-- > 0;) {
        const auto v = static_cast<std::size_t>(vertices[i]);
        if (v >= first.size()) first.resize(v + 1, -1);
        next[i] = std::exchange(first[v], static_cast<int>(i));
    }
}

/// By points, and by weights that differ by more than rounding.
struct RowPatterns::PatternOrder {
    double tolerance;

    std::strong_ordering compare(const Row& a, const Row& b) const {
        for (std::size_t i = 0; i < a.size() && i < b.size(); ++i) {
            if (const auto c = a[i].at <=> b[i].at; c != 0) return c;
        }
        if (const auto c = a.size() <=> b.size(); c != 0) return c;
        // Snapped: an order must be transitive.
        const auto snapped = [&](double weight) { return std::llround(weight / tolerance); };
        for (std::size_t i = 0; i < a.size(); ++i)
            if (const auto c = snapped(a[i].weight) <=> snapped(b[i].weight); c != 0) return c;
        return std::strong_ordering::equal;
    }
    bool operator()(const Pattern& a, const Pattern& b) const {
        for (std::size_t i = 0; i < a.size(); ++i)
            if (const auto c = compare(a[i], b[i]); c != 0) return c < 0;
        return false;
    }
    bool same(const Row& a, const Row& b) const {
        return std::equal(a.begin(), a.end(), b.begin(), b.end(), [&](const Term& s, const Term& t) {
            return s.at == t.at && std::abs(s.weight - t.weight) <= tolerance;
        });
    }
};

/// The rows of a vertex; those that it has no tangents for are empty.
template <class SeenAt>
bool RowPatterns::rows_of(const Lesson& lesson, int fine_vertex, const SeenAt& seen_at, std::span<Row> out) const {
    for (Row& row : out) row.clear();
    const auto terms = [&](const StencilTable& table, int row, Row& to) {
        const auto points = table.points(row);
        for (std::size_t i = 0; i < points.size(); ++i) {
            std::optional<Seen> seen;
            for (int place = lesson.places.first[points[i]]; place >= 0 && !seen; place = lesson.places.next[place])
                seen = seen_at(static_cast<std::uint32_t>(place));
            if (!seen) return false;
            to.push_back({*seen, table.weights(row)[i]});
        }
        std::sort(to.begin(), to.end(), [](const Term& s, const Term& t) { return s.at < t.at; });
        return true;
    };
    if (kind_ == Kind::points) return terms(lesson.rows, fine_vertex, out[0]);

    const int begin = lesson.begin[static_cast<std::size_t>(fine_vertex)],
              end = lesson.begin[static_cast<std::size_t>(fine_vertex) + 1];
    std::size_t found = 0;
    struct Column {
        Seen at;
        double w1, w2;
    };
    std::vector<Column> columns;
    Row rows[2];
    for (int i = begin; i < end; ++i) {
        for (Row& row : rows) row.clear();
        if (!terms(lesson.rows, i, rows[0]) || !terms(*lesson.second_rows, i, rows[1])) {
            if (lesson.places.several(fine_vertex)) continue;  // of a crease's other side
            return false;
        }
        if (2 * found + 2 > out.size()) return false;
        columns.clear();
        for (auto a = rows[0].begin(), b = rows[1].begin(); a != rows[0].end() || b != rows[1].end();) {
            const bool first = b == rows[1].end() || (a != rows[0].end() && a->at <= b->at),
                       second = a == rows[0].end() || (b != rows[1].end() && b->at <= a->at);
            columns.push_back({first ? a->at : b->at, first ? a->weight : 0, second ? b->weight : 0});
            if (first) ++a;
            if (second) ++b;
        }
        make_canonical(columns);
        Row* const pair = &out[2 * found++];
        constexpr double k_no_weight = 1e-12;
        for (const Column& c : columns) {
            if (std::abs(c.w1) > k_no_weight) pair[0].push_back({c.at, c.w1});
            if (std::abs(c.w2) > k_no_weight) pair[1].push_back({c.at, c.w2});
        }
    }
    // Which of two surfaces comes first the rules leave open.
    if (found == 2) {
        const PatternOrder order{same_weight(kind_)};
        const auto c = order.compare(out[0], out[2]);
        if (c > 0 || (c == 0 && order.compare(out[1], out[3]) > 0)) {
            std::swap(out[0], out[2]);
            std::swap(out[1], out[3]);
        }
    }
    return true;
}

/// The rows inside, and how far from the sides they hold.
bool RowPatterns::learn_inside(const Lesson& lesson) {
    const std::uint32_t m = lesson.fine.segments(), sides = net_.side_count(), last = net_.last_place(lesson.fine),
                        count = rows_inside();
    inside_.assign(std::size_t{factor_} * factor_ * count, {});
    const auto rows_at = [&](std::uint32_t f, std::uint32_t x, std::uint32_t y, std::span<Row> out) {
        const int dx = static_cast<int>(x / factor_), dy = static_cast<int>(y / factor_);
        const auto seen = [&](std::uint32_t number) -> std::optional<Seen> {
            const auto p = net_.place_in(lesson.coarse, f, number);
            if (!p) return std::nullopt;
            return Seen{0, static_cast<std::int16_t>(static_cast<int>(p->x) - dx),
                        static_cast<std::int16_t>(static_cast<int>(p->y) - dy)};
        };
        return rows_of(lesson, lesson.fine_vertex[net_.number_at(lesson.fine, f, {x, y})], seen, out);
    };
    const auto known = [&](std::uint32_t x, std::uint32_t y) {
        return std::span(&inside_[(y % factor_ * factor_ + x % factor_) * std::size_t{count}], count);
    };
    // From the middle of the first root.
    const std::uint32_t middle = sides == 4 ? m / 2 - (net_.in_cells() ? 1 : 0) : m / 3;
    for (std::uint32_t y = middle; y < middle + factor_; ++y)
        for (std::uint32_t x = middle; x < middle + factor_; ++x)
            if (!rows_at(0, x, y, known(x, y)) || known(x, y).back().empty()) return false;
    const PatternOrder order{same_weight(kind_)};
    const std::uint32_t least = net_.in_cells() ? 0 : 1;
    std::atomic<std::uint32_t> depth = least;
    for_each_block(net_.base().face_count, k_roots_per_task, [&](std::uint32_t begin, std::uint32_t end) {
        std::vector<Row> found(count);
        std::uint32_t deepest = least;
        const auto fits = [&](std::uint32_t f, std::uint32_t x, std::uint32_t y) {
            if (!rows_at(f, x, y, found)) return false;
            return std::equal(found.begin(), found.end(), known(x, y).begin(),
                              [&](const Row& a, const Row& b) { return order.same(a, b); });
        };
        for (std::uint32_t f = begin; f < end; ++f)
            for (std::uint32_t y = least; y + least <= last; ++y)
                for (std::uint32_t x = least; x + least + (sides == 4 ? 0 : y) <= last; ++x) {
                    const std::uint32_t nearest =
                        sides == 4 ? std::min({x, y, last - x, last - y}) : std::min({x, y, last - x - y});
                    if (nearest >= deepest && !fits(f, x, y)) deepest = nearest + 1;
                }
        for (std::uint32_t now = depth; now < deepest && !depth.compare_exchange_weak(now, deepest);) {
        }
    });
    depth_ = depth;
    return true;
}

bool RowPatterns::corner_rows(const Lesson& lesson, std::uint32_t h, Pattern& out) const {
    const std::size_t each = rows_per_point();
    out.resize(corner_places_.size() * each);
    const auto seen_at = [&](std::uint32_t number) { return net_.at_corner(lesson.coarse, h, number); };
    for (std::size_t i = 0; i < corner_places_.size(); ++i) {
        const int v = lesson.fine_vertex[net_.number(lesson.fine, h, corner_places_[i].x, corner_places_[i].y)];
        if (!rows_of(lesson, v, seen_at, std::span(out).subspan(i * each, each))) return false;
    }
    return true;
}

bool RowPatterns::side_rows(const Lesson& lesson, std::uint32_t h, Pattern& out) const {
    const std::uint32_t m = net_.last_place(lesson.fine);
    const std::size_t each = rows_per_point();
    out.resize(std::size_t{depth_} * factor_ * each);
    const auto seen_at = [&](std::uint32_t number) { return net_.at_side(lesson.coarse, h, number); };
    const PatternOrder order{same_weight(kind_)};
    std::vector<Row> other(each);
    for (std::uint32_t b = 0; b < depth_; ++b)
        for (std::uint32_t a = reach_; a + b <= m && net_.rest(m, a, b) >= reach_; ++a) {
            const std::span<Row> rows = std::span(out).subspan((b * factor_ + (a - reach_) % factor_) * each, each);
            const int v = lesson.fine_vertex[net_.number(lesson.fine, h, a, b)];
            if (a < reach_ + factor_) {
                if (!rows_of(lesson, v, seen_at, rows)) return false;
                continue;
            }
            // Another place of the same kind: the rows there must be the same ones.
            const int shift = static_cast<int>((a - reach_) / factor_);
            const auto shifted = [&](std::uint32_t number) {
                std::optional<Seen> seen = seen_at(number);
                if (seen) seen->a = static_cast<std::int16_t>(seen->a + (seen->turn == 0 ? -shift : shift));
                return seen;
            };
            if (!rows_of(lesson, v, shifted, other)) return false;
            for (std::size_t i = 0; i < each; ++i)
                if (!order.same(rows[i], other[i])) return false;
        }
    return true;
}

bool RowPatterns::learn(const Lesson& lesson) {
    const std::uint32_t m = net_.last_place(lesson.fine);
    template_segments_ = static_cast<std::ptrdiff_t>(lesson.coarse.segments());
    if (!learn_inside(lesson)) return false;
    // Along a side there must be places for all remainders, as far from one corner as from the other, and one more to
    // compare with: a corner's influence would be seen there from one side only. Rules that reach one ring need none.
    const std::uint32_t longest = net_.side_count() == 4 ? m : m - depth_ + 1, places = factor_ + (depth_ > 1 ? 1 : 0);
    if (depth_ < 1 || longest + 1 < places + 2 * depth_) return false;
    reach_ = (longest + 1 - places) / 2;
    corner_places_.clear();
    for (std::uint32_t b = 0; b < reach_; ++b)
        for (std::uint32_t a = 0; a < reach_; ++a)
            if (a < depth_ || b < depth_) corner_places_.push_back({a, b});

    // Block by block, so that patterns have the same numbers whatever the threads; few of them differ.
    using Numbers = std::map<Pattern, std::uint32_t, PatternOrder>;
    const PatternOrder order{same_weight(kind_)};
    struct Found {
        Numbers number;
        std::vector<std::uint32_t> of;  // of each of the block's half-edges

        void add(const Pattern& pattern) {
            of.push_back(number.try_emplace(pattern, static_cast<std::uint32_t>(number.size())).first->second);
        }
        /// Adds them to all, and says which each half-edge has.
        void join(Numbers& all, std::vector<std::uint32_t>& of_all) const {
            std::vector<const Pattern*> in_order(number.size());
            for (const auto& [pattern, i] : number) in_order[i] = &pattern;
            std::vector<std::uint32_t> renamed;
            for (const Pattern* pattern : in_order)
                renamed.push_back(all.try_emplace(*pattern, static_cast<std::uint32_t>(all.size())).first->second);
            for (const std::uint32_t i : of) of_all.push_back(renamed[i]);
        }
    };
    constexpr std::uint32_t k_block = 256;
    const std::uint32_t halfedges = net_.base().halfedge_count(), blocks = (halfedges + k_block - 1) / k_block;
    std::vector<Found> corners(blocks, Found{Numbers(order), {}}), sides(corners);
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
        Numbers all(order);
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
