#pragma once

#include "../../hier/base/vec.hpp"
#include "../../hier/mesh/control_mesh.hpp"
#include "../../schemes/core/scheme_kind.hpp"

#include <vector>

namespace tetrakis {

/// A vertex of the limit surface with its first-order data.
struct LimitPoint {
    Vec3d position{0};
    /// Directions in the tangent plane (of the first sector, see RingLimit); tangent1 x tangent2 points outward. Their
    /// lengths mean nothing.
    Vec3d tangent1{0}, tangent2{0};
    Vec3d normal{0};                 ///< unit length, as limit_normal() in schemes/ring_limit.hpp says
    bool has_tangent_plane = false;  ///< false at creases, corners, ...: tangents and normal are then a choice
};

/// The ring of a vertex at some level, with its tags: all that the limit at this vertex depends on.
struct VertexRing {
    int faces = 0;
    bool boundary = false;
    float vertex_sharpness = 0;
    std::vector<Vec3d> points;     ///< in the order of RingLimit's weights; quads for Catmull-Clark
    std::vector<float> sharpness;  ///< of each edge, or empty when all are smooth (a boundary's ends are always sharp)
    /// Chaikin creasing: what the outer half of each edge gets one level further down; else not used.
    std::vector<float> outer_child;

    void clear() {
        points.clear();
        sharpness.clear();
        outer_child.clear();
        vertex_sharpness = 0;
    }
};

/// Limit position, tangents and normal of the ring's vertex. Finite sharpness is followed level by level until it is
/// gone (the ring alone decides the finer rings), then the limit masks apply: exact for every combination of tags.
/// @param ring  is used as scratch memory: holds a finer ring afterwards
LimitPoint limit_point(SchemeKind scheme, CreaseMethod method, VertexRing& ring);
/// Its position alone, the same bits.
Vec3d limit_position(SchemeKind scheme, CreaseMethod method, VertexRing& ring);

}  // namespace tetrakis
