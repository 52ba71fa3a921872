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

/// Sample points of a cell, two lattice levels below its own: ninths of its corners. First the corners, then four
/// points a side. From k_inside on: the middle. From k_edges on: two points on each of three inner edges, from the
/// middle to the corners.
constexpr std::array<std::array<int, 3>, k_samples> k_ninths{
    {{9, 0, 0}, {0, 9, 0}, {0, 0, 9}, {6, 3, 0}, {5, 4, 0}, {4, 5, 0}, {3, 6, 0}, {0, 6, 3},
     {0, 5, 4}, {0, 4, 5}, {0, 3, 6}, {3, 0, 6}, {4, 0, 5}, {5, 0, 4}, {6, 0, 3}, {3, 3, 3},
     {7, 1, 1}, {5, 2, 2}, {1, 7, 1}, {2, 5, 2}, {1, 1, 7}, {2, 2, 5}}};
/// Samples on the inner edges of a cell whose first edge is cut: from the cut's points to the opposite corner.
constexpr std::array<std::array<int, 3>, 4> k_ninths_at_cut{{{2, 1, 6}, {4, 2, 3}, {1, 2, 6}, {2, 4, 3}}};

}  // namespace

void sqrt3_leaf_errors(const Hierarchy& points, const Sqrt3Lattice& lattice, std::span<const Sqrt3Triangle> leaves,
                       std::span<double> errors) {
    std::vector<Sqrt3Cell> cells;
    std::vector<Site> sites;
    std::vector<Vec3d> limits;
    for (std::size_t begin = 0; begin < leaves.size(); begin += k_leaves_at_once) {
        const auto count = static_cast<std::uint32_t>(std::min(k_leaves_at_once, leaves.size() - begin));
        cells.resize(count);
        sites.resize(k_samples * count);
        limits.resize(sites.size());
        for_each_index(count, [&](std::uint32_t i) {
            cells[i] = lattice.cell(leaves[begin + i]);
            const auto& [a, b, c] = cells[i].corner;
            for (std::size_t k = 0; k < k_samples; ++k) {
                // Half triangles have no samples on inner edges: the whole triangle that they become has them.
                const auto& w = k < k_edges              ? k_ninths[k]
                                : leaves[begin + i].half ? k_ninths[0]
                                : cells[i].cut           ? k_ninths_at_cut[k % 4]
                                                         : k_ninths[k];
                sites[k_samples * i + k] =
                    sqrt3_site(points.mesh(), cells[i].root, w[0] * a + w[1] * b + w[2] * c, cells[i].lattice() + 2);
            }
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
                for (std::size_t k = k_inside; k < k_samples; ++k) error = std::max(error, plane(s[k]));
                errors[begin + i] = error;
            },
            k_grain);
    }
}

}  // namespace tetrakis::detail
