#pragma once

#include "../mesh/control_mesh.hpp"
#include "site.hpp"

#include <array>
#include <bit>
#include <cstdint>

namespace tetrakis {

/// The sides of the corner cell Q(h) of the half-edge h: v -> w in a face with centre c: the quadrilateral
/// [v, m(h), c, m(prev h)], x along v -> m(h), y along v -> m(prev h).
enum class CellSide : std::uint8_t {
    edge,       ///< y = 0, on the edge h; beyond it Q(next(twin h))
    prev_edge,  ///< x = 0, on the edge prev h; beyond it Q(twin(prev h))
    next_cell,  ///< x = N, towards Q(next h)
    prev_cell,  ///< y = N, towards Q(prev h)
};

/// A point in the frame of a corner cell that may lie beyond its sides. The unit is whatever the caller counts in:
/// lattice steps, or half-steps to address cell centres.
struct CellPoint {
    HalfedgeId root;
    std::int64_t x = 0, y = 0;
    friend constexpr auto operator<=>(const CellPoint&, const CellPoint&) = default;
};

/// The corner cell beyond a side; invalid on the boundary. Hole faces are faces here.
inline HalfedgeId across(const ControlMesh& mesh, HalfedgeId root, CellSide side) {
    switch (side) {
        case CellSide::edge:
            return mesh.cw_outgoing(root);
        case CellSide::prev_edge:
            return mesh.ccw_outgoing(root);
        case CellSide::next_cell:
            return mesh.next(root);
        case CellSide::prev_cell:
            return mesh.prev(root);
    }
    return {};
}

/// The same point in the frame of the cell beyond `side`, whose lattice continues this one straight on: a quarter turn.
/// `size` is the length of a side in the unit of the coordinates. Root invalid where the side is on the boundary.
inline CellPoint cross(const ControlMesh& mesh, const CellPoint& p, CellSide side, std::int64_t size) {
    const HalfedgeId root = across(mesh, p.root, side);
    switch (side) {
        case CellSide::edge:
            return {root, -p.y, p.x};
        case CellSide::prev_edge:
            return {root, p.y, -p.x};
        case CellSide::next_cell:
            return {root, p.y, 2 * size - p.x};
        case CellSide::prev_cell:
            return {root, 2 * size - p.y, p.x};
    }
    return {root, p.x, p.y};
}

/// The same point at the lowest level that has it: coordinates are halved as long as both are even.
constexpr Site minimal_level(Site site) {
    // The bit of the level keeps the shift at or below the level; the point (0, 0) has no other bit.
    const std::uint32_t bits = site.at.x | site.at.y | (1u << site.level);
    const int shift = std::countr_zero(bits);
    return {site.root, {site.at.x >> shift, site.at.y >> shift}, static_cast<std::uint8_t>(site.level - shift)};
}

namespace detail {
Site canonical_on_side(const ControlMesh& mesh, const Site& minimal);
}

/// The one address by which a point of the quad family's lattice is keyed and evaluated: at its lowest level, in the
/// frame of one of the corner cells around it. Cells of surface faces come before cells of holes; among equals the
/// smallest half-edge is taken, at a control vertex the first one counter-clockwise from
/// ControlMesh::vertex_halfedge().
/// @param site  any address of the point, 0 <= x, y <= 2^level, level <= k_max_level
/// Cost: O(1); O(valence) at control vertices that touch a hole.
inline Site canonical(const ControlMesh& mesh, const Site& site) {
    const std::uint32_t n = 1u << site.level;
    const bool interior = site.at.x - 1u < n - 1u && site.at.y - 1u < n - 1u;  // 0 < x, y < n
    // Two calls instead of one variable: a variable whose address is passed on is built in memory, which costs time.
    if (interior) return minimal_level(site);
    return detail::canonical_on_side(mesh, minimal_level(site));
}

/// Barycentric coordinates in a face of three corners, as whole numbers.
using TriangleWeights = std::array<std::int64_t, 3>;
/// The same point in the face across the half-edge h, with both triangles laid out as a parallelogram.
TriangleWeights across(const ControlMesh& mesh, HalfedgeId h, const TriangleWeights& weight);

// Side s of a triangle root runs from corner s to corner s + 1 (mod 3), along the half-edge `root + s`: side 0 is y =
// 0, side 1 is x + y = 2^level, side 2 is x = 0.

/// The canonical site of a point of a triangle mesh, at its minimal level: on a control edge in the face with the
/// smaller number, at a control vertex in the face of ControlMesh::vertex_halfedge(). Hole faces count as roots: the
/// surface is defined over them too. O(1).
/// @param site  any address, with x + y <= 2^level
Site canonical_triangle_site(const ControlMesh& mesh, const Site& site);
/// The same from barycentric weights in a face. Their sum is the number of segments of a side at the point's minimal
/// level: 2^level, or as another lattice has it.
Site canonical_triangle_site(const ControlMesh& mesh, FaceId face, TriangleWeights weight, int level);
/// The canonical site of a control vertex; its root is invalid if the vertex is isolated.
Site triangle_vertex_site(const ControlMesh& mesh, VertexId v);

}  // namespace tetrakis
