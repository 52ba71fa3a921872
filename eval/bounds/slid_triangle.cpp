#include "slid_triangle.hpp"

#include <algorithm>
#include <cmath>

namespace tetrakis {

SlidTriangle::SlidTriangle(const std::array<Vec3d, 3>& corners, const std::array<Vec3d, 3>& middles) : corner(corners) {
    constexpr double k_most = 0.9;
    for (std::size_t k = 0; k < 3; ++k) {
        const Vec3d side = corners[(k + 1) % 3] - corners[k];
        const double squared = glm::dot(side, side);
        if (!(squared > 0)) continue;
        const double along = glm::dot(middles[k] - corners[k], side) / squared;
        slide[k] = std::clamp(4 * (along - 0.5), -k_most, k_most);
    }
}

Vec3d SlidTriangle::operator()(const std::array<double, 3>& b) const {
    Vec3d p = b[0] * corner[0] + b[1] * corner[1] + b[2] * corner[2];
    for (std::size_t k = 0; k < 3; ++k) {
        const std::size_t next = (k + 1) % 3;
        p += slide[k] * b[k] * b[next] * (corner[next] - corner[k]);
    }
    return p;
}

double SlidTriangle::bend(const std::array<double, 3>& width) const {
    // The covariance of two numbers is at most a quarter of the product of their ranges.
    double bend = 0;
    for (std::size_t k = 0; k < 3; ++k) {
        const std::size_t next = (k + 1) % 3;
        bend += 0.25 * std::abs(slide[k]) * width[k] * width[next] * glm::length(corner[next] - corner[k]);
    }
    return bend;
}

}  // namespace tetrakis
