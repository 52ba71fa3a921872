#include "sqrt3.hpp"

#include "../core/corner_angles.hpp"
#include "../core/scheme_table.hpp"
#include "../parts/face_split.hpp"

#include <cmath>
#include <numbers>

namespace tetrakis {

using std::numbers::pi;

double Sqrt3::alpha(int n) { return (4 - 2 * std::cos(2 * pi / n)) / 9; }

RingMask Sqrt3::vertex_mask(int n) {
    const double a = alpha(n);
    return {.vertex = 1 - a, .edge = a / n};
}

RingMask Sqrt3::limit_mask(int n) {
    const double a = alpha(n), b = 3 * a / (1 + 3 * a);
    return {.vertex = 1 - b, .edge = b / n};
}

namespace {

/// One of the two steps. New triangle h belongs to half-edge h. If the edge of h is smooth, the triangle lies across
/// it, with the origin of h as first corner. The first step keeps sharp edges; the second cuts them in three, when
/// every triangle has one sharp edge at most.
class SimpleStep {
  public:
    SimpleStep(const RuleMesh& mesh, const BlockRunner* runner, bool cuts)
        : mesh_(mesh), cuts_(cuts), centre_(mesh.face_count(), RuleMesh::none) {
        int count = mesh.vertex_count();
        step_.stencils.push_rows(runner, count, [&](int v) { return vertex_row(v); });
        std::vector<int> whole;
        for (int f = 0; f < mesh.face_count(); ++f) {
            if (sharp_side(f) != RuleMesh::none) continue;
            centre_[f] = count++;
            whole.push_back(f);
        }
        step_.stencils.push_rows(runner, static_cast<int>(whole.size()),
                                 [&](int i) { return detail::face_mean(mesh, whole[i]); });
        cut_.assign(mesh.edge_count(), RuleMesh::none);
        for (int e = 0; e < mesh.edge_count() && cuts; ++e) {
            const int h = mesh.edge_halfedge(e);
            if (!mesh.sharp(h)) continue;
            cut_[e] = count;
            count += 2;
            step_.stencils.push(crease_row(mesh.origin(h), mesh.target(h)));
            step_.stencils.push(crease_row(mesh.target(h), mesh.origin(h)));
        }
        RuleMesh::Builder faces;
        faces.reserve(mesh.halfedge_count(), 3 * std::size_t(mesh.halfedge_count()));
        for (int h = 0; h < mesh.halfedge_count(); ++h) {
            step_.parent_face.push_back(mesh.face(h));
            const int v = mesh.origin(h);
            // Two edges may have the same ends, if two triangles share two edges, so edges get tags: on or across an
            // old edge its number, inside a face the face's number.
            const int face = mesh.face(h);
            if (!mesh.sharp(h)) {
                const int t = mesh.twin(h), beyond = beside(t), here = beside(h);
                add_edge(faces, v, v, beyond, t);
                faces.corner(beyond, 0, mesh.edge(h));
                add_edge(faces, here, v, here, h);
            } else if (cuts) {
                faces.corner(on_edge(h, v), child_sharpness(mesh.sharpness(h)), mesh.edge(h));
                faces.corner(on_edge(h, mesh.target(h)), 0, face);
                faces.corner(detail::opposite(mesh, h), 0, face);
            } else {
                faces.corner(v, mesh.sharpness(h), mesh.edge(h));
                faces.corner(mesh.target(h), 0, face);
                faces.corner(centre_[face], 0, face);
            }
            faces.end_face();
        }
        std::vector<float> sharpness = mesh.vertex_sharpness();
        if (!sharpness.empty()) sharpness.resize(count, 0.0f);
        step_.mesh = RuleMesh(count, std::move(faces),
                              cuts ? detail::child_vertex_sharpness(mesh, count) : std::move(sharpness));
    }

    RuleStep take() { return std::move(step_); }

  private:
    /// The half-edge of a face whose edge is cut, if any.
    int sharp_side(int f) const {
        for (int h = mesh_.face_begin(f); cuts_ && h < mesh_.face_begin(f) + 3; ++h)
            if (mesh_.sharp(h)) return h;
        return RuleMesh::none;
    }
    /// The new point on the sharp edge of h, near v.
    int on_edge(int h, int v) const {
        const int e = mesh_.edge(h);
        return cut_[e] + (mesh_.origin(mesh_.edge_halfedge(e)) == v ? 0 : 1);
    }
    /// The new point of the face of h next to the smooth edge of h: the face's centre, or the crease point nearest to
    /// it.
    int beside(int h) const {
        const int f = mesh_.face(h);
        if (centre_[f] != RuleMesh::none) return centre_[f];
        const int side = sharp_side(f);
        return on_edge(side, mesh_.next(side) == h ? mesh_.target(side) : mesh_.origin(side));
    }
    /// Adds the new edge between v and a point of h's face, from `from`; the crease's if the point is on one at v.
    void add_edge(RuleMesh::Builder& faces, int from, int v, int point, int h) const {
        const int side = sharp_side(mesh_.face(h));
        const bool at_crease = side != RuleMesh::none && (mesh_.origin(side) == v || mesh_.target(side) == v);
        if (at_crease && on_edge(side, v) == point)
            faces.corner(from, child_sharpness(mesh_.sharpness(side)), mesh_.edge(side));
        else
            faces.corner(from, 0, mesh_.face(h));
    }
    StencilRow vertex_row(int v) const {
        const RuleMesh::Ring ring = mesh_.ring(v);
        if (ring.faces() == 0) return detail::vertex_itself(v);
        const VertexRule rule = mesh_.rule(v);
        if (ring.closed && rule != VertexRule::crease && rule != VertexRule::corner)
            return detail::ring_row(v, ring, Sqrt3::vertex_mask(ring.edges()));
        if (!cuts_ || rule == VertexRule::corner) return detail::vertex_itself(v);
        StencilRow row{{v, Sqrt3::crease_vertex}};
        for (const int e : mesh_.sharp_neighbours(v)) row.add(e, Sqrt3::crease_neighbour);
        return row;
    }
    /// The point on the crease edge from `at` to `to`, near `at`.
    StencilRow crease_row(int at, int to) const {
        StencilRow row{{at, Sqrt3::crease_middle}, {to, Sqrt3::crease_near}};
        if (mesh_.rule(at) == VertexRule::crease) {
            for (const int e : mesh_.sharp_neighbours(at))
                if (e != to) row.add(e, Sqrt3::crease_far);
        } else {
            row.add(at, 2 * Sqrt3::crease_far);
            row.add(to, -Sqrt3::crease_far);
        }
        return row;
    }

    const RuleMesh& mesh_;
    bool cuts_;
    std::vector<int> centre_, cut_;
    RuleStep step_;
};

}  // namespace

RuleStep sqrt3_step(const RuleMesh& mesh, const RuleOptions& options) {
    detail::need_triangles(mesh, "sqrt3");
    const RuleStep odd = SimpleStep(mesh, options.runner, false).take();
    RuleStep step = SimpleStep(odd.mesh, options.runner, true).take();
    step.stencils = odd.stencils.then(step.stencils, options.runner);
    // Triangle g comes from half-edge g of the first step. The first step's triangle of a smooth edge lies across that
    // edge; of its three triangles the first two are on the other side.
    for (std::size_t g = 0; g < step.parent_face.size(); ++g) {
        const int h = static_cast<int>(g) / 3;
        step.parent_face[g] = mesh.face(g % 3 == 2 || mesh.sharp(h) ? h : mesh.twin(h));
    }
    step.child_halfedge.resize(mesh.halfedge_count());
    // The first step turns edges by half a sector. The second turns the edge to the left of h's triangle back onto h.
    for (int h = 0; h < mesh.halfedge_count(); ++h) step.child_halfedge[h] = 3 * odd.mesh.twin(3 * h + 2);
    return step;
}

ClosedMasks sqrt3_closed_masks(const FanShape& shape, const RuleOptions&) {
    const int n = shape.faces;
    if (shape.dart || (shape.corner && !shape.boundary)) return {};
    if (shape.corner) return corner_closed_masks(n, false);
    if (shape.boundary) return crease_closed_masks(n);
    return ring_closed_masks(n, Sqrt3::limit_mask(n));
}

namespace detail {

extern constinit const SchemeInfo sqrt3_scheme{
    .name = "sqrt3",
    .title = "sqrt(3), Kobbelt 2000",
    .refinement = Refinement::sqrt3,
    .family = MeshFamily::triangles,
    .smoothness = "C2",
    .generation = "1 or more",
    .lattice = FanLattice::triangles,
    .rings = 2,
    .rule_rings = 2,
    .sees_rings = true,
    .step = sqrt3_step,
    .closed_masks = sqrt3_closed_masks,
    .notes = "triangles; two steps at once; boundary and crease as ternary cubic B-spline, corner",
    .one_ring_limits = true,
};

}  // namespace detail
}  // namespace tetrakis
