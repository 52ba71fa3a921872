#include "tetrakis/refine/row_patterns.hpp"

#include "tetrakis/hier/parallel.hpp"

#include <algorithm>

// The rows read again, at the places of finer levels.
namespace tetrakis::detail {

namespace {

constexpr std::uint32_t k_roots_at_once = 4;  // roots per task

/// What a result is made of, and how.
struct PointOfRow {
    static constexpr std::size_t rows = 1, rows_inside = 1;
    static Vec3d result(const Vec3d* sums) { return sums[0]; }
};
struct NormalOfTangents {
    static constexpr std::size_t rows = 4, rows_inside = 2;
    static Vec3d result_inside(const Vec3d* sums) { return unit_or_zero(glm::cross(sums[0], sums[1])); }
    static Vec3d result(const Vec3d* sums) { return unit_of_sum(result_inside(sums) + result_inside(sums + 2)); }
};

/// Sums of rows for `Points` points side by side.
template <std::uint32_t Points, class Terms>
void combine(const double* at, const Terms& terms, Vec3d* sums) {
    double sum[3 * Points] = {};
    for (const auto& term : terms) {
        const double* const p = at + term.offset;
        for (std::uint32_t k = 0; k < 3 * Points; ++k) sum[k] += term.weight * p[k];
    }
    for (std::uint32_t i = 0; i < Points; ++i) sums[i] = Vec3d(sum[3 * i], sum[3 * i + 1], sum[3 * i + 2]);
}

/// Results that lie `factor` apart, from points side by side.
template <class Finish, std::uint32_t Points, class Terms>
void results(const double* at, const Terms* rows, std::uint32_t factor, Vec3d* to) {
    Vec3d sums[Finish::rows_inside][Points];
    for (std::size_t r = 0; r < Finish::rows_inside; ++r) combine<Points>(at, rows[r], sums[r]);
    for (std::uint32_t i = 0; i < Points; ++i) {
        if constexpr (Finish::rows_inside == 1) {
            to[i * factor] = sums[0][i];
        } else {
            const Vec3d pair[2] = {sums[0][i], sums[1][i]};
            to[i * factor] = Finish::result_inside(pair);
        }
    }
}

/// Calls visit(i, number(i)) for each i < count of a line of RootLayout, whose inner numbers have one second
/// difference.
template <class Number, class Visit>
void run_of(std::uint32_t count, const Number& number, const Visit& visit) {
    if (count < 6) {
        for (std::uint32_t i = 0; i < count; ++i) visit(i, number(i));
        return;
    }
    visit(0, number(0));
    std::uint32_t v = number(1), step = number(2) - v;
    const std::uint32_t turn = number(3) - number(2) - step;
    for (std::uint32_t i = 1; i + 1 < count; ++i) {
        visit(i, v);
        v += step;
        step += turn;
    }
    visit(count - 1, number(count - 1));
}

}  // namespace

struct RowPatterns::Work {
    std::vector<Vec3d> lattice;  ///< a root of the points' level with its sides: rows of N + 1
    std::vector<Vec3d> beyond;   ///< lines of its neighbour beside a side: N + 1 points each
    std::vector<std::uint32_t> numbers;
    /// Of a row inside: in numbers of the lattice from the point's place.
    struct InnerTerm {
        std::ptrdiff_t offset;
        double weight;
    };
    std::vector<std::vector<InnerTerm>> inside;
    /// Of a row along a side: the next point's, and how far on the one after that is.
    struct SideTerm {
        const Vec3d* point;
        std::ptrdiff_t step;
        double weight;
    };
    std::vector<SideTerm> terms;
    std::vector<std::size_t> row_ends;  ///< in the terms
};

void RowPatterns::apply(const RootLayout& coarse, const RootLayout& fine, const Vec3d* in, Vec3d* out) const {
    if (kind_ == Kind::points)
        apply<PointOfRow>(coarse, fine, in, out);
    else
        apply<NormalOfTangents>(coarse, fine, in, out);
}

template <class Finish>
void RowPatterns::apply(const RootLayout& coarse, const RootLayout& fine, const Vec3d* in, Vec3d* out) const {
    const MeshLevel& base = net_.base();
    const std::uint32_t n = net_.last_place(coarse), sides = net_.side_count();
    for (std::uint32_t v = 0; v < base.vertex_count && !net_.in_cells(); ++v)
        if (base.vertex_halfedge[v] == none) out[v] = kind_ == Kind::points ? in[v] : Vec3d(0);
    for_each_block(base.face_count, k_roots_at_once, [&](std::uint32_t begin, std::uint32_t end) {
        Work work;
        work.lattice.resize(std::size_t{n + 1} * (n + 1));
        for (const Row& row : inside_) {
            work.inside.emplace_back();
            for (const Term& term : row)
                work.inside.back().push_back(
                    {3 * (term.at.a + term.at.b * static_cast<std::ptrdiff_t>(n + 1)), term.weight});
        }
        for (std::uint32_t f = begin; f < end; ++f) {
            for (std::uint32_t y = 0; y <= n; ++y) {
                Vec3d* const row = work.lattice.data() + std::size_t{y} * (n + 1);
                const std::uint32_t last = sides == 4 ? n : n - y;
                if (net_.in_cells()) {
                    std::copy_n(in + net_.number_at(coarse, f, {0, y}), last + 1, row);
                    continue;
                }
                const bool side_row = y == 0 || last < 2 || (sides == 4 && y == n);
                if (side_row) {
                    for (std::uint32_t x = 0; x <= last; ++x) row[x] = in[coarse.at(f, x, y)];
                    continue;
                }
                row[0] = in[coarse.at(f, 0, y)];
                row[last] = in[coarse.at(f, last, y)];
                std::copy_n(in + coarse.at(f, 1, y), last - 1, row + 1);
            }
            inside<Finish>(coarse, fine, f, out, work);
            for (std::uint32_t h = sides * f; h < sides * (f + 1); ++h) {
                side<Finish>(coarse, fine, h, in, out, work);
                corner<Finish>(coarse, fine, h, in, out);
            }
        }
    });
}

template <class Finish>
void RowPatterns::inside(const RootLayout& coarse, const RootLayout& fine, std::uint32_t f, Vec3d* out,
                         const Work& work) const {
    const std::uint32_t m = net_.last_place(fine), stride = net_.last_place(coarse) + 1;
    constexpr std::uint32_t k_block = 4;  // points at a time: 12 numbers, in registers
    for (std::uint32_t y = depth_; y + depth_ <= m; ++y) {
        const std::uint32_t end = net_.side_count() == 4 ? m - depth_ : m - depth_ - std::min(y, m - depth_);
        for (std::uint32_t first = depth_; first < depth_ + factor_ && first <= end; ++first) {
            const auto* const rows =
                &work.inside[(y % factor_ * factor_ + first % factor_) * std::size_t{Finish::rows_inside}];
            const std::uint32_t count = (end - first) / factor_ + 1;
            const double* const at = &work.lattice[std::size_t{y / factor_} * stride + first / factor_].x;
            Vec3d* const to = out + net_.number_at(fine, f, {first, y});
            if (count < k_block) {
                for (std::uint32_t i = 0; i < count; ++i)
                    results<Finish, 1>(at + 3 * std::size_t{i}, rows, factor_, to + i * factor_);
                continue;
            }
            for (std::uint32_t i = 0; i < count; i += k_block) {
                // A last block that is not whole: with points before it once more.
                const std::uint32_t begin = std::min(i, count - k_block);
                results<Finish, k_block>(at + 3 * std::size_t{begin}, rows, factor_, to + begin * factor_);
            }
        }
    }
}

template <class Finish>
void RowPatterns::side(const RootLayout& coarse, const RootLayout& fine, std::uint32_t h, const Vec3d* in, Vec3d* out,
                       Work& work) const {
    const MeshLevel& base = net_.base();
    const std::uint32_t n = net_.last_place(coarse), m = net_.last_place(fine), t = base.twin[h], stride = n + 1;
    const std::uint32_t s = h % net_.side_count();
    const Pattern& pattern = side_patterns_[side_pattern_[h]];
    std::uint32_t deepest = 0;
    for (const Row& row : pattern)
        for (const Term& term : row)
            if (term.at.turn == 1) deepest = std::max(deepest, static_cast<std::uint32_t>(term.at.b));
    work.beyond.resize(std::size_t{deepest + 1} * stride);
    for (std::uint32_t b = net_.in_cells() ? 0 : 1; t != none && b <= deepest; ++b)
        run_of(
            n - (net_.side_count() == 3 ? b : 0) + 1, [&](std::uint32_t a) { return net_.number(coarse, t, a, b); },
            [&](std::uint32_t a, std::uint32_t v) { work.beyond[std::size_t{b} * stride + a] = in[v]; });
    const auto own = [&](std::uint32_t a, std::uint32_t b) {
        const Place p = net_.turned(n, s, a, b);
        return static_cast<std::ptrdiff_t>(std::size_t{p.y} * stride + p.x);
    };
    const std::ptrdiff_t along = own(1, 0) - own(0, 0), away = own(0, 1) - own(0, 0), origin = own(0, 0);
    const std::ptrdiff_t longer = static_cast<std::ptrdiff_t>(coarse.segments()) - template_segments_;
    const bool owns_edge = net_.in_cells() || (base.edge_side[h] & 1) == 0;
    for (std::uint32_t b = owns_edge ? 0 : 1; b < depth_; ++b) {
        const std::uint32_t last = net_.rest(m, reach_, b);
        if (last < reach_) continue;
        const std::uint32_t count = last - reach_ + 1;
        work.numbers.resize(count);
        run_of(
            count, [&](std::uint32_t i) { return net_.number(fine, h, reach_ + i, b); },
            [&](std::uint32_t i, std::uint32_t v) { work.numbers[i] = v; });
        for (std::uint32_t kind = 0; kind < factor_ && kind < count; ++kind) {
            work.terms.clear();
            work.row_ends.clear();
            for (std::size_t r = 0; r < Finish::rows; ++r) {
                for (const Term& term : pattern[(b * factor_ + kind) * Finish::rows + r]) {
                    const Seen& at = term.at;
                    if (at.turn == 0)
                        work.terms.push_back(
                            {work.lattice.data() + origin + at.a * along + at.b * away, along, term.weight});
                    else
                        work.terms.push_back(
                            {work.beyond.data() + at.b * static_cast<std::ptrdiff_t>(stride) + at.a + longer, -1,
                             term.weight});
                }
                work.row_ends.push_back(work.terms.size());
            }
            for (std::uint32_t i = kind; i < count; i += factor_) {
                Vec3d sums[Finish::rows] = {};
                std::size_t next = 0;
                for (std::size_t r = 0; r < Finish::rows; ++r)
                    for (; next < work.row_ends[r]; ++next) {
                        Work::SideTerm& term = work.terms[next];
                        sums[r] += term.weight * *term.point;
                        term.point += term.step;
                    }
                out[work.numbers[i]] = Finish::result(sums);
            }
        }
    }
}

template <class Finish>
void RowPatterns::corner(const RootLayout& coarse, const RootLayout& fine, std::uint32_t h, const Vec3d* in,
                         Vec3d* out) const {
    const MeshLevel& base = net_.base();
    const bool cells = net_.in_cells(), owns_vertex = cells || base.vertex_halfedge[base.origin[h]] == h,
               owns_edge = cells || (base.edge_side[h] & 1) == 0,
               owns_other = cells || (base.edge_side[base.prev(h)] & 1) == 0;
    const Pattern& pattern = corner_patterns_[corner_pattern_[h]];
    for (std::size_t i = 0; i < corner_places_.size(); ++i) {
        const Place place = corner_places_[i];
        if (place.x == 0 && place.y == 0 ? !owns_vertex : (place.y == 0 && !owns_edge) || (place.x == 0 && !owns_other))
            continue;
        Vec3d sums[Finish::rows] = {};
        for (std::size_t r = 0; r < Finish::rows; ++r) {
            // Terms come by turns, those against the clock first.
            std::uint32_t g = h;
            int turn = 0;
            for (const Term& term : pattern[i * Finish::rows + r]) {
                for (; turn > term.at.turn; --turn) g = base.next(base.twin[g]);
                for (; turn < term.at.turn; ++turn) g = base.twin[base.prev(g)];
                sums[r] += term.weight * in[net_.number(coarse, g, static_cast<std::uint32_t>(term.at.a),
                                                        static_cast<std::uint32_t>(term.at.b))];
            }
        }
        out[net_.number(fine, h, place.x, place.y)] = Finish::result(sums);
    }
}

}  // namespace tetrakis::detail
