#pragma once

#include "../core/rule_step.hpp"

#include <algorithm>
#include <compare>
#include <cstddef>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

namespace tetrakis::detail {

/// The other halves of a split mesh's half-edges, most of them known from the way they are made. The few along creases
/// and between ends are matched by their ends.
class SplitTwins {
  public:
    /// Of the quad of an old half-edge: the half-edge from its child ahead of it, out of its face, and the one back to
    /// the child of the next one.
    std::vector<int> ahead, behind;

    SplitTwins(int halfedges, std::size_t corners)
        : ahead(halfedges, RuleMesh::none), behind(halfedges, RuleMesh::none), twin_(corners, RuleMesh::none) {}

    void link(int a, int b) {
        make_room(std::max(a, b));
        twin_[a] = b;
        twin_[b] = a;
    }
    void search(int h, int from, int to) { open_.push_back({std::min(from, to), std::max(from, to), from > to, h}); }
    /// The mesh has parts that are not of this kind.
    void give_up() { whole_ = false; }

    std::optional<std::vector<int>> finish(int halfedges) && {
        std::sort(open_.begin(), open_.end());
        make_room(halfedges - 1);
        for (std::size_t i = 0; i < open_.size();) {
            std::size_t end = i + 1;
            while (end < open_.size() && open_[end].low == open_[i].low && open_[end].high == open_[i].high) ++end;
            if (end > i + 2 || (end == i + 2 && open_[i].down == open_[i + 1].down)) whole_ = false;
            if (whole_ && end == i + 2) link(open_[i].halfedge, open_[i + 1].halfedge);
            i = end;
        }
        if (!whole_) return std::nullopt;
        twin_.resize(halfedges);
        return std::move(twin_);
    }

  private:
    struct Open {
        int low, high;
        bool down;
        int halfedge;
        auto operator<=>(const Open&) const = default;
    };
    void make_room(int h) {
        if (static_cast<std::size_t>(h) >= twin_.size()) twin_.resize(h + 1, RuleMesh::none);
    }

    std::vector<int> twin_;
    std::vector<Open> open_;
    bool whole_ = true;
};

/// The dual split: each face shrinks, each edge becomes a quad, each vertex a face. New points: one per half-edge (the
/// corner at its origin), then two per sharp edge (at the origin and at the target of its edge_halfedge()), then one
/// per corner vertex (three or more sharp edges, or tagged and on a crease).
///
/// A boundary is as if each of its edges were a degenerate quad with itself (its "edge replication"), of which only the
/// two points near the edge are kept; a crease is a boundary for each of its sides, and both have the same points
/// there. That is so for ever, however sharp the crease is: semi-sharp edges and vertices count as infinitely sharp.
/// @param corner_row, crease_row, tip_row  (half-edge), (sharp half-edge: the point at its origin), (corner vertex)
template <class CornerRow, class CreaseRow, class TipRow>
RuleStep split_vertices(const RuleMesh& mesh, const BlockRunner* runner, CornerRow&& corner_row, CreaseRow&& crease_row,
                        TipRow&& tip_row) {
    constexpr float k_sharp = std::numeric_limits<float>::infinity();
    RuleStep step;
    const int H = mesh.halfedge_count();
    step.stencils.push_rows(runner, H, corner_row);
    int count = H;
    std::vector<int> crease_point(mesh.edge_count(), -1);  // the first of its two
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
    SplitTwins twins(H, corners);
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
            const int quad = faces.halfedge_count();
            twins.link(h, quad + 3);
            twins.link(t, quad + 1);
            twins.ahead[h] = quad;
            twins.ahead[t] = quad + 2;
            faces.face({h, mesh.next(t), t, mesh.next(h)});
            step.parent_face.push_back(mesh.face(h));
            continue;
        }
        twins.link(h, faces.halfedge_count() + 3);
        twins.ahead[h] = faces.halfedge_count();
        twins.behind[h] = faces.halfedge_count() + 2;
        if (t != RuleMesh::none) twins.search(faces.halfedge_count() + 1, on_crease(h, u), on_crease(h, v));
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
            if (sharp_count == 0 && ring.faces() < 3) {  // the two quads beside it share their edge
                twins.give_up();
                continue;
            }
            const int start = sharp_count == 1 ? sharp[0] : 0;
            if (sharp_count == 1) {
                twins.link(faces.halfedge_count(), twins.ahead[ring.halfedge[start]]);
                faces.corner(crease_at(start));
            }
            for (int i = 0; i < ring.faces(); ++i) {
                const int h = ring.halfedge[(start + i) % ring.faces()];
                const bool to_crease = sharp_count == 1 && i + 1 == ring.faces();
                twins.link(faces.halfedge_count(), to_crease
                                                       ? twins.behind[mesh.prev(h)]
                                                       : twins.ahead[ring.halfedge[(start + i + 1) % ring.faces()]]);
                faces.corner(h);
            }
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
            twins.link(faces.halfedge_count(), twins.ahead[ring.halfedge[from]]);
            faces.corner(crease_at(from));
            int last_in = from;
            for (int i = from; ring.closed ? i % ring.faces() != to || i == from : i < to; ++i) {
                if (i > from) twins.link(faces.halfedge_count() - 1, twins.ahead[ring.halfedge[i % ring.faces()]]);
                last_in = i % ring.faces();
                faces.corner(ring.halfedge[last_in]);
            }
            twins.link(faces.halfedge_count() - 1, twins.behind[mesh.prev(ring.halfedge[last_in])]);
            if (corner) {
                twins.search(faces.halfedge_count(), crease_at(to), end);
                twins.search(faces.halfedge_count() + 1, end, crease_at(from));
            } else {
                twins.search(faces.halfedge_count(), crease_at(to), crease_at(from));
            }
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
    if (auto known = std::move(twins).finish(faces.halfedge_count())) faces.set_twins(std::move(*known));
    step.mesh = RuleMesh(count, std::move(faces), std::move(sharpness));
    return step;
}

/// What the faces of split_vertices() lie around, in their order: calls face(face), edge(half-edge), once for each side
/// of a sharp edge, and vertex(vertex, i), i = 0, 1, ... for its sectors between sharp edges.
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
