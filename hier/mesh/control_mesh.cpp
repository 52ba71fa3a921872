#include "control_mesh.hpp"

#include "../base/error.hpp"
#include "../base/parallel.hpp"
#include "corner_tags.hpp"
#include "mesh_check.hpp"
#include "mesh_links.hpp"
#include "mesh_numbering.hpp"

#include <algorithm>
#include <string>

namespace tetrakis {

namespace {

// Bytes per half-edge while building: face, twin, edge and edge's half-edge (4 each), sorted uses twice (12 each).
constexpr std::uint64_t k_bytes_per_halfedge = 16 + 24;
// Half-edges per block of the edge numbering; fixed, so that blocks do not depend on the thread count.
constexpr std::uint32_t k_edge_block = 65536;

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
        detail::throw_faults(data, detail::element_faults(data));
        context_.report("build", 0.2);
        uses_ = detail::sorted_edge_uses(data.face_offsets, data.face_vertices, mesh_.vertex_count());
        context_.report("build", 0.5);
        detail::MeshLinks links = detail::link_mesh(data, uses_);
        detail::throw_faults(data, detail::edge_faults(data, uses_, links));
        detail::throw_faults(data, detail::vertex_faults(data, links));
        detail::TaggedAngles angles = detail::tagged_angles(data, links);
        detail::throw_faults(data, angles.faults);
        mesh_.corner_angle_ = std::move(angles.angle);
        context_.report("build", 0.7);
        mesh_.halfedge_face_ = std::move(links.face);
        mesh_.twin_ = std::move(links.twin);
        mesh_.vertex_halfedge_ = std::move(links.vertex_halfedge);
        mesh_.vertex_face_count_ = std::move(links.vertex_face_count);
        number_edges();
        apply_tags();
        apply_boundary_rule();
        note_oddities(angles);
        context_.report("build", 1.0);
        return std::move(mesh_);
    }

  private:
    void check_memory() const {
        const std::uint64_t bytes =
            mesh_.data_.face_vertices.size() * k_bytes_per_halfedge + mesh_.data_.positions.size() * 12;
        if (context_.max_memory_bytes != 0 && bytes > context_.max_memory_bytes)
            throw Error(ErrorCode::memory_limit, "building the control mesh needs " + std::to_string(bytes) +
                                                     " bytes, the limit is " +
                                                     std::to_string(context_.max_memory_bytes) + "; raise the limit");
    }

    // An edge is numbered by its lower half-edge, in half-edge order.
    void number_edges() {
        const std::uint32_t count = mesh_.halfedge_count();
        const std::uint32_t blocks = count == 0 ? 0 : (count - 1) / k_edge_block + 1;
        const auto leads = [&](std::uint32_t h) { return mesh_.twin_[h] > h; };  // as at the boundary
        std::vector<std::uint32_t> first(std::size_t{blocks} + 1, 0);
        const auto visit = [&](std::uint32_t block, auto&& body) {
            const std::uint32_t end = std::min(count, (block + 1) * k_edge_block);
            for (std::uint32_t h = block * k_edge_block; h < end; ++h) body(h);
        };
        for_each_index(
            blocks, [&](std::uint32_t b) { visit(b, [&](std::uint32_t h) { first[b + 1] += leads(h); }); }, 1);
        for (std::uint32_t b = 0; b < blocks; ++b) first[b + 1] += first[b];
        mesh_.edge_halfedge_.resize(first[blocks]);
        mesh_.halfedge_edge_.resize(count);
        for_each_index(
            blocks,
            [&](std::uint32_t b) {
                // What a follower would write goes nowhere: cheaper than a branch that nothing predicts.
                std::uint32_t e = first[b], unused = 0;
                visit(b, [&](std::uint32_t h) {
                    const std::uint32_t twin = mesh_.twin_[h];
                    const bool lead = leads(h);
                    *(lead ? mesh_.edge_halfedge_.data() + e : &unused) = h;
                    *(lead ? &mesh_.halfedge_edge_[h] : &unused) = e;
                    *(lead && twin != HalfedgeId::none ? &mesh_.halfedge_edge_[twin] : &unused) = e;
                    e += lead;
                });
            },
            1);
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

    void note_oddities(const detail::TaggedAngles& angles) {
        const ControlMeshData& data = mesh_.data_;
        mesh_.all_triangles_ = mesh_.halfedge_count() == 3 * std::uint64_t{mesh_.face_count()} &&
                               std::ranges::adjacent_find(data.face_offsets, [](std::uint32_t a, std::uint32_t b) {
                                   return b - a != 3;
                               }) == data.face_offsets.end();
        mesh_.warnings_ = data.warnings;
        const auto isolated = std::ranges::count(mesh_.vertex_halfedge_, HalfedgeId::none);
        for (std::string& oddity : detail::find_oddities(data, static_cast<std::uint64_t>(isolated)))
            mesh_.warnings_.push_back(std::move(oddity));
        if (const auto oddity = detail::unwelded_edges(data, mesh_.twin_)) mesh_.warnings_.push_back(*oddity);
        if (const auto oddity = detail::idle_angles(data, angles)) mesh_.warnings_.push_back(*oddity);
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
