#pragma once

#include "../../schemes/core/rule_step.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <utility>

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
/// side of a crease, and at the far corner of one with three faces all around: it comes from a vertex of two faces,
/// which has no face below it.
inline std::array<int, 4> vertex_corners(const RuleMesh& mesh, const CellFrame& frame) {
    const auto across = [&](int h) { return mesh.sharp(h) ? RuleMesh::none : mesh.twin(h); };
    std::array<int, 4> at{RuleMesh::none, RuleMesh::none, RuleMesh::none, RuleMesh::none};
    const auto corner = [&](int steps) -> int& { return at[static_cast<std::size_t>((frame.corner + steps) % 4)]; };
    int h = frame.halfedge;
    for (int k = 0; k < 4 && h != RuleMesh::none; ++k) {
        corner(k) = h;
        h = across(mesh.prev(h));
        if (h != frame.halfedge) continue;
        if (k == 2) std::swap(corner(2), corner(3));
        return at;
    }
    h = across(frame.halfedge);
    for (int k = 3; k > 0 && h != RuleMesh::none && corner(k) == RuleMesh::none; --k) {
        corner(k) = mesh.next(h);
        h = across(corner(k));
    }
    return at;
}

/// A dual cell on the way down, and which of its corners have faces: bit c of `faces`. Where a crease that it ended at
/// has become smooth, the vertex has others beside these.
struct VertexFrame {
    CellFrame frame;
    unsigned faces = 0;
};
constexpr unsigned k_all_corners = 0b1111;

/// Vertices in four: towards each face of the vertex, and at a boundary or crease the points along its edges (and,
/// where it is a corner, its own; where a crease ends in it, that one alone). Without a half-edge where there is none.
inline VertexFrame vertex_child(const RuleMesh& mesh, const RuleStep& step, const VertexFrame& cell, int child) {
    const auto has = [&](int corner) { return (cell.faces >> corner % 4 & 1) != 0; };
    // A smooth vertex of two faces has no face of its own below it.
    const auto toward_face = [&](int h) {
        const int other = mesh.twin(mesh.prev(h));
        const bool alone =
            other != RuleMesh::none && mesh.twin(mesh.prev(other)) == h && !mesh.sharp(h) && !mesh.sharp(other);
        return VertexFrame{{step.child_halfedge[h], child},
                           alone ? k_all_corners & ~(1u << (child + 2) % 4) : k_all_corners};
    };
    // The faces that there are, counter-clockwise: corner `first` to corner `last`.
    int first = cell.frame.corner, last = cell.frame.corner, at_first = cell.frame.halfedge, at_last = at_first;
    while (first != child && has(first + 3) && (first + 3) % 4 != cell.frame.corner) {
        at_first = mesh.next(mesh.twin(at_first));
        first = (first + 3) % 4;
    }
    if (first == child) return toward_face(at_first);
    while (last != child && has(last + 1) && (last + 1) % 4 != cell.frame.corner) {
        at_last = mesh.twin(mesh.prev(at_last));
        last = (last + 1) % 4;
    }
    if (last == child) return toward_face(at_last);
    const int ahead = step.child_crease[at_first], behind = step.child_crease[mesh.prev(at_last)];
    const RuleMesh::Ring ring = mesh.ring(mesh.origin(at_first));
    const bool crease_ends = std::count_if(ring.sharpness.begin(), ring.sharpness.end(), is_sharp) == 1;
    const auto corners = [](int from, unsigned some) { return (some << from | some << from >> 4) & k_all_corners; };
    if (child == (first + 3) % 4) {
        if (ahead == RuleMesh::none) return {};
        return {{ahead, first}, corners(first, crease_ends ? 0b111 : 0b11)};
    }
    if (child == (last + 1) % 4) {
        if (behind == RuleMesh::none || crease_ends) return {};
        return {{step.mesh.next(behind), last}, corners((last + 3) % 4, 0b11)};
    }
    if (ahead == RuleMesh::none) return {};
    // The corner's own point comes before the first one along the edge in the vertex's face.
    return {{step.mesh.prev(step.mesh.twin(step.mesh.prev(ahead))), first}, corners(first, 0b1)};
}

}  // namespace tetrakis::detail
