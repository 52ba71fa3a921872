#pragma once

#include "tetrakis/hier/control_mesh.hpp"
#include "tetrakis/hier/run_context.hpp"
#include "tetrakis/hier/vec.hpp"
#include "tetrakis/refine/hexagon_fans.hpp"
#include "tetrakis/refine/hexagon_mesh.hpp"
#include "tetrakis/refine/honeycomb_charts.hpp"
#include "tetrakis/refine/repeated_rows.hpp"
#include "tetrakis/refine/rule_levels.hpp"

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
    /// Null where the rules have no limit for a vertex: they say which.
    /// @param start   control mesh, levels 0: with what smoothing has been asked for; taken unless null is returned
    /// @param levels  >= 1
    /// @throws Error  unsupported: more than can be counted; memory_limit
    static std::unique_ptr<HoneycombLevels> make(const ControlMesh& mesh, std::unique_ptr<RuleLevels>& start,
                                                 const SchemeInfo& scheme, int levels, const RuleOptions& rules,
                                                 const RepeatedRows::Demand& demand, const RunContext& context);

    std::uint32_t point_count() const { return levels_.back().vertex_count(); }
    /// The last level's. Without limits or normals they are given away.
    RootNet::Faces faces();
    /// The texture coordinates of the mesh at the last level, where it has some.
    FollowedUvs uvs(const ControlMesh& mesh, const SchemeInfo& scheme, const RuleOptions& rules) const {
        return follow_hexagons(mesh, scheme, rules, levels_);
    }

    /// As RepeatedRows::refine().
    void refine(std::span<const Vec3d> control, std::span<Vec3d> points, std::span<Vec3d> normals,
                const RunContext& context) const;

  private:
    HoneycombLevels() = default;
    void find_limits(const SchemeInfo& scheme, const RuleOptions& rules);
    void write_limits(const Vec3d* net, std::span<Vec3d> points) const;

    std::unique_ptr<RuleLevels> start_;
    std::vector<HexagonMesh> levels_;
    bool limit_ = false;
    std::optional<HexagonFans> fans_;  ///< of the last level, where it has limits or normals
    // Limits of vertices that are not plain.
    std::vector<std::uint32_t> beside_;     ///< those beside other faces than hexagons
    std::vector<HexagonMesh> parts_;        ///< what is around them, and two levels of that
    std::vector<int> of_part_, in_part_;    ///< the part's vertices in the level; those beside in the part
    std::optional<HexagonFans> part_fans_;  ///< of its last level
    std::vector<int> by_rules_;             ///< the others
    StencilTable rows_;
};

}  // namespace tetrakis::detail
