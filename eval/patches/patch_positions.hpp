#pragma once

#include "../../refine/adaptive/adaptive.hpp"
#include "../../schemes/core/scheme_table.hpp"
#include "loop_patches.hpp"
#include "quad_patches.hpp"

#include <cstdint>
#include <span>
#include <variant>

namespace tetrakis {

/// Limit positions of Catmull-Clark and Loop by a patch tree over the control mesh: for HierarchyOptions::
/// limit_positions, where they take half the time of those by the scheme's rules and equal them to rounding error.
/// Plain rules only; a hierarchy with other RuleOptions has other limits. Keeps a reference to the mesh.
///
/// Cost: building it as QuadPatches or LoopPatches; then about one patch a site, parallel.
class PatchPositions final : public PositionSource {
  public:
    /// @throws Error  invalid_input: Loop, and a face is not a triangle; memory_limit
    PatchPositions(const ControlMesh& mesh, SchemeKind scheme, const RunContext& context = {});
    PatchPositions(const ControlMesh&&, SchemeKind, const RunContext& = {}) = delete;

    /// @param sites  of corner cells (Catmull-Clark) or face triangles (Loop), of levels up to k_max_level
    void positions(std::span<const Site> sites, std::span<Vec3d> out) const override;

    /// Bytes of the trees, which grow with the sites asked for.
    std::uint64_t memory_bytes() const;

  private:
    std::variant<std::monostate, QuadPatches, LoopPatches> patches_;
};

}  // namespace tetrakis
