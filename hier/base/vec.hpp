#pragma once

#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

namespace tetrakis {

using Vec3d = glm::dvec3;
using Vec3f = glm::vec3;
using Vec2d = glm::dvec2;

/// The vector at length 1, however long or short it is; the zero vector where it has no length, or no finite one.
inline Vec3d unit_or_zero(const Vec3d& v) {
    constexpr double k_long = 1e150, k_short = 1e-150;  // the squares of both are far from where doubles end
    const double length = glm::length(v);
    if (length > k_short && length < k_long) return v / length;
    if (std::isnan(length)) return Vec3d(0);
    const double largest = std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
    return largest > 0 && std::isfinite(largest) ? glm::normalize(v / largest) : Vec3d(0);
}

/// The mean of unit vectors at length 1, from their sum; the zero vector where they cancel each other to rounding.
inline Vec3d unit_of_sum(const Vec3d& sum) {
    constexpr double k_nothing = 1e-6;
    const double length = glm::length(sum);
    return length > k_nothing ? sum / length : Vec3d(0);
}

/// Axis-aligned box; empty when a lower bound exceeds its upper one.
struct Box3d {
    Vec3d lower{std::numeric_limits<double>::infinity()};
    Vec3d upper{-std::numeric_limits<double>::infinity()};

    void add(const Vec3d& p) {
        lower = glm::min(lower, p);
        upper = glm::max(upper, p);
    }
    void add(const Box3d& b) {
        lower = glm::min(lower, b.lower);
        upper = glm::max(upper, b.upper);
    }
    bool empty() const { return lower.x > upper.x; }
    /// Length of the diagonal; 0 for an empty box.
    double diagonal() const { return empty() ? 0.0 : glm::length(upper - lower); }
    Vec3d centre() const { return 0.5 * (lower + upper); }
};

inline Box3d bounding_box(std::span<const Vec3d> points) {
    Box3d box;
    for (const Vec3d& p : points) box.add(p);
    return box;
}

}  // namespace tetrakis
