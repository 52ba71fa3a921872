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

// Bytes per half-edge while building: face, twin, edge and edge's half-edge (4 each), sorted uses twice (12 each).
constexpr std::uint64_t k_bytes_per_halfedge = 16 + 24;
float effective(float sharpness) { return sharpness >= k_infinite_sharpness ? k_sharpness_infinity : sharpness; }

}  // namespace

class ControlMeshBuilder {
  public:
    ControlMeshBuilder(ControlMeshData data, const RunContext& context) : context_(context) {
        mesh_.data_ = std::move(data);
    }

    ControlMesh run() {
        const ControlMeshData& data = mesh_.data_;
        check_memory();
        context_.report("build", 0.0);
        detail::MeshLinks links;
        detail::throw_faults(data, detail::find_faults(data, context_, uses_, links));
        mesh_.warnings_ = data.warnings;
        for (std::string& oddity : detail::find_oddities(data, links)) mesh_.warnings_.push_back(std::move(oddity));
        context_.report("build", 0.7);
        mesh_.halfedge_face_ = std::move(links.face);
        mesh_.twin_ = std::move(links.twin);
        mesh_.vertex_halfedge_ = std::move(links.vertex_halfedge);
        mesh_.vertex_face_count_ = std::move(links.vertex_face_count);
        number_edges();
        apply_tags();
        apply_boundary_rule();
        detail::TaggedAngles angles = detail::tagged_angles(mesh_, data);
        detail::throw_faults(data, angles.faults);
        if (const auto oddity = detail::idle_angles(data, angles)) mesh_.warnings_.push_back(*oddity);
        mesh_.corner_angle_ = std::move(angles.angle);
        mesh_.all_triangles_ = std::ranges::adjacent_find(data.face_offsets, [](std::uint32_t a, std::uint32_t b) {
                                   return b - a != 3;
                               }) == data.face_offsets.end();
        context_.report("build", 1.0);
        return std::move(mesh_);
    }

  private:
    void check_memory() const {
        const std::uint64_t bytes =
            mesh_.data_.face_vertices.size() * k_bytes_per_halfedge + mesh_.data_.positions.size() * 12;
        detail::check_memory("building the control mesh needs", bytes, context_.max_memory_bytes, "raise the limit",
                             mesh_.data_.source);
    }

    // An edge is numbered by its lower half-edge, in half-edge order.
    void number_edges() {
        mesh_.halfedge_edge_.resize(mesh_.halfedge_count());
        mesh_.edge_halfedge_.reserve(mesh_.halfedge_count() / 2);
        for (std::uint32_t h = 0; h < mesh_.halfedge_count(); ++h) {
            const std::uint32_t twin = mesh_.twin_[h];
            if (twin > h) mesh_.edge_halfedge_.push_back(h);  // as at the boundary
            mesh_.halfedge_edge_[h] =
                twin > h ? static_cast<std::uint32_t>(mesh_.edge_halfedge_.size() - 1) : mesh_.halfedge_edge_[twin];
        }
    }

    void apply_tags() {
        const ControlMeshData& data = mesh_.data_;
        mesh_.edge_sharpness_.assign(mesh_.edge_count(), 0.0f);
        mesh_.vertex_sharpness_.assign(mesh_.vertex_count(), 0.0f);
        mesh_.hole_.assign(mesh_.face_count(), 0);
        for (const auto& crease : data.creases) {
            const std::uint32_t h = detail::find_edge(uses_, crease.a, crease.b)->halfedge;
            mesh_.edge_sharpness_[mesh_.halfedge_edge_[h]] = effective(crease.sharpness);
        }
        for (const auto& corner : data.corners) mesh_.vertex_sharpness_[corner.vertex] = effective(corner.sharpness);
        for (std::uint32_t f : data.holes) mesh_.hole_[f] = 1;
    }

    void apply_boundary_rule() {
        const ControlMeshData& data = mesh_.data_;
        for_each_index(mesh_.edge_count(), [&](std::uint32_t e) {
            if (mesh_.is_boundary(EdgeId(e))) mesh_.edge_sharpness_[e] = k_sharpness_infinity;
        });
        if (data.boundary_rule == BoundaryRule::edge_and_corner)
            for_each_index(mesh_.vertex_count(), [&](std::uint32_t v) {
                if (mesh_.is_boundary(VertexId(v)) && mesh_.face_valence(VertexId(v)) == 1)
                    mesh_.vertex_sharpness_[v] = k_sharpness_infinity;
            });
        if (data.boundary_rule == BoundaryRule::none)
            for_each_index(mesh_.face_count(), [&](std::uint32_t f) {
                for (std::uint32_t h = data.face_offsets[f]; h < data.face_offsets[f + 1]; ++h)
                    if (mesh_.is_boundary(VertexId(data.face_vertices[h]))) mesh_.hole_[f] = 1;
            });
    }

    const RunContext& context_;
    ControlMesh mesh_;
    std::vector<detail::EdgeUse> uses_;
};

bool ControlMesh::has_boundary() const {
    for (std::uint32_t e = 0; e < edge_count(); ++e)
        if (is_boundary(EdgeId(e))) return true;
    return false;
}

Box3d ControlMesh::bounding_box() const {
    Box3d box;
    for (std::uint32_t v = 0; v < vertex_count(); ++v)
        if (!is_isolated(VertexId(v))) box.add(data_.positions[v]);
    return box;
}

ControlMesh ControlMesh::build(ControlMeshData data, const RunContext& context) {
    return with_threads(context, [&] { return ControlMeshBuilder(std::move(data), context).run(); });
}

}  // namespace tetrakis
