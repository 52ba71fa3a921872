#include "sqrt3_leaf_error.hpp"

#include "../../hier/base/parallel.hpp"
#include "../surface/site_limits.hpp"
#include "../triangles/point_triangle.hpp"

#include <algorithm>
#include <array>
#include <cstddef>

namespace tetrakis::detail {

namespace {

constexpr std::uint32_t k_grain = 64;
constexpr std::size_t k_leaves_at_once = 1u << 14;  // their sites take some 20 MB
constexpr std::size_t k_first_samples = 10, k_more_samples = 12;

/// The corners, a point about the middle, and both thirds of each side. One lattice level below the cell's.
std::array<Sqrt3Point, k_first_samples> first_samples(const Sqrt3Cell& cell) {
    const auto& [a, b, c] = cell.corner;
    return {3 * a, 3 * b, 3 * c, a + b + c, 2 * a + b, a + 2 * b, 2 * b + c, b + 2 * c, 2 * c + a, c + 2 * a};
}

/// The thirds of each side's middle third, then those of edges inside: between the corners and the middle, where the
/// first edge is cut from its new points to the corner opposite. Two levels below.
std::array<Sqrt3Point, k_more_samples> more_samples(const Sqrt3Cell& cell) {
    const auto& [a, b, c] = cell.corner;
    const Sqrt3Point middle = a + b + c, first = 2 * a + b, second = a + 2 * b;
    std::array<Sqrt3Point, k_more_samples> result{5 * a + 4 * b, 4 * a + 5 * b, 5 * b + 4 * c,
                                                  4 * b + 5 * c, 5 * c + 4 * a, 4 * c + 5 * a};
    const std::array<std::array<Sqrt3Point, 2>, 3> edges =
        cell.cut ? std::array<std::array<Sqrt3Point, 2>, 3>{{{first, c}, {second, c}, {second, c}}}
                 : std::array<std::array<Sqrt3Point, 2>, 3>{{{middle, a}, {middle, b}, {middle, c}}};
    for (std::size_t k = 0; k < 3; ++k) {
        const auto& [new_point, corner] = edges[k];
        result[6 + 2 * k] = new_point + 6 * corner;
        result[7 + 2 * k] = 2 * new_point + 3 * corner;
    }
    return result;
}

/// Of leaves whose points are found together.
void block_errors(const Hierarchy& points, const Sqrt3Lattice& lattice, std::span<const Sqrt3Triangle> leaves,
                  double decide_at, const std::function<void(double)>& report, std::span<double> errors) {
    const ControlMesh& mesh = points.mesh();
    const auto count = static_cast<std::uint32_t>(leaves.size());
    std::vector<Sqrt3Cell> cells(count);
    for_each_index(count, [&](std::uint32_t i) { cells[i] = lattice.cell(leaves[i]); });
    // The points of some leaves, so many levels down, one leaf after the other.
    const auto limits = [&](std::span<const std::uint32_t> some, std::size_t each, int levels, const auto& samples) {
        std::vector<Site> sites(each * some.size());
        for_each_index(static_cast<std::uint32_t>(some.size()), [&](std::uint32_t i) {
            const Sqrt3Cell& cell = cells[some[i]];
            std::size_t at = each * i;
            for (const Sqrt3Point& p : samples(cell))
                sites[at++] = sqrt3_site(mesh, cell.root, p, cell.lattice() + levels);
        });
        std::vector<Vec3d> result(sites.size());
        limit_positions_once(points, sites, result, report);
        return result;
    };
    const auto is_sharp = [&](std::uint32_t leaf, std::size_t side) {
        return lattice.is_line(cells[leaf], side, cells[leaf].level - (leaves[leaf].half && side == 0 ? 1 : 0));
    };
    std::vector<std::uint32_t> all(count), open;
    for (std::uint32_t i = 0; i < count; ++i) all[i] = i;
    const std::vector<Vec3d> first = limits(all, k_first_samples, 1, first_samples);
    const auto add = [&](std::uint32_t leaf, const Vec3d* samples, std::size_t inside_begin, std::size_t inside_end,
                         std::size_t sides_begin) {
        const Vec3d* const corner = &first[k_first_samples * leaf];
        const PlaneMeasure plane({corner[0], corner[1], corner[2]});
        double& error = errors[leaf];
        for (std::size_t k = inside_begin; k < inside_end; ++k) error = std::max(error, plane(samples[k]));
        for (std::size_t k = 0; k < 6; ++k) {
            const Vec3d& p = samples[sides_begin + k];
            const std::size_t side = k / 2;
            error = std::max(
                error, is_sharp(leaf, side) ? segment_distance(p, corner[side], corner[(side + 1) % 3]) : plane(p));
        }
    };
    for_each_index(
        count, [&](std::uint32_t i) { add(i, &first[k_first_samples * i], 3, 4, 4); }, k_grain);
    for (std::uint32_t i = 0; i < count; ++i)
        if (!(errors[i] > decide_at)) open.push_back(i);
    const std::vector<Vec3d> more = limits(open, k_more_samples, 2, more_samples);
    for_each_index(
        static_cast<std::uint32_t>(open.size()),
        [&](std::uint32_t i) {
            // What is inside of a half triangle is seen from the whole one that it becomes.
            add(open[i], &more[k_more_samples * i], 6, leaves[open[i]].half ? 6 : 12, 0);
        },
        k_grain);
}

}  // namespace

std::vector<double> sqrt3_leaf_errors(const Hierarchy& points, const Sqrt3Lattice& lattice,
                                      std::span<const Sqrt3Triangle> leaves, double decide_at,
                                      const std::function<void(double)>& report) {
    std::vector<double> errors(leaves.size(), 0.0);
    for (std::size_t begin = 0; begin < leaves.size(); begin += k_leaves_at_once) {
        const std::size_t count = std::min(k_leaves_at_once, leaves.size() - begin);
        block_errors(points, lattice, leaves.subspan(begin, count), decide_at, report,
                     std::span(errors).subspan(begin, count));
    }
    return errors;
}

}  // namespace tetrakis::detail
