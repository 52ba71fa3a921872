#include "tetrakis/hier/control_mesh.hpp"

#include "tetrakis/hier/error.hpp"

#include <algorithm>
#include <numeric>
#include <unordered_map>

namespace tetrakis {

class ControlMeshBuilder {
  public:
    explicit ControlMeshBuilder(ControlMeshData data) { mesh_.data_ = std::move(data); }

    ControlMesh run() {
        link_faces();
        link_twins();
        link_vertices();
        apply_tags();
        return std::move(mesh_);
    }

  private:
    void link_faces() {
        const auto& offsets = mesh_.data_.face_offsets;
        mesh_.halfedge_face_.resize(mesh_.halfedge_count());
        mesh_.all_triangles_ = true;
        for (std::uint32_t f = 0; f < mesh_.face_count(); ++f) {
            mesh_.all_triangles_ &= offsets[f + 1] - offsets[f] == 3;
            for (std::uint32_t h = offsets[f]; h < offsets[f + 1]; ++h) mesh_.halfedge_face_[h] = f;
        }
    }

    std::uint64_t edge_key(std::uint32_t h) const {
        const std::uint64_t a = mesh_.origin(HalfedgeId(h)).value, b = mesh_.target(HalfedgeId(h)).value;
        return a < b ? a << 32 | b : b << 32 | a;
    }

    void link_twins() {
        const std::uint32_t count = mesh_.halfedge_count();
        std::vector<std::pair<std::uint64_t, std::uint32_t>> order(count);
        for (std::uint32_t h = 0; h < count; ++h) order[h] = {edge_key(h), h};
        std::sort(order.begin(), order.end());
        mesh_.twin_.assign(count, HalfedgeId::none);
        for (std::uint32_t i = 0; i + 1 < count; ++i)
            if (order[i].first == order[i + 1].first) {
                mesh_.twin_[order[i].second] = order[i + 1].second;
                mesh_.twin_[order[i + 1].second] = order[i].second;
                ++i;
            }
        mesh_.halfedge_edge_.resize(count);
        for (std::uint32_t h = 0; h < count; ++h) {
            const std::uint32_t t = mesh_.twin_[h];
            if (t == HalfedgeId::none || t > h) {
                mesh_.halfedge_edge_[h] = mesh_.edge_count();
                mesh_.edge_halfedge_.push_back(h);
            } else {
                mesh_.halfedge_edge_[h] = mesh_.halfedge_edge_[t];
            }
        }
    }

    void link_vertices() {
        mesh_.vertex_halfedge_.assign(mesh_.vertex_count(), HalfedgeId::none);
        mesh_.vertex_face_count_.assign(mesh_.vertex_count(), 0);
        for (std::uint32_t h = 0; h < mesh_.halfedge_count(); ++h) {
            const std::uint32_t v = mesh_.data_.face_vertices[h];
            ++mesh_.vertex_face_count_[v];
            if (mesh_.vertex_halfedge_[v] == HalfedgeId::none || mesh_.twin_[h] == HalfedgeId::none)
                mesh_.vertex_halfedge_[v] = h;
        }
    }

    static float effective(float sharpness) {
        return sharpness >= k_infinite_sharpness ? k_sharpness_infinity : sharpness;
    }

    void apply_tags() {
        const auto& data = mesh_.data_;
        mesh_.edge_sharpness_.assign(mesh_.edge_count(), 0.0f);
        mesh_.vertex_sharpness_.assign(mesh_.vertex_count(), 0.0f);
        if (!data.creases.empty()) {
            std::unordered_map<std::uint64_t, std::uint32_t> edges;
            edges.reserve(mesh_.edge_count());
            for (std::uint32_t e = 0; e < mesh_.edge_count(); ++e) edges.emplace(edge_key(mesh_.edge_halfedge_[e]), e);
            for (const auto& crease : data.creases) {
                const std::uint64_t a = std::min(crease.a, crease.b), b = std::max(crease.a, crease.b);
                if (auto it = edges.find(a << 32 | b); it != edges.end())
                    mesh_.edge_sharpness_[it->second] = effective(crease.sharpness);
            }
        }
        for (const auto& corner : data.corners) mesh_.vertex_sharpness_[corner.vertex] = effective(corner.sharpness);
        mesh_.hole_.assign(mesh_.face_count(), 0);
        for (std::uint32_t f : data.holes) mesh_.hole_[f] = 1;
        for (std::uint32_t e = 0; e < mesh_.edge_count(); ++e)
            if (mesh_.is_boundary(EdgeId(e))) mesh_.edge_sharpness_[e] = k_sharpness_infinity;
        for (std::uint32_t h = 0; h < mesh_.halfedge_count(); ++h) {
            const VertexId v = mesh_.origin(HalfedgeId(h));
            if (!mesh_.is_boundary(v)) continue;
            if (data.boundary_rule == BoundaryRule::none) mesh_.hole_[mesh_.halfedge_face_[h]] = 1;
            if (data.boundary_rule == BoundaryRule::edge_and_corner && mesh_.face_valence(v) == 1)
                mesh_.vertex_sharpness_[v.value] = k_sharpness_infinity;
        }
    }

    ControlMesh mesh_;
};

ControlMesh ControlMesh::build(ControlMeshData data, const RunContext&) {
    return ControlMeshBuilder(std::move(data)).run();
}

}  // namespace tetrakis
