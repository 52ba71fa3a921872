#pragma once

#include "../../schemes/core/rule_step.hpp"

namespace tetrakis::detail {

/// A face as a cell of a level's lattice: a half-edge that leaves one of its corners, counted counter-clockwise.
struct CellFrame {
    int halfedge = RuleMesh::none;
    int corner = 0;
};

/// The half-edge of a face at another of its n corners.
inline int face_corner(const RuleMesh& mesh, const CellFrame& frame, int corner, int n) {
    int h = frame.halfedge;
    for (int c = frame.corner; c != corner; c = (c + 1) % n) h = mesh.next(h);
    return h;
}

/// Quads in four: the child at a corner has the same corner of its own there.
inline CellFrame quad_child(const RuleMesh& mesh, const RuleStep& step, const CellFrame& frame, int child) {
    return {step.child_halfedge[face_corner(mesh, frame, child, 4)], child};
}

/// Triangles in four: children at the corners, then the middle one, whose corner k lies opposite corner k.
inline CellFrame triangle_child(const RuleMesh& mesh, const RuleStep& step, const CellFrame& frame, int child) {
    if (child < 3) return {step.child_halfedge[face_corner(mesh, frame, child, 3)], child};
    const int at_corner = step.child_halfedge[face_corner(mesh, frame, 0, 3)];
    return {step.mesh.twin(step.mesh.next(at_corner)), 1};
}

}  // namespace tetrakis::detail
