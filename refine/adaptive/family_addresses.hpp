#pragma once

#include "../../hier/forest/corner_cell.hpp"
#include "../../hier/forest/site.hpp"
#include "../../hier/mesh/control_mesh.hpp"

#include <array>
#include <cstdint>
#include <type_traits>

namespace tetrakis {

/// The 4-8 triangle over an edge: from the edge's ends to the centre of the half-edge's face.
inline CellTriangle root_triangle(HalfedgeId h) { return {h, 0, {LatticePoint{0, 0}, {2, 0}, {1, 1}}}; }

/// Addresses in the roots of the quad family: corner cells with the 4-8 triangles over them.
struct QuadAddresses {
    static Site canonical_site(const ControlMesh& mesh, const Site& site) { return canonical(mesh, site); }
    /// Whether parameters in [0, 1]^2 lie in the root.
    static bool inside(double, double) { return true; }
    static constexpr double k_middle = 0.5;  ///< both parameters of a root's middle
    /// The control half-edge that contains edge k of a triangle (corner k to corner k + 1); invalid if none.
    static HalfedgeId control_edge(const ControlMesh& mesh, const CellTriangle& t, std::size_t k) {
        const LatticePoint a = t.corner[k], b = t.corner[(k + 1) % 3];
        if (a.y == 0 && b.y == 0) return t.root;
        return a.x == 0 && b.x == 0 ? mesh.prev(t.root) : HalfedgeId{};
    }
    /// The control edge that corner k lies on, except at its ends; invalid if there is none.
    static HalfedgeId control_edge_at(const ControlMesh& mesh, const CellTriangle& t, std::size_t k) {
        const LatticePoint p = t.corner[k];
        if (control_vertex_at(mesh, t, k).valid()) return {};
        return p.y == 0 ? t.root : p.x == 0 ? mesh.prev(t.root) : HalfedgeId{};
    }
    /// The control vertex at corner k; invalid if there is none.
    static VertexId control_vertex_at(const ControlMesh& mesh, const CellTriangle& t, std::size_t k) {
        const LatticePoint p = t.corner[k];
        if (p == LatticePoint{0, 0}) return mesh.origin(t.root);
        return t.level == 0 && p.x == 2 ? mesh.origin(mesh.next(t.root)) : VertexId{};
    }
    /// The site of a leaf's corner, as an address inside one root.
    static Site corner_site(const ControlMesh& mesh, const CellTriangle& t, std::size_t k) {
        return lattice_site(mesh, t.root, t.corner[k], t.level);
    }
    /// The site, inside one root, of a lattice point of any level. `p` may lie in the next root, beyond x = 2^level.
    static Site lattice_site(const ControlMesh& mesh, HalfedgeId root, LatticePoint p, int level) {
        const std::uint32_t n = 1u << level;
        if (p.x > n) return {mesh.next(root), {p.y, 2 * n - p.x}, static_cast<std::uint8_t>(level)};
        return {root, p, static_cast<std::uint8_t>(level)};
    }
    /// Bilinear interpolation of a per-corner attribute in the corner cell of `root`.
    template <class Value>
    static auto linear(const ControlMesh& mesh, HalfedgeId root, double x, double y, Value&& corner) {
        using V = std::remove_cvref_t<decltype(corner(root))>;
        const std::uint32_t size = mesh.face_size(mesh.face(root)), h0 = mesh.face_halfedge(mesh.face(root)).value;
        V centre{};
        for (std::uint32_t i = 0; i < size; ++i) centre += corner(HalfedgeId(h0 + i));
        centre *= 1.0 / size;
        const V v = corner(root), a = 0.5 * (v + corner(mesh.next(root))), b = 0.5 * (v + corner(mesh.prev(root)));
        return V((1 - y) * ((1 - x) * v + x * a) + y * ((1 - x) * b + x * centre));
    }
};

/// Addresses in the roots of the triangle family, which are the faces. Members are those of QuadAddresses.
struct TriangleAddresses {
    static Site canonical_site(const ControlMesh& mesh, const Site& site) {
        return canonical_triangle_site(mesh, site);
    }
    static bool inside(double x, double y) { return x + y <= 1; }
    static constexpr double k_middle = 1.0 / 3;
    static HalfedgeId control_edge(const ControlMesh& mesh, const CellTriangle& t, std::size_t k) {
        const LatticePoint a = t.corner[k], b = t.corner[(k + 1) % 3];
        const std::uint32_t n = 1u << t.level;
        if (a.x + a.y == n && b.x + b.y == n) return mesh.next(t.root);
        return QuadAddresses::control_edge(mesh, t, k);
    }
    static HalfedgeId control_edge_at(const ControlMesh& mesh, const CellTriangle& t, std::size_t k) {
        const LatticePoint p = t.corner[k];
        if (control_vertex_at(mesh, t, k).valid()) return {};
        if (p.x + p.y == 1u << t.level) return mesh.next(t.root);
        return p.y == 0 ? t.root : p.x == 0 ? mesh.prev(t.root) : HalfedgeId{};
    }
    static VertexId control_vertex_at(const ControlMesh& mesh, const CellTriangle& t, std::size_t k) {
        const LatticePoint p = t.corner[k];
        if (p == LatticePoint{0, 0}) return mesh.origin(t.root);
        if (p == LatticePoint{1u << t.level, 0}) return mesh.origin(mesh.next(t.root));
        return p == LatticePoint{0, 1u << t.level} ? mesh.origin(mesh.prev(t.root)) : VertexId{};
    }
    static Site corner_site(const ControlMesh&, const CellTriangle& t, std::size_t k) {
        return {t.root, t.corner[k], t.level};
    }
    static Site lattice_site(const ControlMesh&, HalfedgeId root, LatticePoint p, int level) {
        return {root, p, static_cast<std::uint8_t>(level)};
    }
    template <class Value>
    static auto linear(const ControlMesh& mesh, HalfedgeId root, double x, double y, Value&& corner) {
        using V = std::remove_cvref_t<decltype(corner(root))>;
        return V((1 - x - y) * corner(root) + x * corner(mesh.next(root)) + y * corner(mesh.prev(root)));
    }
};

/// Whether edge k of a hierarchy's triangle lies on a boundary, at a hole, or on an infinitely sharp edge.
template <class Family>
bool is_hard_edge(const ControlMesh& mesh, const CellTriangle& triangle, std::size_t k) {
    const HalfedgeId h = Family::control_edge(mesh, triangle, k);
    if (!h.valid()) return false;
    const HalfedgeId t = mesh.twin(h);
    return !t.valid() || mesh.is_hole(mesh.face(t)) || mesh.sharpness(mesh.edge(h)) == k_sharpness_infinity;
}

template <class Family>
std::array<bool, 3> hard_edges(const ControlMesh& mesh, const CellTriangle& triangle) {
    return {is_hard_edge<Family>(mesh, triangle, 0), is_hard_edge<Family>(mesh, triangle, 1),
            is_hard_edge<Family>(mesh, triangle, 2)};
}

}  // namespace tetrakis
