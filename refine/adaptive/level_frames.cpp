#include "level_frames.hpp"

#include "../../hier/base/parallel.hpp"
#include "../uniform/site_stencils.hpp"

#include <cstdint>
#include <vector>

namespace tetrakis::detail {

namespace {

constexpr std::uint32_t k_block = 2048;  // sites whose rings are evaluated together

/// The site that a key of a ring names. Sources of positions know sites of triangles in the frame of the face's first
/// half-edge alone, keys are rooted at any of the three.
Site site_of(const ControlMesh& mesh, bool quads, const VertexKey& key, int level) {
    const HalfedgeId h(key.root);
    const auto depth = static_cast<std::uint8_t>(level);
    const HalfedgeId first = mesh.face_halfedge(mesh.face(h));
    if (quads || h == first) return {h, {key.x, key.y}, depth};
    // Weights of the corners: z at origin(h), key.x at its target, key.y at the third.
    const std::uint32_t z = (std::uint32_t{1} << level) - key.x - key.y;
    return {first, h == mesh.next(first) ? LatticePoint{z, key.x} : LatticePoint{key.y, z}, depth};
}

template <class Stencils>
void frames(const ControlMesh& mesh, const Stencils& rings, std::span<const Site> sites, int level,
            const SitePositions& positions, std::span<LimitPoint> out) {
    constexpr bool quads = Stencils::scheme == SchemeKind::catmull_clark;
    for_each_block(static_cast<std::uint32_t>(sites.size()), k_block, [&](std::uint32_t begin, std::uint32_t end) {
        KeyRing ring;
        std::vector<Site> around;
        struct Shape {
            int faces, edges;
        };
        std::vector<Shape> shapes;
        for (std::uint32_t i = begin; i < end; ++i) {
            const int up = level - sites[i].level;
            // A site may be given at a finer lattice than the level's, but its point is a vertex of the level.
            const auto at = [&](std::uint32_t c) { return up >= 0 ? c << up : c >> -up; };
            rings.ring(rings.canonical({sites[i].root.value, at(sites[i].at.x), at(sites[i].at.y)}, level), level,
                       ring);
            for (const VertexKey& k : ring.keys) around.push_back(site_of(mesh, quads, k, level));
            shapes.push_back({ring.faces, ring.faces + (ring.boundary ? 1 : 0)});
        }
        std::vector<Vec3d> points(around.size());
        positions(around, points);
        const Vec3d* p = points.data();
        for (std::uint32_t i = begin; i < end; ++i) {
            // The centre, then the edge neighbours, for quads with the far corner of each face between.
            const auto [face_count, edge_count] = shapes[i - begin];
            const auto edge = [&](int k) -> const Vec3d& { return p[1 + (quads ? 2 : 1) * (k % edge_count)]; };
            Vec3d normal(0);
            for (int f = 0; f < face_count; ++f)
                normal += quads ? glm::cross(p[2 + 2 * f] - p[0], edge(f + 1) - edge(f))
                                : glm::cross(edge(f) - p[0], edge(f + 1) - p[0]);
            out[i] = frame_from(p[0], normal, p[1] - p[0]);
            p += 1 + edge_count + (quads ? face_count : 0);
        }
    });
}

}  // namespace

LimitPoint frame_from(const Vec3d& position, const Vec3d& area_normal, const Vec3d& towards) {
    LimitPoint result;
    result.position = position;
    const double length = glm::length(area_normal);
    if (!(length > 0)) return result;
    result.normal = area_normal / length;
    result.tangent1 = towards - glm::dot(towards, result.normal) * result.normal;
    result.tangent2 = glm::cross(result.normal, result.tangent1);
    result.has_tangent_plane = true;
    return result;
}

void lattice_frames(const ControlMesh& mesh, const QuadStencils& rings, std::span<const Site> sites, int lattice_level,
                    const SitePositions& positions, std::span<LimitPoint> out) {
    frames(mesh, rings, sites, lattice_level, positions, out);
}

void lattice_frames(const ControlMesh& mesh, const TriangleStencils& rings, std::span<const Site> sites,
                    int lattice_level, const SitePositions& positions, std::span<LimitPoint> out) {
    frames(mesh, rings, sites, lattice_level, positions, out);
}

LimitPoint control_frame(const ControlMesh& mesh, VertexId v) {
    Vec3d normal(0);
    const HalfedgeId start = mesh.vertex_halfedge(v);
    const Vec3d centre = mesh.position(v);
    HalfedgeId h = start;
    do {
        // Twice the vector area of the face, by its triangles around this corner.
        for (HalfedgeId k = mesh.next(h); mesh.target(k) != v; k = mesh.next(k))
            normal += glm::cross(mesh.position(mesh.origin(k)) - centre, mesh.position(mesh.target(k)) - centre);
        h = mesh.ccw_outgoing(h);
    } while (h.valid() && h != start);
    return frame_from(centre, normal, mesh.position(mesh.target(start)) - centre);
}

}  // namespace tetrakis::detail
