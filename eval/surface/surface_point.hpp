#pragma once

#include "../../hier/base/vec.hpp"

namespace tetrakis {

/// A point of a limit surface with its derivatives by the root's parameters (x, y); lengths in the unit of the control
/// mesh.
struct SurfacePoint {
    Vec3d position{0};
    Vec3d du{0}, dv{0};  ///< first derivatives; at an extraordinary point two tangents (du x dv points outward)
    Vec3d duu{0}, duv{0}, dvv{0};  ///< second derivatives; zero where has_second is false
    bool has_second = true;        ///< false at extraordinary points, where second derivatives do not exist
    bool has_derivatives = true;   ///< du and dv are derivatives by x and y; false: tangents of any length and turn
    Vec3d normal{0};  ///< unit normal, outward for counter-clockwise faces; where there is no tangent plane
                      ///< (corners, creases) the mean of the sectors' normals; zero if nothing defines one
};

}  // namespace tetrakis
