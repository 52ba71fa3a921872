#pragma once

#include "tetrakis/hier/control_mesh.hpp"
#include "tetrakis/hier/run_context.hpp"
#include "tetrakis/hier/vec.hpp"
#include "tetrakis/refine/hexagon_mesh.hpp"
#include "tetrakis/refine/repeated_rows.hpp"
#include "tetrakis/refine/rule_levels.hpp"

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace tetrakis::detail {

/// Honeycomb refinement from level to level by arithmetic (HexagonMesh). Limits of vertices among hexagons come from
/// their fans, walked along; the rules say what those of the others are.
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
    RepeatedRows::Faces faces();

    /// As RepeatedRows::refine().
    void refine(std::span<const Vec3d> control, std::span<Vec3d> points, std::span<Vec3d> normals,
                const RunContext& context) const;

  private:
    HoneycombLevels() = default;
    void find_limits(const SchemeInfo& scheme, const RuleOptions& rules);
    template <class Visit>
    bool walk_fan(std::uint32_t v, Visit&& visit) const;
    Vec3d limit_of(std::uint32_t v, const Vec3d* net) const;
    Vec3d normal_of(std::uint32_t v, const Vec3d* net) const;

    std::unique_ptr<RuleLevels> start_;
    std::vector<HexagonMesh> levels_;
    bool limit_ = false, normals_ = false;
    // Of the last level, where it has limits or normals.
    std::vector<std::uint32_t> face_of_;        ///< by half-edge
    std::vector<char> tagged_;                  ///< by vertex
    std::vector<std::vector<double>> weights_;  ///< of the limit, by valence
    std::vector<int> irregular_;                ///< vertices with rows of their own
    StencilTable rows_;                         ///< theirs
};

}  // namespace tetrakis::detail
