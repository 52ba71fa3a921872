#include "limit_surface.hpp"

#include "../../hier/base/parallel.hpp"
#include "loop_patches.hpp"
#include "quad_patches.hpp"

#include <optional>

namespace tetrakis {

namespace {

constexpr std::uint32_t k_grain = 256;

}  // namespace

struct LimitSurface::Patches {
    std::optional<QuadPatches> quads;
    std::optional<LoopPatches> triangles;

    template <class Use>
    auto with(Use&& use) const {
        return triangles ? use(*triangles) : use(*quads);
    }
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
    return patches_->with([&](const auto& patches) { return patches.evaluate(root, x, y); });
}

SurfacePoint LimitSurface::vertex(const Site& site) const {
    return patches_->with([&](const auto& patches) { return patches.vertex(site.root, site.at, site.level); });
}

void LimitSurface::positions(std::span<const Site> sites, std::span<Vec3d> out) const {
    patches_->with([&](const auto& patches) {
        for_each_block(static_cast<std::uint32_t>(sites.size()), k_grain, [&](std::uint32_t begin, std::uint32_t end) {
            patches.limits(sites.subspan(begin, end - begin), out.subspan(begin, end - begin));
        });
    });
}

std::uint64_t LimitSurface::memory_bytes() const {
    return patches_->with([](const auto& patches) { return patches.memory_bytes(); });
}

}  // namespace tetrakis
