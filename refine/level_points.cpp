#include "tetrakis/refine/level_points.hpp"

#include "tetrakis/hier/parallel.hpp"
#include "tetrakis/schemes/catmull_clark.hpp"
#include "tetrakis/schemes/loop.hpp"
#include "tetrakis/schemes/ring_limit.hpp"
#include "tetrakis/schemes/sharpness.hpp"

#include <cmath>

namespace tetrakis::detail {

namespace {

constexpr std::uint32_t none = MeshLevel::none;
// Vertex masks are looked up below this valence.
constexpr std::uint32_t k_masks = 64;

/// Around a tagged vertex, counter-clockwise: edge neighbours, half-edges and sharpness now and one level on.
struct Surroundings {
    std::vector<std::uint32_t> halfedges;  ///< outgoing, one per face
    std::vector<std::uint32_t> neighbours;
    std::vector<float> sharpness, child;
    bool boundary = false;

    void gather(const MeshLevel& level, CreaseMethod method, std::uint32_t v) {
        halfedges.clear();
        neighbours.clear();
        sharpness.clear();
        boundary = false;
        const std::uint32_t start = level.vertex_halfedge[v];
        std::uint32_t h = start;
        do {
            halfedges.push_back(h);
            neighbours.push_back(level.origin[level.next(h)]);
            sharpness.push_back(level.edge_sharpness[level.edge(h)]);
            const std::uint32_t before = level.prev(h);
            h = level.twin[before];
            if (h == none) {
                boundary = true;
                neighbours.push_back(level.origin[before]);
                sharpness.push_back(level.edge_sharpness[level.edge(before)]);
            }
        } while (h != start && h != none);
        child.resize(sharpness.size());
        for (std::size_t i = 0; i < child.size(); ++i)
            child[i] = method == CreaseMethod::uniform ? child_sharpness(sharpness[i])
                                                       : child_sharpness_chaikin(sharpness[i], sharpness);
    }
};

/// Sharpness of the half of edge e at the end that half-edge h of it starts from, one level on.
float child_at(const MeshLevel& level, CreaseMethod method, std::uint32_t h, Surroundings& scratch) {
    const float s = level.edge_sharpness[level.edge(h)];
    if (method == CreaseMethod::uniform || !is_semi_sharp(s)) return child_sharpness(s);
    scratch.gather(level, method, level.origin[h]);
    return child_sharpness_chaikin(s, scratch.sharpness);
}

double crease_weight(const MeshLevel& level, CreaseMethod method, std::uint32_t e, Surroundings& scratch) {
    const float s = level.edge_sharpness[e];
    if (!is_semi_sharp(s)) return is_sharp(s) ? 1 : 0;
    if (method == CreaseMethod::uniform) return edge_crease_weight(s, child_sharpness(s), child_sharpness(s));
    // At the far end the edge is seen from the vertex itself: any half-edge that starts there knows its ring.
    const std::uint32_t h = level.edge_halfedge[e];
    const float near = child_at(level, method, h, scratch);
    scratch.gather(level, method, level.origin[level.next(h)]);
    return edge_crease_weight(s, near, child_sharpness_chaikin(s, scratch.sharpness));
}

class PointRefiner {
  public:
    PointRefiner(const MeshLevel& level, SchemeKind scheme, CreaseMethod method, PointRule rule,
                 std::span<const Vec3d> points, std::span<Vec3d> finer)
        : level_(level),
          quads_(scheme == SchemeKind::catmull_clark),
          method_(method),
          linear_(rule == PointRule::linear),
          points_(points),
          old_(finer.subspan(0, level.vertex_count)),
          faces_(finer.subspan(level.vertex_count, quads_ ? level.face_count : 0)),
          edges_(finer.subspan(level.vertex_count + faces_.size(), level.edge_count)) {
        for (std::uint32_t n = 1; n < k_masks; ++n) masks_[n] = mask(n);
    }

    void run() {
        if (quads_) for_each_index(level_.face_count, [&](std::uint32_t f) { faces_[f] = face_point(f); });
        for_each_block(level_.edge_count, k_default_grain, [&](std::uint32_t begin, std::uint32_t end) {
            Surroundings scratch;
            for (std::uint32_t e = begin; e < end; ++e) edges_[e] = edge_point(e, scratch);
        });
        for_each_block(level_.vertex_count, k_default_grain, [&](std::uint32_t begin, std::uint32_t end) {
            Surroundings scratch;
            for (std::uint32_t v = begin; v < end; ++v) old_[v] = vertex_point(v, scratch);
        });
    }

  private:
    RingMask mask(std::uint32_t n) const {
        return quads_ ? CatmullClark::vertex_mask(static_cast<int>(n)) : Loop::vertex_mask(static_cast<int>(n));
    }

    Vec3d face_point(std::uint32_t f) const {
        const std::uint32_t begin = level_.first_halfedge(f), size = level_.size_of(f);
        const std::uint32_t* v = &level_.origin[begin];
        if (size == 4) return 0.25 * ((points_[v[0]] + points_[v[1]]) + (points_[v[2]] + points_[v[3]]));
        Vec3d sum(0);
        for (std::uint32_t i = 0; i < size; ++i) sum += points_[v[i]];
        return sum / static_cast<double>(size);
    }

    Vec3d edge_point(std::uint32_t e, Surroundings& scratch) const {
        const std::uint32_t h = level_.edge_halfedge[e], t = level_.twin[h];
        const Vec3d ends = points_[level_.origin[h]] + points_[level_.origin[level_.next(h)]];
        if (linear_ || t == none) return 0.5 * ends;
        const double crease = level_.has_tags() ? crease_weight(level_, method_, e, scratch) : 0;
        if (crease == 1) return 0.5 * ends;
        const Vec3d smooth =
            quads_ ? CatmullClark::edge_end * ends +
                         CatmullClark::edge_face_point * (faces_[level_.face_of(h)] + faces_[level_.face_of(t)])
                   : Loop::edge_end * ends + Loop::edge_opposite * (points_[level_.origin[level_.prev(h)]] +
                                                                    points_[level_.origin[level_.prev(t)]]);
        return crease == 0 ? smooth : crease * 0.5 * ends + (1 - crease) * smooth;
    }

    Vec3d vertex_point(std::uint32_t v, Surroundings& scratch) const {
        const std::uint32_t start = level_.vertex_halfedge[v];
        if (linear_ || start == none) return points_[v];
        if (level_.has_tags() && level_.tagged[v] != 0) return tagged_point(v, scratch);
        Vec3d edges(0), corners(0);
        std::uint32_t n = 0, h = start;
        do {
            edges += points_[level_.origin[level_.next(h)]];
            if (quads_) corners += faces_[level_.face_of(h)];
            ++n;
            h = level_.twin[level_.prev(h)];
        } while (h != start);
        const RingMask m = n < k_masks ? masks_[n] : mask(n);
        return m.vertex * points_[v] + m.edge * edges + m.face * corners;
    }

    Vec3d tagged_point(std::uint32_t v, Surroundings& around) const {
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
            for (const std::uint32_t h : around.halfedges)
                if (quads_) corners += faces_[level_.face_of(h)];
            const RingMask m = mask(static_cast<std::uint32_t>(around.neighbours.size()));
            point += blend.smooth * (m.vertex * points_[v] + m.edge * edges + m.face * corners);
        }
        return point;
    }

    const MeshLevel& level_;
    bool quads_;
    CreaseMethod method_;
    bool linear_;
    std::span<const Vec3d> points_;
    std::span<Vec3d> old_, faces_, edges_;
    RingMask masks_[k_masks];
};

}  // namespace

void refine_points(const MeshLevel& level, SchemeKind scheme, CreaseMethod method, PointRule rule,
                   std::span<const Vec3d> points, std::span<Vec3d> finer) {
    PointRefiner(level, scheme, method, rule, points, finer).run();
}

void gather_ring(const MeshLevel& level, SchemeKind scheme, CreaseMethod method, std::span<const Vec3d> points,
                 std::uint32_t v, VertexRing& ring) {
    ring.clear();
    ring.faces = 0;
    ring.boundary = false;
    ring.points.push_back(points[v]);
    const bool tags = level.has_tags() && level.tagged[v] != 0, quads = scheme == SchemeKind::catmull_clark;
    const std::uint32_t start = level.vertex_halfedge[v];
    std::uint32_t h = start;
    do {
        const std::uint32_t next = level.next(h), before = level.prev(h);
        ring.points.push_back(points[level.origin[next]]);
        if (quads) ring.points.push_back(points[level.origin[level.next(next)]]);
        if (tags) ring.sharpness.push_back(level.edge_sharpness[level.edge(h)]);
        ++ring.faces;
        h = level.twin[before];
        if (h == none) {
            ring.boundary = true;
            ring.points.push_back(points[level.origin[before]]);
            ring.sharpness.push_back(level.edge_sharpness[level.edge(before)]);
        }
    } while (h != start && h != none);
    if (!tags) return;
    ring.vertex_sharpness = level.vertex_sharpness[v];
    if (method == CreaseMethod::uniform) return;
    Surroundings scratch;
    const auto outer_child = [&](std::uint32_t far_end, std::uint32_t edge) {
        const float s = level.edge_sharpness[edge];
        if (!is_semi_sharp(s)) return s;
        scratch.gather(level, method, far_end);
        return child_sharpness_chaikin(s, scratch.sharpness);
    };
    h = start;
    do {
        ring.outer_child.push_back(outer_child(level.origin[level.next(h)], level.edge(h)));
        const std::uint32_t before = level.prev(h);
        h = level.twin[before];
        if (h == none) ring.outer_child.push_back(outer_child(level.origin[before], level.edge(before)));
    } while (h != start && h != none);
}

bool smooth_limit(const MeshLevel& level, SchemeKind scheme, std::span<const Vec3d> points, std::uint32_t v,
                  Vec3d& position, Vec3d* normal) {
    // Tangents that are parallel but for rounding are left to the general way, which then looks at the faces.
    constexpr double k_parallel = 1e-10;
    const std::uint32_t start = level.vertex_halfedge[v];
    if (start == none || (level.has_tags() && level.tagged[v] != 0)) return false;
    const bool quads = scheme == SchemeKind::catmull_clark;
    const Vec3d centre = points[v];
    // Valence is known only after the walk, so the ring is kept up to a size that covers nearly every vertex.
    constexpr std::uint32_t k_most = 16;
    Vec3d ring[2 * k_most];
    Vec3d edges(0), corners(0);
    std::uint32_t n = 0, count = 0, h = start;
    do {
        if (n == k_most) return false;
        const std::uint32_t next = level.next(h);
        edges += ring[count++] = points[level.origin[next]] - centre;
        if (quads) corners += ring[count++] = points[level.origin[level.next(next)]] - centre;
        ++n;
        h = level.twin[level.prev(h)];
    } while (h != start);
    const RingLimit& limit = smooth_ring_limit(scheme, static_cast<int>(n));
    if (!limit.has_tangent_plane) return false;
    position = centre + limit.position[1] * edges;
    if (quads) position += limit.position[2] * corners;
    if (normal == nullptr) return true;
    Vec3d a(0), b(0);
    for (std::uint32_t i = 0; i < count; ++i) {
        a += limit.tangent1[i + 1] * ring[i];
        b += limit.tangent2[i + 1] * ring[i];
    }
    const Vec3d cross = glm::cross(a, b);
    const double square = glm::dot(cross, cross);
    if (!(square > k_parallel * k_parallel * glm::dot(a, a) * glm::dot(b, b))) return false;
    *normal = cross / std::sqrt(square);
    return true;
}

}  // namespace tetrakis::detail
