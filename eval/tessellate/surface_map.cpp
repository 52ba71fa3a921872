#include "surface_map.hpp"

#include "../../refine/attributes/uv_mesh.hpp"

namespace tetrakis {

template <class Family>
UvSurface<Family>::UvSurface(const ControlMesh& mesh, std::vector<std::string>& warnings) : mesh_(mesh) {
    if (mesh.face_varying_rule() == FaceVaryingRule::linear_all) return;
    try {
        uv_mesh_ = uv_mesh(mesh);
        patches_ = std::make_unique<typename Family::Patches>(uv_mesh_);
    } catch (const Error& error) {
        warnings.push_back(std::string("the UV layer cannot be subdivided and is interpolated linearly (") +
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
