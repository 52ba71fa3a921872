#pragma once

#include "../core/corner_angles.hpp"
#include "../core/masks.hpp"
#include "../core/rule_step.hpp"

namespace tetrakis::detail {

/// Sharpness of the halves of edges one level down, by uniform or by Chaikin's creasing.
class HalfSharpness {
  public:
    explicit HalfSharpness(const RuleMesh& mesh, bool chaikin = false) : mesh_(mesh) {
        if (!chaikin) return;
        at_origin_.resize(static_cast<std::size_t>(mesh.halfedge_count()));
        for (int v = 0; v < mesh.vertex_count(); ++v) {
            if (mesh.first(v) == RuleMesh::none) continue;
            const RuleMesh::Ring ring = mesh.ring(v);
            for (int i = 0; i < ring.faces(); ++i)
                at_origin_[static_cast<std::size_t>(ring.halfedge[i])] =
                    child_sharpness_chaikin(ring.sharpness[i], {ring.sharpness.begin(), ring.sharpness.end()});
        }
    }

    /// Sharpness of the half of the edge of `h` that is at the origin of `h`, or at its target.
    float at_origin(int h) const {
        return at_origin_.empty() ? child_sharpness(mesh_.sharpness(h)) : at_origin_[static_cast<std::size_t>(h)];
    }
    float at_target(int h) const {
        const int t = mesh_.twin(h);
        return t == RuleMesh::none ? child_sharpness(mesh_.sharpness(h)) : at_origin(t);
    }
    /// Sharpness, one level down, of the edges around the middle vertex of `ring`.
    ShortList<float, 8> around(const RuleMesh::Ring& ring) const {
        ShortList<float, 8> result;
        for (int i = 0; i < ring.edges(); ++i)
            result.push_back(i < ring.faces() ? at_origin(ring.halfedge[i]) : child_sharpness(ring.sharpness[i]));
        return result;
    }
    /// See edge_crease_weight().
    double crease_weight(int h) const { return edge_crease_weight(mesh_.sharpness(h), at_origin(h), at_target(h)); }

  private:
    const RuleMesh& mesh_;
    std::vector<float> at_origin_;  ///< per half-edge; empty for uniform creasing
};

/// Vertex sharpness one level down for a mesh with more vertices.
inline std::vector<float> child_vertex_sharpness(const RuleMesh& mesh, int fine_vertices) {
    if (mesh.vertex_sharpness().empty()) return {};
    std::vector<float> result(fine_vertices, 0.0f);
    for (int v = 0; v < mesh.vertex_count(); ++v) result[v] = child_sharpness(mesh.vertex_sharpness(v));
    return result;
}

/// Splits each triangle in four. New points: the old vertices, then one per edge.
/// @param vertex_row, edge_row  (vertex) and (half-edge of the edge) to StencilRow; called by many threads at once
template <class VertexRow, class EdgeRow>
RuleStep split_triangles(const RuleMesh& mesh, const HalfSharpness& halves, const BlockRunner* runner,
                         VertexRow&& vertex_row, EdgeRow&& edge_row) {
    RuleStep step;
    const int V = mesh.vertex_count(), H = mesh.halfedge_count();
    step.stencils.push_rows(runner, V, vertex_row);
    step.stencils.push_rows(runner, mesh.edge_count(), [&](int e) { return edge_row(mesh.edge_halfedge(e)); });
    RuleMesh::Builder faces;
    const std::size_t fine = 4 * static_cast<std::size_t>(H);
    faces.reserve(fine / 3, fine);
    step.child_halfedge.resize(H);
    for (int f = 0; f < mesh.face_count(); ++f) {
        const int h = mesh.face_begin(f);
        for (int i = 0; i < 3; ++i) {
            const int at = h + i, before = mesh.prev(at);
            step.child_halfedge[at] = faces.halfedge_count();
            faces.corner(mesh.origin(at), halves.at_origin(at));
            faces.corner(V + mesh.edge(at), 0, f);  // tag f: triangles that share two edges share these points, too
            faces.corner(V + mesh.edge(before), halves.at_target(before));
            faces.end_face();
        }
        faces.face({V + mesh.edge(h), V + mesh.edge(h + 1), V + mesh.edge(h + 2)}, f);
        step.parent_face.insert(step.parent_face.end(), 4, f);
    }
    faces.set_corner_angles(child_corner_angles(mesh, step.child_halfedge, fine));
    const int count = V + mesh.edge_count();
    step.mesh = RuleMesh(count, std::move(faces), child_vertex_sharpness(mesh, count));
    return step;
}

inline std::vector<int> split_polygons_children(const RuleMesh& mesh) {
    std::vector<int> result(mesh.halfedge_count());
    for (int h = 0; h < mesh.halfedge_count(); ++h) result[h] = 4 * h;
    return result;
}

/// The mesh of split_polygons() below: quads, one per half-edge.
inline RuleMesh split_polygons(const RuleMesh& mesh, const HalfSharpness& halves) {
    const int V = mesh.vertex_count(), E = mesh.edge_count();
    RuleMesh::Builder faces;
    const auto quads = static_cast<std::size_t>(mesh.halfedge_count());
    faces.reserve(quads, 4 * quads);
    std::vector<int> twins;
    twins.reserve(4 * quads);
    const auto half_into = [&](int h) { return h == RuleMesh::none ? h : 4 * mesh.next(h) + 3; };
    const auto half_from = [&](int h) { return h == RuleMesh::none ? h : 4 * h; };
    for (int h = 0; h < mesh.halfedge_count(); ++h) {
        const int before = mesh.prev(h);
        for (const int twin :
             {half_into(mesh.twin(h)), 4 * mesh.next(h) + 2, 4 * before + 1, half_from(mesh.twin(before))})
            twins.push_back(twin);
        faces.corner(mesh.origin(h), halves.at_origin(h));
        faces.corner(V + mesh.edge(h));
        faces.corner(V + E + mesh.face(h));
        faces.corner(V + mesh.edge(before), halves.at_target(before));
        faces.end_face();
    }
    faces.set_twins(std::move(twins));
    if (mesh.has_corner_angles())
        faces.set_corner_angles(child_corner_angles(mesh, split_polygons_children(mesh), 4 * quads));
    const int count = V + E + mesh.face_count();
    return RuleMesh(count, std::move(faces), child_vertex_sharpness(mesh, count));
}

/// Splits each k-gon in k quads. New points: the old vertices, then one per edge, then one per face.
template <class VertexRow, class EdgeRow, class FaceRow>
RuleStep split_polygons(const RuleMesh& mesh, const HalfSharpness& halves, const BlockRunner* runner,
                        VertexRow&& vertex_row, EdgeRow&& edge_row, FaceRow&& face_row) {
    RuleStep step;
    step.stencils.push_rows(runner, mesh.vertex_count(), vertex_row);
    step.stencils.push_rows(runner, mesh.edge_count(), [&](int e) { return edge_row(mesh.edge_halfedge(e)); });
    step.stencils.push_rows(runner, mesh.face_count(), face_row);
    step.mesh = split_polygons(mesh, halves);
    for (int h = 0; h < mesh.halfedge_count(); ++h) step.parent_face.push_back(mesh.face(h));
    step.child_halfedge = split_polygons_children(mesh);
    return step;
}

/// The mean of a face's corners.
inline StencilRow face_mean(const RuleMesh& mesh, int f) {
    StencilRow row;
    for (const int v : mesh.corners(f)) row.add(v, 1.0 / mesh.face_size(f));
    return row;
}

/// A vertex that stays where it is.
inline StencilRow vertex_itself(int v) { return {{v, 1}}; }
inline StencilRow edge_midpoint(const RuleMesh& mesh, int h) { return {{mesh.origin(h), 0.5}, {mesh.target(h), 0.5}}; }
/// A vertex and its neighbours.
inline StencilRow ring_row(int v, const RuleMesh::Ring& ring, const RingMask& mask) {
    StencilRow row{{v, mask.vertex}};
    for (const int e : ring.neighbour) row.add(e, mask.edge);
    return row;
}

/// The corner of a triangle opposite its half-edge.
inline int opposite(const RuleMesh& mesh, int h) { return mesh.origin(mesh.prev(h)); }

/// vertex_blend() and edge_crease_weight() under uniform creasing, where sharpness falls by one per level.
inline VertexBlend uniform_vertex_blend(const ShortList<float, 8>& edges, float vertex) {
    ShortList<float, 8> children;
    for (const float s : edges) children.push_back(child_sharpness(s));
    return vertex_blend(edges, vertex, children, child_sharpness(vertex));
}
inline double uniform_crease_weight(float sharpness) {
    const float child = child_sharpness(sharpness);
    return edge_crease_weight(sharpness, child, child);
}

/// Row of a vertex by vertex_blend(): a combination of the smooth rule's row, smooth_row(ring), of the crease mask
/// along two ring edges, and of the vertex itself.
template <class SmoothRow>
StencilRow blended_vertex_row(const RuleMesh& mesh, int v, const HalfSharpness& halves, SmoothRow&& smooth_row) {
    const RuleMesh::Ring ring = mesh.ring(v);
    if (ring.faces() == 0) return vertex_itself(v);
    const float sharpness = mesh.vertex_sharpness(v);
    const VertexBlend blend = vertex_blend(ring.sharpness, sharpness, halves.around(ring), child_sharpness(sharpness));
    StencilRow row;
    if (blend.corner != 0) row.add(v, blend.corner);
    if (blend.crease.weight != 0) {
        row.add(v, blend.crease.weight * k_crease_vertex_mask.vertex);
        for (const int i : {blend.crease.a, blend.crease.b})
            row.add(ring.neighbour[i], blend.crease.weight * k_crease_vertex_mask.neighbour);
    }
    if (blend.smooth != 0) row.add(smooth_row(ring), blend.smooth);
    return row;
}
/// Row of the point on an edge: weight `crease` for its crease rule, and 1 - `crease` for its smooth rule.
template <class SmoothRow>
StencilRow blended_edge_row(double crease, const StencilRow& crease_row, SmoothRow&& smooth_row) {
    StencilRow row;
    if (crease != 0) row.add(crease_row, crease);
    if (crease != 1) row.add(smooth_row(), 1 - crease);
    return row;
}

/// Row of a vertex by the sharp rules: the cubic B-spline's on a crease or boundary; a corner stays. Else it is empty.
inline StencilRow crease_vertex_row(const RuleMesh& mesh, int v, const RuleMesh::Ring& ring) {
    const VertexRule rule = vertex_rule(ring.sharpness, mesh.vertex_sharpness(v));
    if (ring.faces() == 0 || rule == VertexRule::corner) return vertex_itself(v);
    if (rule != VertexRule::crease) return {};
    StencilRow row{{v, k_crease_vertex_mask.vertex}};
    for (int i = 0; i < ring.edges(); ++i)
        if (is_sharp(ring.sharpness[i])) row.add(ring.neighbour[i], k_crease_vertex_mask.neighbour);
    return row;
}

}  // namespace tetrakis::detail
