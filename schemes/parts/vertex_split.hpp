#pragma once

#include "../core/rule_step.hpp"

#include <algorithm>
#include <cstddef>
#include <limits>
#include <vector>

namespace tetrakis::detail {

/// The dual split: each face shrinks, each edge becomes a quad, each vertex a face. New points: one per half-edge (the
/// corner at its origin), then two per sharp edge (at the origin and at the target of its edge_halfedge()), then one
/// per corner vertex (three or more sharp edges, or tagged and on a crease).
///
/// A boundary edge has a degenerate quad between the edge and itself ("edge replication"), of which only the two points
/// near the edge are made. A crease is a boundary for each of its sides, which share these points. Creases never lose
/// their sharpness: semi-sharp edges and vertices count as infinitely sharp.
/// @param corner_row, crease_row, tip_row  (half-edge), (sharp half-edge: the point at its origin), (corner vertex)
template <class CornerRow, class CreaseRow, class TipRow>
RuleStep split_vertices(const RuleMesh& mesh, const BlockRunner* runner, CornerRow&& corner_row, CreaseRow&& crease_row,
                        TipRow&& tip_row) {
    constexpr float k_sharp = std::numeric_limits<float>::infinity();
    RuleStep step;
    const int H = mesh.halfedge_count();
    step.stencils.push_rows(runner, H, corner_row);
    int count = H;
    std::vector<int> crease_point(mesh.edge_count(), -1);  // per sharp edge, the first of its two points
    for (int e = 0; e < mesh.edge_count(); ++e) {
        const int h = mesh.edge_halfedge(e);
        if (!mesh.sharp(h)) continue;
        crease_point[e] = count;
        count += 2;
        step.stencils.push(crease_row(h, mesh.origin(h)));
        step.stencils.push(crease_row(h, mesh.target(h)));
    }
    const auto on_crease = [&](int h, int v) {
        return crease_point[mesh.edge(h)] + (mesh.origin(mesh.edge_halfedge(mesh.edge(h))) == v ? 0 : 1);
    };
    RuleMesh::Builder faces;
    const std::size_t corners = 2 * static_cast<std::size_t>(H) + 4 * static_cast<std::size_t>(mesh.edge_count());
    faces.reserve(static_cast<std::size_t>(mesh.face_count()) + mesh.edge_count() + mesh.vertex_count(), corners);
    step.child_halfedge.resize(H);
    step.child_crease.assign(H, RuleMesh::none);
    for (int f = 0; f < mesh.face_count(); ++f) {
        for (int h = mesh.face_begin(f); h < mesh.face_begin(f) + mesh.face_size(f); ++h) {
            step.child_halfedge[h] = h;
            faces.corner(h);
        }
        faces.end_face();
        step.parent_face.push_back(f);
    }
    for (int h = 0; h < H; ++h) {
        const int t = mesh.twin(h), u = mesh.origin(h), v = mesh.target(h);
        if (!mesh.sharp(h)) {
            if (h > t) continue;
            faces.face({h, mesh.next(t), t, mesh.next(h)});
            step.parent_face.push_back(mesh.face(h));
            continue;
        }
        faces.corner(h);
        step.child_crease[h] = faces.halfedge_count();
        faces.corner(on_crease(h, u), k_sharp);
        faces.corner(on_crease(h, v));
        faces.corner(mesh.next(h));
        faces.end_face();
        step.parent_face.push_back(mesh.face(h));
    }
    std::vector<float> ends;  // sharpness of the corner vertices' points
    for (int v = 0; v < mesh.vertex_count(); ++v) {
        if (mesh.first(v) == RuleMesh::none) continue;
        const RuleMesh::Ring ring = mesh.ring(v);
        ShortList<int, 8> sharp;
        for (int i = 0; i < ring.edges(); ++i)
            if (is_sharp(ring.sharpness[i])) sharp.push_back(i);
        const int sharp_count = static_cast<int>(sharp.size());
        const auto crease_at = [&](int i) {
            return on_crease(i < ring.faces() ? ring.halfedge[i] : mesh.prev(ring.halfedge[i - 1]), v);
        };
        if (sharp_count < 2) {
            if (sharp_count == 0 && ring.faces() < 3) continue;  // no face here: the two quads share an edge
            const int start = sharp_count == 1 ? sharp[0] : 0;
            if (sharp_count == 1) faces.corner(crease_at(start));
            for (int i = 0; i < ring.faces(); ++i) faces.corner(ring.halfedge[(start + i) % ring.faces()]);
            faces.end_face();
            step.parent_face.push_back(mesh.face(mesh.first(v)));
            continue;
        }
        const bool corner = sharp_count > 2 || is_sharp(mesh.vertex_sharpness(v));
        int end = -1;
        if (corner) {
            end = count++;
            ends.push_back(is_sharp(mesh.vertex_sharpness(v)) ? k_sharp : 0.0f);
            step.stencils.push(tip_row(v));
        }
        const int sectors = ring.closed ? sharp_count : sharp_count - 1;
        for (int s = 0; s < sectors; ++s) {
            const int from = sharp[s], to = sharp[(s + 1) % sharp_count];
            faces.corner(crease_at(from));
            for (int i = from; ring.closed ? i % ring.faces() != to || i == from : i < to; ++i)
                faces.corner(ring.halfedge[i % ring.faces()]);
            faces.corner(crease_at(to), k_sharp);
            if (corner) faces.corner(end, k_sharp);
            faces.end_face();
            step.parent_face.push_back(mesh.face(ring.halfedge[from]));
        }
    }
    std::vector<float> sharpness;
    if (!mesh.vertex_sharpness().empty()) {
        sharpness.assign(count, 0.0f);
        std::copy(ends.begin(), ends.end(), sharpness.end() - static_cast<std::ptrdiff_t>(ends.size()));
    }
    step.mesh = RuleMesh(count, std::move(faces), std::move(sharpness));
    return step;
}

/// Calls a function per face of split_vertices(), in their order, with the old element that it comes from: face(face),
/// edge(half-edge), for each side of a sharp edge, and vertex(vertex, i) for its sectors i between sharp edges.
template <class Face, class Edge, class Vertex>
void for_each_split_face(const RuleMesh& mesh, Face&& face, Edge&& edge, Vertex&& vertex) {
    for (int f = 0; f < mesh.face_count(); ++f) face(f);
    for (int h = 0; h < mesh.halfedge_count(); ++h)
        if (mesh.sharp(h) || h < mesh.twin(h)) edge(h);
    for (int v = 0; v < mesh.vertex_count(); ++v) {
        if (mesh.first(v) == RuleMesh::none) continue;
        const int sharp = static_cast<int>(mesh.sharp_neighbours(v).size());
        if (sharp == 0 && mesh.ring(v).faces() < 3) continue;
        const int sectors = sharp < 2 ? 1 : mesh.on_boundary(v) ? sharp - 1 : sharp;
        for (int i = 0; i < sectors; ++i) vertex(v, i);
    }
}

}  // namespace tetrakis::detail
