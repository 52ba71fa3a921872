#include "control_mesh.hpp"

#include "../base/memory.hpp"
#include "../base/parallel.hpp"
#include "corner_tags.hpp"
#include "mesh_check.hpp"
#include "mesh_links.hpp"

#include <algorithm>
#include <string>

namespace tetrakis {

namespace {

// Bytes per half-edge during building: face, twin, edge and edge's half-edge (4 each), sorted uses twice (12 each).
constexpr std::uint64_t k_bytes_per_halfedge = 16 + 24;
float effective(float sharpness) { return sharpness >= k_infinite_sharpness ? k_sharpness_infinity : sharpness; }

}  // namespace

class ControlMeshBuilder {
  public:
    static ControlMesh build(ControlMeshData given, const RunContext& context) {
        ControlMesh mesh;
        mesh.data_ = std::move(given);
        const ControlMeshData& data = mesh.data_;
        detail::check_memory("building the control mesh needs",
                             data.face_vertices.size() * k_bytes_per_halfedge + data.positions.size() * 12,
                             context.max_memory_bytes, "raise the limit", data.source);
        context.report("build", 0.0);
        std::vector<detail::EdgeUse> uses;
        detail::MeshLinks links;
        detail::throw_faults(data, detail::find_faults(data, context, uses, links));
        mesh.warnings_ = data.warnings;
        for (std::string& oddity : detail::find_oddities(data, links)) mesh.warnings_.push_back(std::move(oddity));
        context.report("build", 0.7);
        mesh.halfedge_face_ = std::move(links.face);
        mesh.twin_ = std::move(links.twin);
        mesh.vertex_halfedge_ = std::move(links.vertex_halfedge);
        mesh.vertex_face_count_ = std::move(links.vertex_face_count);
        number_edges(mesh);
        apply_tags(mesh, uses);
        apply_boundary_rule(mesh);
        detail::TaggedAngles angles = detail::tagged_angles(mesh, data);
        detail::throw_faults(data, angles.faults);
        if (const auto oddity = detail::idle_angles(data, angles)) mesh.warnings_.push_back(*oddity);
        mesh.corner_angle_ = std::move(angles.angle);
        mesh.all_triangles_ = std::ranges::adjacent_find(data.face_offsets, [](std::uint32_t a, std::uint32_t b) {
                                  return b - a != 3;
                              }) == data.face_offsets.end();
        context.report("build", 1.0);
        return mesh;
    }

  private:
    // An edge is numbered by its lower half-edge, in half-edge order.
    static void number_edges(ControlMesh& mesh) {
        mesh.halfedge_edge_.resize(mesh.halfedge_count());
        mesh.edge_halfedge_.reserve(mesh.halfedge_count() / 2);
        for (std::uint32_t h = 0; h < mesh.halfedge_count(); ++h) {
            const std::uint32_t twin = mesh.twin_[h];
            if (twin > h) mesh.edge_halfedge_.push_back(h);  // also at the boundary
            mesh.halfedge_edge_[h] =
                twin > h ? static_cast<std::uint32_t>(mesh.edge_halfedge_.size() - 1) : mesh.halfedge_edge_[twin];
        }
    }

    static void apply_tags(ControlMesh& mesh, const std::vector<detail::EdgeUse>& uses) {
        const ControlMeshData& data = mesh.data_;
        mesh.edge_sharpness_.assign(mesh.edge_count(), 0.0f);
        mesh.vertex_sharpness_.assign(mesh.vertex_count(), 0.0f);
        mesh.hole_.assign(mesh.face_count(), 0);
        for (const auto& crease : data.creases) {
            const std::uint32_t h = detail::find_edge(uses, crease.a, crease.b)->halfedge;
            mesh.edge_sharpness_[mesh.halfedge_edge_[h]] = effective(crease.sharpness);
        }
        for (const auto& corner : data.corners) mesh.vertex_sharpness_[corner.vertex] = effective(corner.sharpness);
        for (std::uint32_t f : data.holes) mesh.hole_[f] = 1;
    }

    static void apply_boundary_rule(ControlMesh& mesh) {
        const ControlMeshData& data = mesh.data_;
        for_each_index(mesh.edge_count(), [&](std::uint32_t e) {
            if (mesh.is_boundary(EdgeId(e))) mesh.edge_sharpness_[e] = k_sharpness_infinity;
        });
        if (data.boundary_rule == BoundaryRule::edge_and_corner)
            for_each_index(mesh.vertex_count(), [&](std::uint32_t v) {
                if (mesh.is_boundary(VertexId(v)) && mesh.face_valence(VertexId(v)) == 1)
                    mesh.vertex_sharpness_[v] = k_sharpness_infinity;
            });
        if (data.boundary_rule == BoundaryRule::none)
            for_each_index(mesh.face_count(), [&](std::uint32_t f) {
                for (std::uint32_t h = data.face_offsets[f]; h < data.face_offsets[f + 1]; ++h)
                    if (mesh.is_boundary(VertexId(data.face_vertices[h]))) mesh.hole_[f] = 1;
            });
    }
};

bool ControlMesh::has_boundary() const {
    return std::ranges::find(twin_, std::uint32_t{HalfedgeId::none}) != twin_.end();
}

Box3d ControlMesh::bounding_box() const {
    Box3d box;
    for (std::uint32_t v = 0; v < vertex_count(); ++v)
        if (!is_isolated(VertexId(v))) box.add(data_.positions[v]);
    return box;
}

ControlMesh ControlMesh::build(ControlMeshData data, const RunContext& context) {
    return with_threads(context, [&] { return ControlMeshBuilder::build(std::move(data), context); });
}

}  // namespace tetrakis
