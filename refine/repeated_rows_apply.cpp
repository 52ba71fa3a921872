#include "tetrakis/refine/repeated_rows.hpp"

#include "tetrakis/hier/huge_buffer.hpp"
#include "tetrakis/hier/parallel.hpp"

#include <algorithm>
#include <cstring>

// The rows read again, at the places of later levels.
namespace tetrakis::detail {

namespace {

/// `Points` points that lie `factor` apart, from coarse ones side by side.
template <std::uint32_t Points, class Terms>
void combine(const double* at, const Terms& terms, std::ptrdiff_t stride, std::uint32_t factor, Vec3d* to) {
    double sum[3 * Points] = {};
    for (const auto& term : terms) {
        const double* const p = at + 3 * (term.dx + term.dy * stride);
        for (std::uint32_t k = 0; k < 3 * Points; ++k) sum[k] += term.weight * p[k];
    }
    for (std::uint32_t i = 0; i < Points; ++i) to[i * factor] = Vec3d(sum[3 * i], sum[3 * i + 1], sum[3 * i + 2]);
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

struct RepeatedRows::Work {
    std::vector<Vec3d> lattice;  ///< a root of the coarser level with its sides: rows of N + 1
    std::vector<Vec3d> beyond;   ///< lines of its neighbour beside a side: N + 1 points each
    std::vector<std::uint32_t> numbers;
    /// Of a row along a side: the next point's, and how far on the one after that is.
    struct Term {
        const Vec3d* point;
        std::ptrdiff_t step;
        double weight;
    };
    std::vector<Term> terms;
};

void RepeatedRows::refine(std::span<const Vec3d> control, std::span<Vec3d> points, const RunContext& context) const {
    const std::vector<double> net = levels_->net({&control.data()->x, 3 * control.size()}, 3);
    HugeBuffer<double> buffers[2];
    const auto buffer = [&](std::size_t i) -> Vec3d* {
        if (i + 1 == segments_.size()) return points.data();
        return reinterpret_cast<Vec3d*>(
            buffers[i & 1].reserve(3 * std::size_t{points_of(RootLayout(base_, segments_[i]))}));
    };
    Vec3d* now = buffer(0);
    for_each_index(static_cast<std::uint32_t>(vertices_.size()), [&](std::uint32_t i) {
        std::memcpy(static_cast<void*>(now + i), net.data() + 3 * static_cast<std::size_t>(vertices_[i]),
                    sizeof(Vec3d));
    });
    for (std::size_t i = 1; i < segments_.size(); ++i) {
        context.report("refine", static_cast<double>(i) / static_cast<double>(segments_.size()));
        Vec3d* const finer = buffer(i);
        step(RootLayout(base_, segments_[i - 1]), RootLayout(base_, segments_[i]), now, finer);
        now = finer;
    }
}

void RepeatedRows::step(const RootLayout& coarse, const RootLayout& fine, const Vec3d* in, Vec3d* out) const {
    const std::uint32_t n = last_place(coarse.segments()), sides = side_count();
    for (std::uint32_t v = 0; v < base_.vertex_count && !in_cells_; ++v)
        if (base_.vertex_halfedge[v] == none) out[v] = in[v];
    for_each_block(base_.face_count, k_grain, [&](std::uint32_t begin, std::uint32_t end) {
        Work work;
        work.lattice.resize(std::size_t{n + 1} * (n + 1));
        for (std::uint32_t f = begin; f < end; ++f) {
            for (std::uint32_t y = 0; y <= n; ++y) {
                Vec3d* const row = work.lattice.data() + std::size_t{y} * (n + 1);
                const std::uint32_t last = sides == 4 ? n : n - y;
                if (in_cells_) {
                    std::copy_n(in + number_at(coarse, f, {0, y}), last + 1, row);
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
            inside(coarse, fine, f, out, work);
            for (std::uint32_t h = sides * f; h < sides * (f + 1); ++h) {
                side(coarse, fine, h, in, out, work);
                corner(coarse, fine, h, in, out);
            }
        }
    });
}

void RepeatedRows::inside(const RootLayout& coarse, const RootLayout& fine, std::uint32_t f, Vec3d* out,
                          const Work& work) const {
    const std::uint32_t m = last_place(fine.segments()), stride = last_place(coarse.segments()) + 1;
    constexpr std::uint32_t k_block = 4;  // points at a time: 12 numbers, in registers
    for (std::uint32_t y = depth_; y + depth_ <= m; ++y) {
        const std::uint32_t end = base_.face_size == 4 ? m - depth_ : m - depth_ - std::min(y, m - depth_);
        for (std::uint32_t first = depth_; first < depth_ + factor_ && first <= end; ++first) {
            const std::vector<Offset>& terms = inside_[y % factor_ * factor_ + first % factor_];
            const std::uint32_t count = (end - first) / factor_ + 1;
            const double* const at = &work.lattice[std::size_t{y / factor_} * stride + first / factor_].x;
            Vec3d* const to = out + number_at(fine, f, {first, y});
            if (count < k_block) {
                for (std::uint32_t i = 0; i < count; ++i)
                    combine<1>(at + 3 * std::size_t{i}, terms, stride, factor_, to + i * factor_);
                continue;
            }
            for (std::uint32_t i = 0; i < count; i += k_block) {
                // A last block that is not whole: with points before it once more.
                const std::uint32_t begin = std::min(i, count - k_block);
                combine<k_block>(at + 3 * std::size_t{begin}, terms, stride, factor_, to + begin * factor_);
            }
        }
    }
}

void RepeatedRows::side(const RootLayout& coarse, const RootLayout& fine, std::uint32_t h, const Vec3d* in, Vec3d* out,
                        Work& work) const {
    const std::uint32_t n = last_place(coarse.segments()), m = last_place(fine.segments()), t = base_.twin[h],
                        stride = n + 1;
    const std::uint32_t s = h % side_count();
    const Pattern& pattern = side_patterns_[side_pattern_[h]];
    std::uint32_t deepest = 0;
    for (const Row& row : pattern)
        for (const Term& term : row)
            if (term.turn == 1) deepest = std::max(deepest, static_cast<std::uint32_t>(term.b));
    work.beyond.resize(std::size_t{deepest + 1} * stride);
    for (std::uint32_t b = in_cells_ ? 0 : 1; t != none && b <= deepest; ++b)
        run_of(
            n - (side_count() == 3 ? b : 0) + 1, [&](std::uint32_t a) { return number(coarse, t, a, b); },
            [&](std::uint32_t a, std::uint32_t v) { work.beyond[std::size_t{b} * stride + a] = in[v]; });
    const auto own = [&](std::uint32_t a, std::uint32_t b) {
        const Place p = turned(n, s, a, b);
        return static_cast<std::ptrdiff_t>(std::size_t{p.y} * stride + p.x);
    };
    const std::ptrdiff_t along = own(1, 0) - own(0, 0), away = own(0, 1) - own(0, 0), origin = own(0, 0);
    const std::ptrdiff_t longer = static_cast<std::ptrdiff_t>(coarse.segments()) - template_segments_;
    const bool owns_edge = in_cells_ || (base_.edge_side[h] & 1) == 0;
    for (std::uint32_t b = owns_edge ? 0 : 1; b < depth_; ++b) {
        const std::uint32_t last = rest(m, reach_, b);
        if (last < reach_) continue;
        const std::uint32_t count = last - reach_ + 1;
        work.numbers.resize(count);
        run_of(
            count, [&](std::uint32_t i) { return number(fine, h, reach_ + i, b); },
            [&](std::uint32_t i, std::uint32_t v) { work.numbers[i] = v; });
        for (std::uint32_t kind = 0; kind < factor_ && kind < count; ++kind) {
            const Row& row = pattern[b * factor_ + kind];
            work.terms.clear();
            for (const Term& term : row) {
                if (term.turn == 0)
                    work.terms.push_back(
                        {work.lattice.data() + origin + term.a * along + term.b * away, along, term.weight});
                else
                    work.terms.push_back(
                        {work.beyond.data() + term.b * static_cast<std::ptrdiff_t>(stride) + term.a + longer, -1,
                         term.weight});
            }
            for (std::uint32_t i = kind; i < count; i += factor_) {
                Vec3d sum(0);
                for (Work::Term& term : work.terms) {
                    sum += term.weight * *term.point;
                    term.point += term.step;
                }
                out[work.numbers[i]] = sum;
            }
        }
    }
}

void RepeatedRows::corner(const RootLayout& coarse, const RootLayout& fine, std::uint32_t h, const Vec3d* in,
                          Vec3d* out) const {
    const bool owns_vertex = in_cells_ || base_.vertex_halfedge[base_.origin[h]] == h,
               owns_edge = in_cells_ || (base_.edge_side[h] & 1) == 0,
               owns_other = in_cells_ || (base_.edge_side[base_.prev(h)] & 1) == 0;
    const Pattern& pattern = corner_patterns_[corner_pattern_[h]];
    for (std::size_t i = 0; i < corner_places_.size(); ++i) {
        const Place place = corner_places_[i];
        if (place.x == 0 && place.y == 0 ? !owns_vertex : (place.y == 0 && !owns_edge) || (place.x == 0 && !owns_other))
            continue;
        Vec3d sum(0);
        // Terms come by turns, those against the clock first.
        std::uint32_t g = h;
        int turn = 0;
        for (const Term& term : pattern[i]) {
            for (; turn > term.turn; --turn) g = base_.next(base_.twin[g]);
            for (; turn < term.turn; ++turn) g = base_.twin[base_.prev(g)];
            sum += term.weight *
                   in[number(coarse, g, static_cast<std::uint32_t>(term.a), static_cast<std::uint32_t>(term.b))];
        }
        out[number(fine, h, place.x, place.y)] = sum;
    }
}

}  // namespace tetrakis::detail
