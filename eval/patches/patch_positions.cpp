#include "patch_positions.hpp"

#include "../../hier/base/parallel.hpp"

namespace tetrakis {

namespace {

constexpr std::uint32_t k_grain = 256;

template <class Visit>
void with_patches(const std::variant<std::monostate, QuadPatches, LoopPatches>& patches, Visit&& visit) {
    if (const auto* quads = std::get_if<QuadPatches>(&patches)) visit(*quads);
    if (const auto* triangles = std::get_if<LoopPatches>(&patches)) visit(*triangles);
}

}  // namespace

PatchPositions::PatchPositions(const ControlMesh& mesh, SchemeKind scheme, const RunContext& context) {
    if (scheme == SchemeKind::loop)
        patches_.emplace<LoopPatches>(mesh, context);
    else
        patches_.emplace<QuadPatches>(mesh, context);
}

void PatchPositions::positions(std::span<const Site> sites, std::span<Vec3d> out) const {
    with_patches(patches_, [&](const auto& patches) {
        for_each_block(static_cast<std::uint32_t>(sites.size()), k_grain, [&](std::uint32_t begin, std::uint32_t end) {
            patches.limits(sites.subspan(begin, end - begin), out.subspan(begin, end - begin));
        });
    });
}

std::uint64_t PatchPositions::memory_bytes() const {
    std::uint64_t bytes = 0;
    with_patches(patches_, [&](const auto& patches) { bytes = patches.memory_bytes(); });
    return bytes;
}

}  // namespace tetrakis
