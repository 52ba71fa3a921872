#pragma once

#include "../../hier/base/vec.hpp"

namespace tetrakis {

/// A vertex of the limit surface with its first-order data.
struct LimitPoint {
    Vec3d position{0};
    /// Two directions that span the tangent plane (at a crease, of its first side); tangent1 x tangent2 points outward.
    /// Their lengths have no meaning.
    Vec3d tangent1{0}, tangent2{0};
    Vec3d normal{0};                 ///< unit length; at a crease the mean of the normals of its sides
    bool has_tangent_plane = false;  ///< false at creases, corners, ...: tangents and normal are then a choice
};

}  // namespace tetrakis
