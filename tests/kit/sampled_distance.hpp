#pragma once

#include "../../eval/bounds/point_triangle.hpp"
#include "../../hier/base/vec.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace tetrakis::test {

/// The error of a leaf (see QuadBounder) at the points of a lattice; and the largest distance from a lattice point of
/// the triangle to the samples, less what lies between these.
struct SampledError {
    double error = 0, back = 0;
};

/// @param surface  the surface at barycentrics (b0, b1, b2) of the leaf
template <class Surface>
SampledError sampled_distance(int n, Surface&& surface) {
    std::vector<Vec3d> points;
    const auto index = [n](int i, int j) { return static_cast<std::size_t>(i * (2 * n + 3 - i) / 2 + j); };
    for (int i = 0; i <= n; ++i)
        for (int j = 0; i + j <= n; ++j) points.push_back(surface(double(i) / n, double(j) / n, double(n - i - j) / n));
    const Vec3d c0 = points[index(n, 0)], c1 = points[index(0, n)], c2 = points[index(0, 0)];
    SampledError sampled;
    double spacing = 0;
    for (int i = 0; i <= n; ++i)
        for (int j = 0; i + j <= n; ++j) {
            const Vec3d& p = points[index(i, j)];
            const auto look = [&](double e) { sampled.error = std::max(sampled.error, e); };
            look(std::sqrt(tetrakis::detail::nearest_on_triangle(p, c0, c1, c2).squared_distance));
            if (i == 0) look(tetrakis::detail::segment_distance(p, c1, c2));
            if (j == 0) look(tetrakis::detail::segment_distance(p, c0, c2));
            if (i + j == n) look(tetrakis::detail::segment_distance(p, c0, c1));
            if (i + j < n)
                spacing = std::max(
                    {spacing, glm::length(p - points[index(i + 1, j)]), glm::length(p - points[index(i, j + 1)])});
        }
    for (int i = 0; i <= n; ++i)
        for (int j = 0; i + j <= n; ++j) {
            const Vec3d q = (double(i) * c0 + double(j) * c1 + double(n - i - j) * c2) / double(n);
            double nearest = std::numeric_limits<double>::infinity();
            for (const Vec3d& p : points) nearest = std::min(nearest, glm::length(p - q));
            sampled.back = std::max(sampled.back, nearest - spacing);
        }
    return sampled;
}

}  // namespace tetrakis::test
