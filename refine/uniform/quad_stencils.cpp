#include "../../hier/base/parallel.hpp"
#include "../../schemes/core/sharpness.hpp"
#include "../../schemes/rules/catmull_clark.hpp"
#include "level_ring.hpp"
#include "mesh_level.hpp"
#include "site_stencils.hpp"

namespace tetrakis::detail {

namespace {

/// Points of the first refinement into quads by Catmull-Clark; gathers only, so every thread count gives the same.
class PointRefiner {
  public:
    /// @param finer  in the vertex order of refine_to_quads()
    PointRefiner(const MeshLevel& level, CreaseMethod method, std::span<const Vec3d> points, std::span<Vec3d> finer)
        : level_(level),
          method_(method),
          points_(points),
          old_(finer.first(level.vertex_count)),
          faces_(finer.subspan(level.vertex_count, level.face_count)),
          edges_(finer.subspan(std::size_t{level.vertex_count} + level.face_count, level.edge_count)) {}

    void run() {
        for_each_index(level_.face_count, [&](std::uint32_t f) { faces_[f] = face_point(f); });
        for_each_block(level_.edge_count, k_default_grain, [&](std::uint32_t begin, std::uint32_t end) {
            LevelRing scratch;
            for (std::uint32_t e = begin; e < end; ++e) edges_[e] = edge_point(e, scratch);
        });
        for_each_block(level_.vertex_count, k_default_grain, [&](std::uint32_t begin, std::uint32_t end) {
            LevelRing scratch;
            for (std::uint32_t v = begin; v < end; ++v) old_[v] = vertex_point(v, scratch);
        });
    }

  private:
    Vec3d face_point(std::uint32_t f) const {
        const std::uint32_t begin = level_.first_halfedge(f), size = level_.size_of(f);
        const std::uint32_t* v = &level_.origin[begin];
        if (size == 4) return 0.25 * ((points_[v[0]] + points_[v[1]]) + (points_[v[2]] + points_[v[3]]));
        Vec3d sum(0);
        for (std::uint32_t i = 0; i < size; ++i) sum += points_[v[i]];
        return sum / static_cast<double>(size);
    }

    Vec3d edge_point(std::uint32_t e, LevelRing& scratch) const {
        const std::uint32_t h = level_.edge_halfedge[e], t = level_.twin[h];
        const Vec3d ends =
            points_[level_.origin[h]] + points_[level_.origin[t == MeshLevel::none ? level_.next(h) : t]];
        if (t == MeshLevel::none) return 0.5 * ends;
        const double crease = level_.has_tags() ? crease_weight(level_, method_, e, scratch) : 0;
        if (crease == 1) return 0.5 * ends;
        const Vec3d smooth = CatmullClark::edge_end * ends +
                             CatmullClark::edge_face_point * (faces_[level_.face_of(h)] + faces_[level_.face_of(t)]);
        return crease == 0 ? smooth : crease * 0.5 * ends + (1 - crease) * smooth;
    }

    Vec3d vertex_point(std::uint32_t v, LevelRing& scratch) const {
        const std::uint32_t start = level_.vertex_halfedge[v];
        if (start == MeshLevel::none) return points_[v];
        if (level_.has_tags() && level_.tagged[v] != 0) return tagged_point(v, scratch);
        Vec3d edges = points_[level_.origin[level_.next(start)]], corners(0);
        std::uint32_t n = 1;
        for (std::uint32_t h = start;; ++n) {
            corners += faces_[level_.face_of(h)];
            const std::uint32_t before = level_.prev(h);
            h = level_.twin[before];
            if (h == start) break;
            edges += points_[level_.origin[before]];
        }
        const RingMask m = CatmullClark::vertex_mask(static_cast<int>(n));
        return m.vertex * points_[v] + m.edge * edges + m.face * corners;
    }

    Vec3d tagged_point(std::uint32_t v, LevelRing& around) const {
        around.gather(level_, method_, v);
        const float s = level_.vertex_sharpness[v];
        const VertexBlend blend = vertex_blend(around.sharpness, s, around.child, child_sharpness(s));
        Vec3d point = (blend.corner + blend.crease.weight * k_crease_vertex_mask.vertex) * points_[v];
        if (blend.crease.weight > 0)
            point += blend.crease.weight * k_crease_vertex_mask.neighbour *
                     (points_[around.neighbours[blend.crease.a]] + points_[around.neighbours[blend.crease.b]]);
        if (blend.smooth > 0) {
            Vec3d edges(0), corners(0);
            for (const std::uint32_t w : around.neighbours) edges += points_[w];
            for (const std::uint32_t h : around.halfedges) corners += faces_[level_.face_of(h)];
            const RingMask m = CatmullClark::vertex_mask(static_cast<int>(around.neighbours.size()));
            point += blend.smooth * (m.vertex * points_[v] + m.edge * edges + m.face * corners);
        }
        return point;
    }

    const MeshLevel& level_;
    CreaseMethod method_;
    std::span<const Vec3d> points_;
    std::span<Vec3d> old_, faces_, edges_;
};

}  // namespace

QuadStencils::QuadStencils(const ControlMesh& mesh)
    : mesh_(&mesh), sharpness_(mesh), base_(std::size_t{mesh.vertex_count()} + mesh.face_count() + mesh.edge_count()) {
    // Faces of any size end with the first step.
    const MeshLevel level = control_level(mesh);
    PointRefiner(level, mesh.crease_method(), mesh.positions(), base_).run();
}

std::uint32_t QuadStencils::base_number(VertexKey key) const {
    const HalfedgeId h(key.root);
    if (key.y == 1) return mesh_->vertex_count() + mesh_->face(h).value;
    if (key.x == 1) return mesh_->vertex_count() + mesh_->face_count() + mesh_->edge(h).value;
    return mesh_->origin(h).value;
}

VertexKey QuadStencils::canonical(VertexKey at, int level) const {
    const std::uint32_t n = std::uint32_t{1} << level;
    const HalfedgeId h(at.root);
    if (at.x != 0 && at.y != 0 && at.x != n && at.y != n) return at;
    if (at.x == n && at.y == n) return {mesh_->face_halfedge(mesh_->face(h)).value, n, n};
    if (at.x == 0 && at.y == 0) return {mesh_->vertex_halfedge(mesh_->origin(h)).value, 0, 0};
    if (at.x == n && at.y == 0) return {mesh_->edge_halfedge(mesh_->edge(h)).value, n, 0};
    if (at.y == n)
        return at.x == 0 ? canonical({mesh_->prev(h).value, n, 0}, level) : VertexKey{mesh_->prev(h).value, n, at.x};
    if (at.x == 0) {
        const HalfedgeId t = mesh_->ccw_outgoing(h);
        if (t.valid()) return {t.value, at.y, 0};
    }
    return at;
}

void QuadStencils::ring(VertexKey key, int level, KeyRing& ring) const {
    const std::uint32_t n = std::uint32_t{1} << level, x = key.x, y = key.y;
    const HalfedgeId h(key.root);
    const int scheme_level = level + 1;
    ring.clear();
    ring.faces = 4;
    const auto add = [&](HalfedgeId root, std::uint32_t px, std::uint32_t py) {
        ring.keys.push_back(canonical({root.value, px, py}, level));
    };
    ring.keys.push_back(key);
    if (x == 0 && y == 0) {
        ring.faces = 0;
        HalfedgeId out = h;
        for (;;) {
            add(out, 1, 0);
            add(out, 1, 1);
            ++ring.faces;
            const HalfedgeId next = mesh_->ccw_outgoing(out);
            if (next == h) break;
            if (!next.valid()) {
                ring.boundary = true;
                add(out, 0, 1);
                break;
            }
            out = next;
        }
        control_vertex_tags(*mesh_, sharpness_, mesh_->origin(h), scheme_level, ring);
    } else if (x == n && y == n) {
        ring.faces = 0;
        HalfedgeId side = h;
        do {
            add(side, n, n - 1);
            side = mesh_->next(side);
            add(side, n - 1, n - 1);
            ++ring.faces;
        } while (side != h);
    } else if (x == n && y == 0) {
        const HalfedgeId t = mesh_->twin(h), next = mesh_->next(h);
        add(next, 0, n - 1);
        add(next, 1, n - 1);
        add(h, n, 1);
        add(h, n - 1, 1);
        add(h, n - 1, 0);
        ring.boundary = !t.valid();
        if (t.valid()) {
            add(mesh_->next(t), 1, n - 1);
            add(t, n, 1);
            add(t, n - 1, 1);
        }
        ring.faces = t.valid() ? 4 : 2;
        edge_point_tags(sharpness_, h, scheme_level, n, 2, 0, t.valid() ? 4 : 3, ring);
    } else if (y == 0) {
        const HalfedgeId t = mesh_->twin(h);
        add(h, x + 1, 0);
        add(h, x + 1, 1);
        add(h, x, 1);
        add(h, x - 1, 1);
        add(h, x - 1, 0);
        ring.boundary = !t.valid();
        if (t.valid()) {
            const HalfedgeId beyond = mesh_->next(t);
            add(beyond, 1, x - 1);
            add(beyond, 1, x);
            add(beyond, 1, x + 1);
        }
        ring.faces = t.valid() ? 4 : 2;
        edge_point_tags(sharpness_, h, scheme_level, x, 2, 0, t.valid() ? 4 : 3, ring);
    } else if (x == 0) {  // on a boundary that ends at the vertex
        ring.faces = 2;
        ring.boundary = true;
        add(h, 0, y - 1);
        add(h, 1, y - 1);
        add(h, 1, y);
        add(h, 1, y + 1);
        add(h, 0, y + 1);
        for (auto* values : {&ring.sharpness, &ring.child, &ring.outer_child})
            values->assign({k_sharpness_infinity, 0.0f, k_sharpness_infinity});
    } else if (x == n) {
        const HalfedgeId beyond = mesh_->next(h);
        add(h, n, y + 1);
        add(h, n - 1, y + 1);
        add(h, n - 1, y);
        add(h, n - 1, y - 1);
        add(h, n, y - 1);
        add(beyond, y - 1, n - 1);
        add(beyond, y, n - 1);
        add(beyond, y + 1, n - 1);
    } else {
        add(h, x + 1, y);
        add(h, x + 1, y + 1);
        add(h, x, y + 1);
        add(h, x - 1, y + 1);
        add(h, x - 1, y);
        add(h, x - 1, y - 1);
        add(h, x, y - 1);
        add(h, x + 1, y - 1);
    }
}

void QuadStencils::stencil(VertexKey key, int level, KeyRing& scratch, std::vector<StencilEntry>& out) const {
    const HalfedgeId h(key.root);
    const std::uint32_t a = key.x / 2, b = key.y / 2, n = std::uint32_t{1} << (level - 1);
    const bool x_odd = (key.x & 1) != 0, y_odd = (key.y & 1) != 0;
    const auto add = [&](HalfedgeId root, std::uint32_t x, std::uint32_t y, double w) {
        out.push_back({canonical({root.value, x, y}, level - 1), w});
    };
    if (!x_odd && !y_odd) {
        ring({key.root, a, b}, level - 1, scratch);
        vertex_rule_stencil(scheme, scratch, out);
        return;
    }
    if (x_odd && y_odd) {
        for (std::uint32_t i = 0; i < 4; ++i) add(h, a + (i & 1), b + (i >> 1), 0.25);
        return;
    }
    const std::uint32_t dx = x_odd ? 1 : 0, dy = 1 - dx;
    double crease = 0;
    HalfedgeId beyond;
    bool spoke = false;
    if (key.y == 0) {
        const HalfedgeId t = mesh_->twin(h);
        // Piece a of h's edge, at the scheme level of the stencil's vertices.
        crease = t.valid() ? edge_crease_weight(sharpness_.piece(h, level, a), sharpness_.piece(h, level + 1, 2 * a),
                                                sharpness_.piece(h, level + 1, 2 * a + 1))
                           : 1;
        if (t.valid()) beyond = mesh_->next(t);
    } else if (key.x == 0) {
        crease = 1;
    } else if (a == n && !x_odd) {
        spoke = true;
        beyond = mesh_->next(h);
    }
    const double end = crease * 0.5 + (1 - crease) * CatmullClark::edge_end_quads;
    add(h, a, b, end);
    add(h, a + dx, b + dy, end);
    if (crease == 1) return;
    const double side = (1 - crease) * CatmullClark::edge_side_quads;
    // One pair on each side of the edge: inside the cell, and inside or beyond its border.
    if (key.y == 0) {
        for (std::uint32_t i = 0; i < 2; ++i) add(h, a + i, 1, side);
        for (std::uint32_t i = 0; i < 2; ++i) add(beyond, 1, a + i, side);
    } else if (spoke) {
        for (std::uint32_t i = 0; i < 2; ++i) add(h, n - 1, b + i, side);
        for (std::uint32_t i = 0; i < 2; ++i) add(beyond, b + i, n - 1, side);
    } else {
        for (std::uint32_t i = 0; i < 2; ++i) add(h, a + i * dx + dy, b + i * dy + dx, side);
        for (std::uint32_t i = 0; i < 2; ++i) add(h, a + i * dx - dy, b + i * dy - dx, side);
    }
}

}  // namespace tetrakis::detail
