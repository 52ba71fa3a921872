#include "mesh_statistics.hpp"

#include <numeric>
#include <vector>

namespace tetrakis::cli {
namespace {

/// Each boundary loop is walked once: from a half-edge without a twin to the next one around its target.
std::uint64_t count_boundary_loops(const ControlMesh& mesh) {
    std::vector<bool> seen(mesh.halfedge_count(), false);
    std::uint64_t loops = 0;
    for (std::uint32_t i = 0; i < mesh.halfedge_count(); ++i) {
        HalfedgeId h(i);
        if (seen[i] || mesh.twin(h).valid()) continue;
        ++loops;
        while (!seen[h.value]) {
            seen[h.value] = true;
            h = mesh.vertex_halfedge(mesh.target(h));  // of a boundary vertex: the outgoing one that has no twin
        }
    }
    return loops;
}

std::uint64_t count_pieces(const ControlMesh& mesh) {
    std::vector<std::uint32_t> parent(mesh.face_count());
    std::iota(parent.begin(), parent.end(), 0u);
    const auto root = [&](std::uint32_t f) {
        while (parent[f] != f) f = parent[f] = parent[parent[f]];
        return f;
    };
    std::uint64_t pieces = mesh.face_count();
    for (std::uint32_t i = 0; i < mesh.halfedge_count(); ++i) {
        const HalfedgeId h(i), t = mesh.twin(h);
        if (!t.valid() || t.value < i) continue;
        const std::uint32_t a = root(mesh.face(h).value), b = root(mesh.face(t).value);
        if (a == b) continue;
        parent[b] = a;
        --pieces;
    }
    return pieces;
}

}  // namespace

MeshStatistics statistics(const ControlMesh& mesh) {
    MeshStatistics s;
    for (std::uint32_t f = 0; f < mesh.face_count(); ++f) {
        ++s.faces_by_size[mesh.face_size(FaceId(f))];
        if (mesh.is_hole(FaceId(f))) ++s.holes;
    }
    for (std::uint32_t i = 0; i < mesh.edge_count(); ++i) {
        const EdgeId e(i);
        if (mesh.is_boundary(e))
            ++s.boundary_edges;
        else if (mesh.sharpness(e) == k_sharpness_infinity)
            ++s.sharp_edges;
        else if (mesh.sharpness(e) > 0)
            ++s.semi_sharp_edges;
    }
    for (std::uint32_t i = 0; i < mesh.vertex_count(); ++i) {
        const VertexId v(i);
        if (mesh.is_isolated(v))
            ++s.isolated_vertices;
        else if (!mesh.is_boundary(v))
            ++s.interior_vertices_by_valence[mesh.valence(v)];
    }
    // The tags as given: the boundary rule's own corners are no tags.
    for (const ControlMeshData::VertexTag& tag : mesh.data().corners) {
        if (tag.sharpness >= k_infinite_sharpness)
            ++s.sharp_vertices;
        else if (tag.sharpness > 0)
            ++s.semi_sharp_vertices;
    }
    s.boundary_loops = count_boundary_loops(mesh);
    s.pieces = count_pieces(mesh);
    s.euler_characteristic =
        static_cast<std::int64_t>(mesh.vertex_count() - s.isolated_vertices) - mesh.edge_count() + mesh.face_count();
    return s;
}

}  // namespace tetrakis::cli
