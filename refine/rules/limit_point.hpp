#pragma once

#include "../../hier/base/vec.hpp"

namespace tetrakis {

/// A vertex of the limit surface with its first-order data.
struct LimitPoint {
    Vec3d position{0};
    /// Directions in the tangent plane (of the first side of a crease); tangent1 x tangent2 points outward. Their
    /// lengths mean nothing.
    Vec3d tangent1{0}, tangent2{0};
    Vec3d normal{0};                 ///< unit length; at creases the mean of the sides'
    bool has_tangent_plane = false;  ///< false at creases, corners, ...: tangents and normal are then a choice
};

}  // namespace tetrakis
