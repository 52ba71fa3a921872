#pragma once

#include "../../hier/base/vec.hpp"

#include <array>

namespace tetrakis {

/// A flat triangle whose points slide within it: the point with barycentrics b goes to the sum over its sides (i, j) of
/// slide b_i b_j (corner j - corner i) beyond its own place. With slides of less than 1 the corners stay, sides go onto
/// themselves one to one and nothing leaves the triangle; so all of it is met (by degree), and whatever is near the
/// slid points of a surface's parameters is near the surface.
struct SlidTriangle {
    std::array<Vec3d, 3> corner{};
    std::array<double, 3> slide{};  ///< of the side from corner k to the next

    /// One whose sides meet the surface's points at the middles of their parameters as near as sliding can.
    SlidTriangle(const std::array<Vec3d, 3>& corners, const std::array<Vec3d, 3>& middles);
    /// One that does not slide.
    explicit SlidTriangle(const std::array<Vec3d, 3>& corners) : corner(corners) {}
    SlidTriangle() = default;

    /// Where the point with these barycentrics goes.
    Vec3d operator()(const std::array<double, 3>& b) const;
    /// How far a point of a polygon in the parameters is at most from the mean of the slid corners, weighted as itself
    /// is of the corners.
    /// @param width  of each barycentric over the polygon
    double bend(const std::array<double, 3>& width) const;
};

}  // namespace tetrakis
