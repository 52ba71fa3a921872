#pragma once

#include "../../hier/base/ids.hpp"
#include "../../hier/base/vec.hpp"

namespace tetrakis {

/// A point of a limit surface with its derivatives by the root's parameters (x, y); lengths in the unit of the control
/// mesh.
struct SurfacePoint {
    Vec3d position{0};
    Vec3d du{0}, dv{0};  ///< first derivatives; at an extraordinary point two tangents (du x dv points outward)
    Vec3d duu{0}, duv{0}, dvv{0};  ///< second derivatives; zero where has_second is false
    bool has_second = true;        ///< false at extraordinary points, where second derivatives do not exist
    bool has_derivatives = true;  ///< du and dv are derivatives by x and y; false: tangents of any length and direction
    Vec3d normal{0};              ///< unit normal, outward for counter-clockwise faces; where there is no tangent plane
                                  ///< (corners, creases) the mean of the sectors' normals; zero if nothing defines one
};

/// Location on a limit surface: root and parameters.
struct SurfaceParameter {
    HalfedgeId root;
    double x = 0, y = 0;
};

namespace detail {

/// The Gauss-Newton step in the tangent plane at s towards q; false where the tangents do not span one.
inline bool tangent_step(const SurfacePoint& s, const Vec3d& q, double& dx, double& dy) {
    const Vec3d r = q - s.position;
    const double a = glm::dot(s.du, s.du), b = glm::dot(s.du, s.dv), c = glm::dot(s.dv, s.dv);
    const double det = a * c - b * b;
    // Squared sine of the angle between the tangents below which they count as parallel.
    constexpr double k_parallel = 1e-12;
    if (!(det > k_parallel * a * c)) return false;
    const double p = glm::dot(s.du, r), w = glm::dot(s.dv, r);
    dx = (c * p - b * w) / det;
    dy = (a * w - b * p) / det;
    return true;
}

}  // namespace detail

}  // namespace tetrakis
