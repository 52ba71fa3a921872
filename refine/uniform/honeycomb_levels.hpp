#pragma once

#include "../../hier/base/run_context.hpp"
#include "../../hier/base/vec.hpp"
#include "../../hier/mesh/control_mesh.hpp"
#include "../rules/rule_levels.hpp"
#include "hexagon_fans.hpp"
#include "hexagon_mesh.hpp"
#include "honeycomb_charts.hpp"
#include "repeated_rows.hpp"

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

namespace tetrakis::detail {

/// Honeycomb refinement from level to level by arithmetic (HexagonMesh). Limits: of smooth vertices by their masks on
/// the level, or beside other faces than hexagons on the next but one, of which that part is made; of vertices on
/// creases and boundaries by theirs; of what is sharp for some levels as the rules find them.
class HoneycombLevels {
  public:
    /// @param start   control mesh, levels 0: with what smoothing has been asked for
    /// @param levels  >= 1
    /// @throws Error  unsupported: more than can be counted, a vertex without limit; memory_limit; before any level is
    ///                made
    HoneycombLevels(const ControlMesh& mesh, std::unique_ptr<RuleLevels> start, const SchemeInfo& scheme, int levels,
                    const RuleOptions& rules, const RepeatedRows::Demand& demand, const RunContext& context);
    HoneycombLevels(const HoneycombLevels&) = delete;
    HoneycombLevels& operator=(const HoneycombLevels&) = delete;

    std::uint32_t point_count() const { return levels_.back().vertex_count(); }
    /// The last level's. Without limits or normals they are given away.
    RootNet::Faces faces();
    /// The texture coordinates of the mesh at the last level, where it has some: once, before its faces.
    FollowedUvs take_uvs() { return follow_hexagons(std::move(*charts_), levels_); }

    /// As RepeatedRows::refine().
    void refine(std::span<const Vec3d> control, std::span<Vec3d> points, std::span<Vec3d> normals,
                const RunContext& context) const;

  private:
    void find_limits(const SchemeInfo& scheme, const RuleOptions& rules);
    void write_limits(const Vec3d* net, std::span<Vec3d> points) const;

    std::unique_ptr<RuleLevels> start_;
    std::vector<HexagonMesh> levels_;
    std::optional<SeamExtension> charts_;
    bool limit_ = false;
    std::optional<HexagonFans> fans_;  ///< of the last level, where it has limits or normals
    std::vector<int> by_rules_;        ///< vertices whose limits the rules have found
    StencilTable rows_;                ///< theirs
};

}  // namespace tetrakis::detail
