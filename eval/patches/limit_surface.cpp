#include "limit_surface.hpp"

#include "../../hier/base/error.hpp"
#include "../../hier/base/parallel.hpp"
#include "loop_patches.hpp"
#include "quad_patches.hpp"

#include <algorithm>
#include <optional>

namespace tetrakis {

namespace {

constexpr std::uint32_t k_grain = 256;

[[noreturn]] void refuse(const char* what) { throw Error(ErrorCode::invalid_input, what); }

void require_root(const ControlMesh& mesh, HalfedgeId root, bool triangles) {
    if (root.value >= mesh.halfedge_count()) refuse("the mesh has no such half-edge");
    if (triangles && mesh.face_halfedge(mesh.face(root)) != root)
        refuse("a point of Loop's surface is named by the first half-edge of its triangle");
}

void require_site(const ControlMesh& mesh, const Site& site, bool triangles) {
    require_root(mesh, site.root, triangles);
    if (site.level > k_max_level) refuse("the level of a point is above k_max_level");
    const std::uint64_t x = site.at.x, y = site.at.y, side = std::uint64_t{1} << site.level;
    if (triangles ? x + y > side : std::max(x, y) > side) refuse("a point is outside of its root's lattice");
}

}  // namespace

struct LimitSurface::Patches {
    std::optional<QuadPatches> quads;
    std::optional<LoopPatches> triangles;

    template <class Use>
    auto with(Use&& use) const {
        return triangles ? use(*triangles) : use(*quads);
    }
    const ControlMesh& mesh() const { return triangles ? triangles->mesh() : quads->mesh(); }
};

LimitSurface::LimitSurface(const ControlMesh& mesh, SchemeKind scheme, const RunContext& context)
    : patches_(std::make_unique<Patches>()) {
    if (scheme == SchemeKind::loop)
        patches_->triangles.emplace(mesh, context);
    else
        patches_->quads.emplace(mesh, context);
}

LimitSurface::~LimitSurface() = default;

SurfacePoint LimitSurface::evaluate(HalfedgeId root, double x, double y) const {
    const bool triangles = patches_->triangles.has_value();
    require_root(patches_->mesh(), root, triangles);
    if (!(x >= 0 && y >= 0 && (triangles ? x + y <= 1 : x <= 1 && y <= 1)))
        refuse("the parameters of a point are outside of its root: see LimitSurface::evaluate()");
    return patches_->with([&](const auto& patches) { return patches.evaluate(root, x, y); });
}

SurfacePoint LimitSurface::vertex(const Site& site) const {
    require_site(patches_->mesh(), site, patches_->triangles.has_value());
    return patches_->with([&](const auto& patches) { return patches.vertex(site.root, site.at, site.level); });
}

void LimitSurface::positions(std::span<const Site> sites, std::span<Vec3d> out) const {
    if (sites.size() != out.size()) refuse("as many positions as sites are asked for");
    const ControlMesh& mesh = patches_->mesh();
    for (const Site& site : sites) require_site(mesh, site, patches_->triangles.has_value());
    patches_->with([&](const auto& patches) {
        for_each_index(
            static_cast<std::uint32_t>(sites.size()),
            [&](std::uint32_t i) { out[i] = patches.limit(sites[i].root, sites[i].at, sites[i].level); }, k_grain);
    });
}

std::uint64_t LimitSurface::memory_bytes() const {
    return patches_->with([](const auto& patches) { return patches.memory_bytes(); });
}

}  // namespace tetrakis
