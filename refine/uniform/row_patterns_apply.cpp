#include "row_patterns.hpp"

#include "../../hier/base/parallel.hpp"

#include <algorithm>
#include <cmath>

// The rows read again, at the places of a level.
namespace tetrakis::detail {

namespace {

constexpr std::uint32_t k_roots_at_once = 4, k_results_at_once = 16384;  // per task

using Row = std::vector<GridTerm>;

/// What a result is made of, and how.
struct PointOfRow {
    static constexpr std::size_t rows = 1, rows_inside = 1;
    static void run(const double* at, const Row* rows, std::uint32_t count, std::uint32_t stride, double* to) {
        row_kernels().any(at, rows[0].data(), rows[0].size(), count, stride, to);
    }
    static Vec3d result(const Vec3d* sums) { return sums[0]; }
};
struct NormalOfTangents {
    static constexpr std::size_t rows = 4, rows_inside = 2;
    static void run(const double* at, const Row* rows, std::uint32_t count, std::uint32_t stride, double* to) {
        row_kernels().normals(at, rows[0].data(), rows[0].size(), rows[1].data(), rows[1].size(), count, stride, to);
    }
    // A normal that looks at a missing point is missing.
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

/// The row's sum for one point.
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
    std::vector<Vec3d> line;  ///< of results
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
    const MeshLevel& base = net_.base();
    const std::uint32_t sides = net_.side_count();
    for (std::uint32_t v = 0; v < base.vertex_count && !net_.in_cells(); ++v)
        if (base.vertex_halfedge[v] == none) out[v] = kind_ == Kind::points ? in[v] : Vec3d(0);
    const GhostGrid grid(net_, coarse, regular_corners_, rings_);
    GridRows rows;
    for (const RowOf<Step>& row : regular_) {
        rows.emplace_back();
        for (const auto& term : row) rows.back().push_back({3 * (term.at.a + term.at.b * grid.stride()), term.weight});
    }
    // Small roots by many, so that no task is short.
    const std::uint32_t at_once = std::max(k_roots_at_once, k_results_at_once / (fine.segments() * fine.segments()));
    const auto refine_roots = [&](std::uint32_t begin, std::uint32_t end) {
        Work work;
        work.grid.resize(grid.size() + 1, Vec3d(0));  // kernels read on
        work.line.resize(net_.last_place(fine) + std::size_t{1});
        for (std::uint32_t f = begin; f < end; ++f) {
            grid.fill(f, in, work.grid.data());
            if (kernel_)
                by_kernel(grid, fine, f, out, work);
            else
                regular<Finish>(grid, rows, fine, f, out, work);
            // The rows of a corner's place are those of place (0, 0), whichever corner it is.
            for (std::uint32_t s = 0, h = sides * f; s < sides && !net_.in_cells(); ++s, ++h)
                if (const std::uint32_t v = base.origin[h]; base.vertex_halfedge[v] == h)
                    Finish::run(&work.grid[static_cast<std::size_t>(grid.side(s).origin)].x, rows.data(), 1, 1,
                                &out[v].x);
            for (std::uint32_t h = sides * f; h < sides * (f + 1); ++h) {
                if (side_pattern_[h] != none) side<Finish>(grid, fine, h, out, work);
                if (corner_pattern_[h] != none) corner<Finish>(coarse, fine, h, in, out);
            }
        }
    };
    for_each_reported_block(base.face_count, at_once, progress.context, "refine", progress.from, progress.to,
                            refine_roots);
}

/// All points of a root but those at its corners, line by line.
void RowPatterns::by_kernel(const GhostGrid& grid, const RootLayout& fine, std::uint32_t f, Vec3d* out,
                            Work& work) const {
    const MeshLevel& base = net_.base();
    const std::uint32_t sides = net_.side_count(), n = fine.segments() / 2, h = sides * f;
    const auto on = sides == 4 ? row_kernels().quads_on : row_kernels().triangles_on,
               between = sides == 4 ? row_kernels().quads_between : row_kernels().triangles_between;
    const double* const points = &work.grid.data()->x;
    // From place (0, 0) seen from a side.
    const auto line = [&](std::uint32_t s, std::uint32_t segments) {
        const GhostGrid::Side& side = grid.side(s);
        return GridLine{points + 3 * side.origin, 3 * side.along, 3 * side.away, segments};
    };
    for (std::uint32_t s = 0; s < sides; ++s) {
        const std::uint32_t side = base.edge_side[h + s];
        if ((side & 1) == 0) on(line(s, n), &out[fine.edge_begin(side >> 1)].x);
    }
    GridLine at = line(0, n);
    for (std::uint32_t y = 0; y < n; ++y) {
        if (y > 0) on(at, &out[fine.at(f, 1, 2 * y)].x);
        if (sides == 4 || at.segments > 1) between(at, &out[fine.at(f, 1, 2 * y + 1)].x);
        at.first += at.across;
        if (sides == 3) --at.segments;
    }
}

/// All results of a root by the rows inside, with its ghosts; those that have other rows are written once more.
/// But for those at corners, in lattices.
template <class Finish>
void RowPatterns::regular(const GhostGrid& grid, const GridRows& regular, const RootLayout& fine, std::uint32_t f,
                          Vec3d* out, Work& work) const {
    const MeshLevel& base = net_.base();
    const std::uint32_t m = net_.last_place(fine), sides = net_.side_count(), h = sides * f;
    const auto owns_side = [&](std::uint32_t s) { return (base.edge_side[h + s] & 1) == 0; };
    const auto line = [&](std::uint32_t y, std::uint32_t begin, std::uint32_t last, Vec3d* to) {
        for (std::uint32_t x = begin; x < begin + factor_ && x <= last; ++x) {
            const auto* const rows = &regular[(y % factor_ * factor_ + x % factor_) * std::size_t{Finish::rows_inside}];
            const auto at = static_cast<std::size_t>(grid.index({x / factor_, y / factor_}));
            Finish::run(&work.grid[at].x, rows, (last - x) / factor_ + 1, factor_, &to[x - begin].x);
        }
    };
    for (std::uint32_t y = 0; y <= m; ++y) {
        const std::uint32_t end = sides == 4 ? m : m - y;
        if (net_.in_cells()) {
            line(y, 0, end, out + net_.number_at(fine, f, {0, y}));
            continue;
        }
        // Points inside are side by side; those on sides belong to one of two roots, those at corners to one.
        if (y == 0 || (sides == 4 && y == m)) {
            const std::uint32_t s = y == 0 ? 0 : 2;
            if (!owns_side(s) || m < 2) continue;
            // Along the root's own half-edge points are side by side, too.
            Vec3d* const first = s == 0 ? out + fine.along(h, 1) : work.line.data();
            line(y, 1, m - 1, first);
            if (s == 2) std::reverse_copy(first, first + m - 1, out + fine.along(h + 2, 1));
            continue;
        }
        if (end > 1) line(y, 1, end - 1, out + fine.at(f, 1, y));
        if (y == m) continue;
        if (owns_side(sides - 1)) line(y, 0, 0, out + fine.along(h + sides - 1, m - y));
        if (owns_side(1)) line(y, end, end, out + fine.along(h + 1, y));
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
    const bool owns_edge = net_.in_cells() || (net_.base().edge_side[h] & 1) == 0;
    const double* const grid_begin = &work.grid.data()->x;
    for (std::uint32_t b = owns_edge ? 0 : 1; b < depth_; ++b) {
        const std::uint32_t first = net_.side_count() == 4 ? reach_ : reach_ - std::min(reach_, b);
        if (m < reach_ || first > m - reach_) continue;
        net_.line(fine, h, b).for_each(first, m - reach_ + 1, [&](std::uint32_t a, std::uint32_t v) {
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
    const MeshLevel& base = net_.base();
    const bool cells = net_.in_cells(), owns_vertex = cells || base.vertex_halfedge[base.origin[h]] == h,
               owns_edge = cells || (base.edge_side[h] & 1) == 0,
               owns_other = cells || (base.edge_side[base.prev(h)] & 1) == 0;
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
