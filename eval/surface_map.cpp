#include "tetrakis/eval/surface_map.hpp"

namespace tetrakis {

namespace {

/// The UV layer as a mesh of its own, in the plane z = 0; its faces and half-edges have the numbers of the control
/// mesh's.
ControlMeshData uv_layer(const ControlMesh& mesh) {
    const ControlMeshData& from = mesh.data();
    ControlMeshData data;
    data.positions.reserve(from.uvs.size());
    for (const Vec2d& uv : from.uvs) data.positions.emplace_back(uv.x, uv.y, 0.0);
    data.face_offsets = from.face_offsets;
    data.face_vertices = from.face_uvs;
    data.boundary_rule = from.face_varying_rule == FaceVaryingRule::corners_and_edges ? BoundaryRule::edge_and_corner
                                                                                      : BoundaryRule::edge_only;
    data.crease_method = from.crease_method;
    // Creases of the surface bend its parameters as well: on edges that the layer does not cut.
    for (std::uint32_t e = 0; e < mesh.edge_count(); ++e) {
        const float s = mesh.sharpness(EdgeId(e));
        const HalfedgeId h = mesh.edge_halfedge(EdgeId(e)), t = mesh.twin(h);
        if (s == 0 || !t.valid()) continue;
        const std::uint32_t a = from.face_uvs[h.value], b = from.face_uvs[mesh.next(h).value];
        if (from.face_uvs[t.value] == b && from.face_uvs[mesh.next(t).value] == a) data.creases.push_back({a, b, s});
    }
    for (std::uint32_t h = 0; h < mesh.halfedge_count(); ++h) {
        const VertexId v = mesh.origin(HalfedgeId(h));
        const float s = mesh.sharpness(v);
        if (s > 0 && mesh.vertex_halfedge(v).value == h) data.corners.push_back({from.face_uvs[h], s});
    }
    return data;
}

}  // namespace

template <class Family>
UvSurface<Family>::UvSurface(const ControlMesh& mesh, std::vector<std::string>& warnings) : mesh_(mesh) {
    if (mesh.face_varying_rule() == FaceVaryingRule::linear_all) return;
    try {
        uv_mesh_ = ControlMesh::build(uv_layer(mesh));
        patches_ = std::make_unique<typename Family::Patches>(uv_mesh_);
    } catch (const Error& error) {
        warnings.push_back(std::string("the UV layer is no manifold mesh and is interpolated linearly (") +
                           error.what() + ")");
    }
}

template <class Family>
Vec2d UvSurface<Family>::at(HalfedgeId root, double x, double y) const {
    if (patches_) return Vec2d(patches_->evaluate(root, x, y).position);
    return Family::linear(mesh_, root, x, y, [&](HalfedgeId h) { return mesh_.data().uvs[mesh_.uv_index(h)]; });
}

template <class Family>
Vec2d UvSurface<Family>::at(const Site& address) const {
    if (patches_) {
        const Site site = Family::canonical_site(uv_mesh_, address);
        return Vec2d(patches_->limit(site.root, site.at, site.level));
    }
    const double step = std::ldexp(1.0, -address.level);
    return at(address.root, address.at.x * step, address.at.y * step);
}

template class UvSurface<QuadFamily>;
template class UvSurface<LoopFamily>;

}  // namespace tetrakis
