#include "row_patterns.hpp"

#include "../../hier/base/parallel.hpp"

#include <algorithm>
#include <cmath>

// Applies the stencil rows at all places of a level.
namespace tetrakis::detail {

namespace {

constexpr std::uint32_t k_roots_at_once = 4, k_results_at_once = 16384;  // per task

/// How a result is computed from its rows: a point by one sum, a normal by pairs of tangents.
struct PointOfRow {
    static constexpr std::size_t rows = 1, rows_inside = 1;
    static void run(const GridRow* rows, std::uint32_t count, std::uint32_t stride, Vec3d* to) {
        row_kernels().any(rows[0], count, stride, &to->x);
    }
    static Vec3d result(const Vec3d* sums) { return sums[0]; }
};
struct NormalOfTangents {
    static constexpr std::size_t rows = 4, rows_inside = 2;
    static void run(const GridRow* rows, std::uint32_t count, std::uint32_t /*stride*/, Vec3d* to) {
        row_kernels().normals(rows[0], rows[1], count, &to->x);  // stride 1: factor_ is 1
    }
    // A missing point is NaN (boundaries that recede), and so is each normal that is computed from it.
    static Vec3d unit_normal(const Vec3d* sums) {
        const Vec3d normal = glm::cross(sums[0], sums[1]);
        const double square = glm::dot(normal, normal);
        return square == 0 ? Vec3d(0) : normal * (1 / std::sqrt(square));
    }
    static Vec3d result(const Vec3d* sums) {
        const Vec3d sum = unit_normal(sums) + unit_normal(sums + 2);
        return std::isnan(sum.x) ? sum : unit_of_sum(sum);
    }
};

/// The sum of a row for the point at `at`.
Vec3d sum_of(const double* at, const std::vector<GridTerm>& row) {
    Vec3d sum(0);
    for (const GridTerm& term : row) {
        const double* const p = at + term.offset;
        sum += term.weight * Vec3d(p[0], p[1], p[2]);
    }
    return sum;
}

}  // namespace

struct RowPatterns::Work {
    std::vector<Vec3d> grid;  ///< a root of the points' level with its ghosts
    GridRows side;
};

Vec3d RowPatterns::normal_of(const Vec3d* sums) { return NormalOfTangents::result(sums); }

void RowPatterns::apply(const RootLayout& coarse, const RootLayout& fine, const Vec3d* in, Vec3d* out,
                        const Progress& progress) const {
    if (kind_ == Kind::points)
        apply_to_all<PointOfRow>(coarse, fine, in, out, progress);
    else
        apply_to_all<NormalOfTangents>(coarse, fine, in, out, progress);
}

template <class Finish>
void RowPatterns::apply_to_all(const RootLayout& coarse, const RootLayout& fine, const Vec3d* in, Vec3d* out,
                               const Progress& progress) const {
    const std::uint32_t sides = net_.side_count();
    for (int v = 0; v < net_.base().vertex_count() && !net_.in_cells(); ++v)
        if (net_.base().first(v) == RuleMesh::none) out[v] = kind_ == Kind::points ? in[v] : Vec3d(0);
    const GhostGrid grid(net_, coarse, regular_corners_, rings_);
    GridRows rows;
    for (const RowOf<Step>& row : regular_) {
        rows.emplace_back();
        for (const auto& term : row) rows.back().push_back({3 * (term.at.a + term.at.b * grid.stride()), term.weight});
    }
    // A task takes many small roots, so that no task is too short.
    const std::uint32_t at_once = std::max(k_roots_at_once, k_results_at_once / (fine.segments() * fine.segments()));
    // Kernels read ghosts only for results on the sides, which the root that owns them computes.
    const bool own_only = kernel_ && depth_ <= 1;
    const auto refine_roots = [&](std::uint32_t begin, std::uint32_t end) {
        Work work;
        work.grid.resize(grid.size() + 1, Vec3d(0));  // kernels read past the end
        for (std::uint32_t f = begin; f < end; ++f) {
            grid.fill(f, in, work.grid.data(), own_only);
            regular<Finish>(grid, rows, fine, f, out, work);
            for (std::uint32_t h = sides * f; h < sides * (f + 1); ++h) {
                if (side_pattern_[h] != none) side<Finish>(grid, fine, h, out, work);
                if (corner_pattern_[h] != none) corner<Finish>(coarse, fine, h, in, out);
            }
        }
    };
    for_each_reported_block(net_.root_count(), at_once, progress.context, "refine", progress.from, progress.to,
                            refine_roots);
}

/// Computes all results of a root by the interior rows. Results with side or corner rows are overwritten afterwards.
template <class Finish>
void RowPatterns::regular(const GhostGrid& grid, const GridRows& regular, const RootLayout& fine, std::uint32_t f,
                          Vec3d* out, Work& work) const {
    const RuleMesh& base = net_.base();
    const std::uint32_t m = net_.last_place(fine), sides = net_.side_count(), h = sides * f;
    // Computes `count` results, from place `at` on in direction (dx, dy), and writes them side by side.
    const auto line = [&](RootLattices::Place at, std::uint32_t dx, std::uint32_t dy, std::uint32_t count, Vec3d* to) {
        const std::ptrdiff_t step = 3 * (static_cast<std::int32_t>(dx) + static_cast<std::int32_t>(dy) * grid.stride());
        for (std::uint32_t i = 0; i < std::min(factor_, count); ++i, at = {at.x + dx, at.y + dy}) {
            const Vec3d* const first = work.grid.data() + grid.index({at.x / factor_, at.y / factor_});
            const std::size_t kind = (at.y % factor_ * factor_ + at.x % factor_) * Finish::rows_inside;
            GridRow rows[Finish::rows_inside];
            for (std::size_t r = 0; r < Finish::rows_inside; ++r)
                rows[r] = {&first->x, step, regular[kind + r].data(), regular[kind + r].size()};
            Finish::run(rows, (count - 1 - i) / factor_ + 1, factor_, to + i);
        }
    };
    if (net_.in_cells()) {
        for (std::uint32_t y = 0; y <= m; ++y) line({0, y}, 1, 0, m + 1, out + net_.number_at(fine, f, {0, y}));
        return;
    }
    const RowKernels& kernels = row_kernels();
    const auto on = sides == 4 ? kernels.quads_on : kernels.triangles_on,
               between = sides == 4 ? kernels.quads_between : kernels.triangles_between;
    const double* const points = &work.grid.data()->x;
    for (std::uint32_t s = 0; s < sides; ++s) {
        const RootLattices::Place corner = net_.turned(m, s, 0, 0), next = net_.turned(m, s, 1, 0);
        const int side = static_cast<int>(h + s), v = base.origin(side);
        if (base.first(v) == side) line(corner, 1, 0, 1, out + v);
        // The points of an edge are side by side in the direction of its leading half-edge.
        if (!base.leads(side) || m < 2) continue;
        Vec3d* const to = out + fine.along(h + s, 1);
        const auto& [origin, along, away] = grid.side(s);
        if (kernel_)
            on({points + 3 * origin, 3 * along, 3 * away, m / 2}, &to->x);
        else
            line(next, next.x - corner.x, next.y - corner.y, m - 1, to);
    }
    for (std::uint32_t y = 1; y < m; ++y) {
        const std::uint32_t end = sides == 4 ? m : m - y, row = y / 2;
        if (end < 2) break;
        Vec3d* const to = out + fine.at(f, 1, y);
        if (kernel_)
            (y % 2 == 0 ? on : between)({points + 3 * grid.index({0, row}), 3, 3 * grid.stride(), (end + 1) / 2},
                                        &to->x);
        else
            line({1, y}, 1, 0, end - 1, to);
    }
}

template <class Finish>
void RowPatterns::side(const GhostGrid& grid, const RootLayout& fine, std::uint32_t h, Vec3d* out, Work& work) const {
    const std::uint32_t m = net_.last_place(fine), s = h % net_.side_count();
    const SidePattern& pattern = side_patterns_[side_pattern_[h]];
    const auto& [origin, along, away] = grid.side(s);
    work.side.resize(pattern.size());
    for (std::size_t r = 0; r < pattern.size(); ++r) {
        work.side[r].clear();
        for (const auto& term : pattern[r])
            work.side[r].push_back({3 * (term.at.a * along + term.at.b * away), term.weight});
    }
    const bool owns_edge = net_.in_cells() || net_.base().leads(h);
    const double* const grid_begin = &work.grid.data()->x;
    for (std::uint32_t b = owns_edge ? 0 : 1; b < depth_; ++b) {
        const std::uint32_t first = net_.side_count() == 4 ? reach_ : reach_ - std::min(reach_, b);
        if (m < reach_ || first > m - reach_) continue;
        net_.for_each_on_line(fine, h, b, first, m - reach_ + 1, [&](std::uint32_t a, std::uint32_t v) {
            const double* const at = grid_begin + 3 * (origin + static_cast<std::ptrdiff_t>(a / factor_) * along);
            Vec3d sums[Finish::rows];
            for (std::size_t r = 0; r < Finish::rows; ++r)
                sums[r] = sum_of(at, work.side[(b * factor_ + a % factor_) * Finish::rows + r]);
            out[v] = Finish::result(sums);
        });
    }
}

template <class Finish>
void RowPatterns::corner(const RootLayout& coarse, const RootLayout& fine, std::uint32_t h, const Vec3d* in,
                         Vec3d* out) const {
    const RuleMesh& base = net_.base();
    const bool cells = net_.in_cells(), owns_vertex = cells || base.first(base.origin(h)) == static_cast<int>(h),
               owns_edge = cells || base.leads(h), owns_other = cells || base.leads(base.prev(h));
    for (const CornerPlace& place : corner_patterns_[corner_pattern_[h]]) {
        if (place.x == 0 && place.y == 0 ? !owns_vertex : (place.y == 0 && !owns_edge) || (place.x == 0 && !owns_other))
            continue;
        Vec3d sums[Finish::rows] = {};
        for (std::size_t r = 0; r < Finish::rows; ++r)
            for_each_seen(h, place.rows[r], [&](std::uint32_t g, const RootLattices::Seen& of, double weight) {
                sums[r] +=
                    weight *
                    in[net_.number(coarse, g, static_cast<std::uint32_t>(of.a), static_cast<std::uint32_t>(of.b))];
            });
        out[net_.number(fine, h, place.x, place.y)] = Finish::result(sums);
    }
}

}  // namespace tetrakis::detail
