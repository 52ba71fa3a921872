#include "sqrt3_leaf_error.hpp"

#include "../../hier/base/parallel.hpp"
#include "../surface/site_limits.hpp"
#include "../triangles/point_triangle.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <vector>

namespace tetrakis::detail {

namespace {

constexpr std::uint32_t k_grain = 64;
constexpr std::size_t k_leaves_at_once = 1u << 14;  // their sites take some 20 MB
constexpr std::size_t k_samples = 22, k_on_side = 4, k_inside = 15, k_edges = 16;

/// Sample points of a cell, two lattice levels below its own. First its corners, then four points a side: at 3, 4, 5
/// and 6 ninths. From k_inside on: the middle. From k_edges on: two points on each of three inner edges, from the
/// middle to the corners; in a cell whose first edge is cut, from the cut's points to the opposite corner.
std::array<Sqrt3Point, k_samples> samples(const Sqrt3Cell& cell) {
    const auto& [a, b, c] = cell.corner;
    const Sqrt3Point middle = a + b + c, first = 2 * a + b, second = a + 2 * b;
    std::array<Sqrt3Point, k_samples> result{9 * a, 9 * b, 9 * c};
    const std::array<std::array<Sqrt3Point, 2>, 3> edges =
        cell.cut ? std::array<std::array<Sqrt3Point, 2>, 3>{{{first, c}, {second, c}, {second, c}}}
                 : std::array<std::array<Sqrt3Point, 2>, 3>{{{middle, a}, {middle, b}, {middle, c}}};
    result[k_inside] = 3 * middle;
    for (std::size_t k = 0; k < 3; ++k) {
        const Sqrt3Point &p = cell.corner[k], &q = cell.corner[(k + 1) % 3];
        std::ranges::copy(std::array{6 * p + 3 * q, 5 * p + 4 * q, 4 * p + 5 * q, 3 * p + 6 * q},
                          &result[3 + k_on_side * k]);
        const auto& [new_point, corner] = edges[k];
        result[k_edges + 2 * k] = new_point + 6 * corner;
        result[k_edges + 2 * k + 1] = 2 * new_point + 3 * corner;
    }
    return result;
}

}  // namespace

void sqrt3_leaf_errors(const Hierarchy& points, const Sqrt3Lattice& lattice, std::span<const Sqrt3Triangle> leaves,
                       std::span<double> errors) {
    std::vector<Sqrt3Cell> cells;
    std::vector<Site> sites;
    std::vector<Vec3d> limits;
    // Half triangles have no samples on inner edges: the whole triangle that they become has them.
    const auto used = [&](std::size_t leaf) { return leaves[leaf].half ? k_edges : k_samples; };
    for (std::size_t begin = 0; begin < leaves.size(); begin += k_leaves_at_once) {
        const auto count = static_cast<std::uint32_t>(std::min(k_leaves_at_once, leaves.size() - begin));
        cells.resize(count);
        sites.resize(k_samples * count);
        limits.resize(sites.size());
        for_each_index(count, [&](std::uint32_t i) {
            cells[i] = lattice.cell(leaves[begin + i]);
            const auto all = samples(cells[i]);
            for (std::size_t k = 0; k < k_samples; ++k)
                sites[k_samples * i + k] =
                    sqrt3_site(points.mesh(), cells[i].root, all[k < used(begin + i) ? k : 0], cells[i].lattice() + 2);
        });
        limit_positions_once(points, sites, limits);
        for_each_index(
            count,
            [&](std::uint32_t i) {
                const Sqrt3Triangle& leaf = leaves[begin + i];
                const Vec3d* const s = &limits[k_samples * i];
                const PlaneMeasure plane({s[0], s[1], s[2]});
                double error = 0;
                for (std::size_t side = 0; side < 3; ++side) {
                    const bool sharp =
                        lattice.is_line(cells[i], side, cells[i].level - (leaf.half && side == 0 ? 1 : 0));
                    for (std::size_t k = 3 + k_on_side * side; k < 3 + k_on_side * (side + 1); ++k)
                        error =
                            std::max(error, sharp ? segment_distance(s[k], s[side], s[(side + 1) % 3]) : plane(s[k]));
                }
                for (std::size_t k = k_inside; k < used(begin + i); ++k) error = std::max(error, plane(s[k]));
                errors[begin + i] = error;
            },
            k_grain);
    }
}

}  // namespace tetrakis::detail
