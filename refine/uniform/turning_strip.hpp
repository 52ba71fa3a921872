#pragma once

#include "../../hier/base/run_context.hpp"
#include "../../hier/base/vec.hpp"
#include "../rules/rule_levels.hpp"
#include "../rules/rule_limit.hpp"
#include "root_net.hpp"

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace tetrakis::detail {

/// What of a dual scheme's structured levels is otherwise than its net says, because tags that the net is cut along
/// turn smooth on the way: a strip along them, made by the rules from level to level. A crease that is gone leaves no
/// lattice behind that begins at the roots (the points on it were between their cells), but what it changes is near it.
///
/// As long as a tag is sharp, the strip is a few rings of faces wide on every level; from there on what has changed
/// becomes twice as wide from step to step, and the masks' reach more. The rules' own half-edges are followed through
/// the cells of the net, so that the strip's faces find the points beside it.
class TurningStrip {
  public:
    struct Start {
        const RuleLevels& levels;  ///< the last one is the first whose points have places in the net
        const RuleMesh& cut;       ///< that level with all tags sharp for ever that were there when the net was cut
        std::span<const int> halfedge;  ///< of it, as RootNet::vertices()
        int steps;                      ///< to the last level
    };
    struct Demand {
        bool limit = false, normals = false;
        double most_points = 0;       ///< about that many make the strip not worth it; 0: all do
        std::uint64_t max_bytes = 0;  ///< 0: no limit
    };
    /// Nothing where the strip would be too large, or lies otherwise than the net's cells.
    /// @throws std::invalid_argument  as the scheme's step, and rule_limits()
    static std::optional<TurningStrip> make(const RootNet& net, const Start& start, const SchemeInfo& scheme,
                                            const RuleOptions& rules, const Demand& demand, const RunContext& context);

    /// Points of its own, numbered after those of the net.
    std::uint32_t point_count() const { return static_cast<std::uint32_t>(own_.size()); }
    /// The net's faces of the last level without those that are not there, and the strip's.
    void put_into(RootNet::Faces& faces) const;
    /// Its points, and those of the net whose limits or normals see it.
    /// @param start  the points of the level that it starts from
    void refine(std::span<const Vec3d> start, std::span<Vec3d> points, std::span<Vec3d> normals) const;

  private:
    TurningStrip() = default;
    struct Level;
    class Maker;

    std::vector<int> from_;            ///< the points it starts from
    std::vector<StencilTable> steps_;  ///< of the strip's points of each level from those of the one above
    std::uint32_t first_number_ = 0;
    std::vector<int> own_;             ///< of the last level's strip
    std::vector<std::uint32_t> dead_;  ///< numbers of the net's points that are not there; increasing
    RootNet::Faces faces_{{0}, {}, {}};
    // With limits or normals.
    bool limit_ = false, normals_ = false;
    RuleMesh mesh_;                      ///< the last level's strip
    std::vector<int> seen_;              ///< points of it
    std::vector<std::uint32_t> number_;  ///< of those
    RuleLimits limits_;
};

}  // namespace tetrakis::detail
