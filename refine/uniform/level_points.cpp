#include "level_points.hpp"

#include "../../hier/base/parallel.hpp"
#include "../../schemes/core/sharpness.hpp"
#include "../../schemes/rules/catmull_clark.hpp"
#include "level_ring.hpp"
#include "vertex_masks.hpp"

#include <vector>

namespace tetrakis::detail {

namespace {

constexpr std::uint32_t none = MeshLevel::none;

class PointRefiner {
  public:
    PointRefiner(const MeshLevel& level, CreaseMethod method, PointRule rule, std::span<const Vec3d> points,
                 const QuadPoints& finer)
        : level_(level),
          method_(method),
          linear_(rule == PointRule::linear),
          points_(points),
          old_(finer.old),
          faces_(finer.faces),
          edges_(finer.edges) {}

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
    static const VertexMasks& masks() {
        static const VertexMasks masks(CatmullClark::vertex_mask);
        return masks;
    }

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
        const Vec3d ends = points_[level_.origin[h]] + points_[level_.origin[t == none ? level_.next(h) : t]];
        if (linear_ || t == none) return 0.5 * ends;
        const double crease = level_.has_tags() ? crease_weight(level_, method_, e, scratch) : 0;
        if (crease == 1) return 0.5 * ends;
        const Vec3d smooth = CatmullClark::edge_end * ends +
                             CatmullClark::edge_face_point * (faces_[level_.face_of(h)] + faces_[level_.face_of(t)]);
        return crease == 0 ? smooth : crease * 0.5 * ends + (1 - crease) * smooth;
    }

    Vec3d vertex_point(std::uint32_t v, LevelRing& scratch) const {
        const std::uint32_t start = level_.vertex_halfedge[v];
        if (linear_ || start == none) return points_[v];
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
        const RingMask m = masks_(n);
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
            const RingMask m = masks_(static_cast<std::uint32_t>(around.neighbours.size()));
            point += blend.smooth * (m.vertex * points_[v] + m.edge * edges + m.face * corners);
        }
        return point;
    }

    const MeshLevel& level_;
    CreaseMethod method_;
    bool linear_;
    std::span<const Vec3d> points_;
    std::span<Vec3d> old_, faces_, edges_;
    const VertexMasks& masks_ = masks();
};

}  // namespace

void refine_points(const MeshLevel& level, CreaseMethod method, PointRule rule, std::span<const Vec3d> points,
                   const QuadPoints& finer) {
    PointRefiner(level, method, rule, points, finer).run();
}

}  // namespace tetrakis::detail
