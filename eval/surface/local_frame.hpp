#pragma once

#include "../../hier/base/vec.hpp"
#include "../../hier/mesh/control_mesh.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

namespace tetrakis::detail {

/// A frame of a box for computations with floats. Its scale is a power of two, hence exact, such that the largest
/// coordinate of the box is in [1/2, 1]. Floats in it resolve the box to about 6e-8, for any place and size of the box.
struct LocalFrame {
    Vec3d origin{0.0};
    double scale = 1;

    /// @param origin  a point of the box
    static LocalFrame around(const Vec3d& origin, const Box3d& box) {
        LocalFrame frame;
        if (box.empty()) return frame;
        frame.origin = origin;
        const Vec3d reach = glm::max(box.upper - origin, origin - box.lower);
        const double extent = std::max({reach.x, reach.y, reach.z});
        // Beyond these exponents the scale itself would leave the range of double.
        constexpr int k_largest_exponent = 1020;
        if (extent > 0) frame.scale = std::scalbn(1.0, std::min(-std::ilogb(extent) - 1, k_largest_exponent));
        return frame;
    }
    Vec3d to_local(const Vec3d& p) const { return (p - origin) * scale; }
};

/// The smallest float that is not below x; infinite if x is out of range.
inline float round_up(double x) {
    const float f = static_cast<float>(x);
    return static_cast<double>(f) < x ? std::nextafter(f, std::numeric_limits<float>::infinity()) : f;
}

/// Bound on the rounding errors of points of the limit surface, their control points and distances to them, on any
/// level: Lemma 1 of eval/bounds/README.md. O(vertices).
/// @param averaging_steps  of repeated averaging, whose rows are longer than a vertex and its ring
inline double surface_rounding(const ControlMesh& mesh, int averaging_steps = 0) {
    constexpr std::uint32_t k_valence = 64;                             // below, other sums are as long
    const auto side = static_cast<std::uint32_t>(averaging_steps + 2);  // side of a row's square of points
    std::uint32_t most = std::max(k_valence, side * side / 2);
    for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v) most = std::max(most, mesh.face_valence(VertexId(v)) + 1);
    for (std::uint32_t f = 0; f < mesh.face_count(); ++f) most = std::max(most, mesh.face_size(FaceId(f)));
    const Box3d box = mesh.bounding_box();
    const Vec3d reach = glm::max(glm::abs(box.lower), glm::abs(box.upper));
    constexpr double k_roundings = 140;  // per edge
    return k_roundings * most * std::numeric_limits<double>::epsilon() * std::max({reach.x, reach.y, reach.z});
}

}  // namespace tetrakis::detail
