#pragma once

#include "../../eval/surface/triangle_mesh.hpp"
#include "../../eval/terrain/height_grid.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <random>
#include <vector>

namespace tetrakis::test {

inline HeightGrid grid_of(std::uint32_t columns, std::uint32_t rows, const auto& height) {
    HeightGrid grid{.columns = columns, .rows = rows, .heights = {}};
    for (std::uint32_t r = 0; r < rows; ++r)
        for (std::uint32_t c = 0; c < columns; ++c) grid.heights.push_back(static_cast<float>(height(c, r)));
    return grid;
}

/// A rough terrain: eight octaves of three random waves, each octave half as long and two thirds as high as the last.
inline HeightGrid rough(std::uint32_t columns, std::uint32_t rows, unsigned seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> angle(0, 6.28);
    std::vector<std::array<double, 3>> waves;
    for (int i = 0; i < 24; ++i) waves.push_back({angle(random), angle(random), std::pow(2.0, i / 3) / 120});
    return grid_of(columns, rows, [&](double c, double r) {
        double sum = 0;
        for (const auto& [turn, phase, rate] : waves)
            sum += std::sin(phase + 6.28 * rate * (c * std::cos(turn) + r * std::sin(turn))) / std::pow(rate, 0.6);
        return sum;
    });
}

inline double twice_area(const Vec3d& a, const Vec3d& b, const Vec3d& c) {
    return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

/// Calls visit(column, row, height of the triangle there) for each sample under a triangle. Returns the triangle's area
/// in cells, negative if it is clockwise.
template <class Visit>
double visit_samples(const HeightGrid& grid, std::array<Vec3d, 3> p, const Visit& visit) {
    for (Vec3d& at : p) at = {(at.x - grid.origin.x) / grid.spacing.x, (at.y - grid.origin.y) / grid.spacing.y, at.z};
    const double area = twice_area(p[0], p[1], p[2]);
    const auto [x0, x1] = std::minmax({p[0].x, p[1].x, p[2].x});
    const auto [y0, y1] = std::minmax({p[0].y, p[1].y, p[2].y});
    for (double y = std::ceil(y0); y <= y1; ++y)
        for (double x = std::ceil(x0); x <= x1; ++x) {
            const Vec3d at(x, y, 0);
            const double a = twice_area(at, p[1], p[2]), b = twice_area(p[0], at, p[2]), c = area - a - b;
            if (a < 0 || b < 0 || c < 0) continue;
            visit(static_cast<std::uint32_t>(x), static_cast<std::uint32_t>(-y),
                  (a * p[0].z + b * p[1].z + c * p[2].z) / area);
        }
    return area / 2;
}

/// Quality of a mesh for a grid, judged without code of the library.
struct Judged {
    double largest_error = 0, area = 0;
    std::size_t unseen = 0;  ///< samples that no triangle lies over
    std::size_t turned = 0;  ///< triangles that are clockwise or have no area
};
inline Judged judge(const TriangleMesh& mesh, const HeightGrid& grid) {
    Judged judged;
    std::vector<char> seen(grid.heights.size(), 0);
    for (const auto& [i, j, k] : mesh.triangles) {
        const double area = visit_samples(
            grid, {mesh.positions[i], mesh.positions[j], mesh.positions[k]},
            [&](std::uint32_t column, std::uint32_t row, double height) {
                seen[row * std::size_t{grid.columns} + column] = 1;
                judged.largest_error = std::max(judged.largest_error, std::abs(height - double{grid.at(column, row)}));
            });
        judged.area += area;
        if (!(area > 0)) ++judged.turned;
    }
    judged.unseen = static_cast<std::size_t>(std::count(seen.begin(), seen.end(), 0));
    return judged;
}

}  // namespace tetrakis::test
