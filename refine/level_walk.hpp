#pragma once

#include "tetrakis/schemes/rule_step.hpp"

#include <array>

namespace tetrakis::detail {

/// A cell of a level's lattice in the level's mesh: a half-edge that leaves one of its corners. Primal: a face, its
/// corners counter-clockwise. Dual: a vertex; the half-edge leaves the vertex, and its face lies at the corner.
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

/// The half-edges that leave a dual vertex, by the corners of its cell; none where the cell ends the surface, or its
/// side of a crease.
inline std::array<int, 4> vertex_corners(const RuleMesh& mesh, const CellFrame& frame) {
    const auto across = [&](int h) { return mesh.sharp(h) ? RuleMesh::none : mesh.twin(h); };
    std::array<int, 4> at{RuleMesh::none, RuleMesh::none, RuleMesh::none, RuleMesh::none};
    int h = frame.halfedge;
    for (int c = frame.corner; h != RuleMesh::none && at[c] == RuleMesh::none; c = (c + 1) % 4) {
        at[c] = h;
        h = across(mesh.prev(h));
    }
    h = across(frame.halfedge);
    for (int c = (frame.corner + 3) % 4; h != RuleMesh::none && at[c] == RuleMesh::none; c = (c + 3) % 4) {
        at[c] = mesh.next(h);
        h = across(at[c]);
    }
    return at;
}

/// Vertices in four: towards each face of the vertex, and at a boundary or crease the points along its edges (and,
/// where it is a corner, its own; where a crease ends in it, that one alone).
inline CellFrame vertex_child(const RuleMesh& mesh, const RuleStep& step, const CellFrame& frame, int child) {
    const std::array<int, 4> at = vertex_corners(mesh, frame);
    if (at[child] != RuleMesh::none) return {step.child_halfedge[at[child]], child};
    // The faces that there are, counter-clockwise: corner `first` to corner `last`.
    int first = frame.corner, last = frame.corner;
    for (int c = (first + 3) % 4; at[c] != RuleMesh::none; c = (c + 3) % 4) first = c;
    for (int c = (last + 1) % 4; at[c] != RuleMesh::none; c = (c + 1) % 4) last = c;
    const int ahead = step.child_crease[at[first]], behind = step.child_crease[mesh.prev(at[last])];
    if (ahead == RuleMesh::none || behind == RuleMesh::none) return {};
    if (child == (first + 3) % 4) return {ahead, first};
    if (child == (last + 1) % 4) return {step.mesh.next(behind), last};
    // The corner's own point comes before the first one along the edge in the vertex's face.
    return {step.mesh.prev(step.mesh.twin(step.mesh.prev(ahead))), first};
}

}  // namespace tetrakis::detail
