#pragma once

#include "../../hier/base/run_context.hpp"
#include "../../hier/base/vec.hpp"
#include "../lattices/root_lattices.hpp"
#include "../rules/rule_refiner.hpp"
#include "row_patterns.hpp"

#include <algorithm>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <vector>

namespace tetrakis::detail {

/// Structured refinement for dual schemes and for schemes whose steps cut faces into lattices (face splits, 4-8, sqrt3
/// in double steps).
///
/// The rules refine the mesh to the first level, or a few levels further if masks are wide or creases lose their
/// sharpness early. On all later levels the points come from stencil rows that repeat from level to level
/// (RowPatterns), and no connectivity is made. The rules give these rows on a template of each kind of corner. While
/// semi-sharp tags run out, steps whose kinds of corners differ have separate rows.
class RepeatedRows {
  public:
    /// Wanted results, and the bytes of memory that they take per point, face and face corner.
    struct Demand {
        bool limit = false, normals = false;
        bool even_if_slower = false;  ///< also for meshes so small that the rules alone would take less time
        bool any_level = false;       ///< rows for single points on levels of any depth; no last level is made
        double most_points = std::numeric_limits<double>::infinity();  ///< of a level by the rules, approximately
        std::uint64_t point_bytes = sizeof(Vec3d), face_bytes = 2 * sizeof(std::uint32_t),
                      corner_bytes = sizeof(std::uint32_t);
    };
    /// Returns null if this gains nothing or is impossible: too few levels; a scheme or mesh whose rows do not repeat
    /// (boundaries that recede, roots glued to themselves); or vertices without a limit mask.
    /// @param levels_by_rules  at level 0; it is taken over, or on null it keeps the levels that were made on the way
    /// @param levels           number of steps from the control mesh to the last level
    /// @throws Error  as RuleRefiner
    static std::unique_ptr<RepeatedRows> make(const ControlMesh& mesh, const SchemeInfo& scheme, int levels,
                                              const RuleOptions& rules, std::unique_ptr<RuleLevels>& levels_by_rules,
                                              const Demand& demand, const RunContext& context);

    std::uint32_t point_count() const { return net_.point_numbers(net_.layout(segments_.back())).count; }
    /// Whether each point is known to be a corner of some face.
    bool uses_all_points() const;
    std::size_t control_count() const { return control_count_; }
    const RootLattices& net() const { return net_; }
    /// The last level that the rules make; and the segments of a root's side on this level or a deeper one.
    int first_level() const { return levels_->level(); }
    std::uint32_t segments(int level) const;
    std::uint32_t factor() const { return patterns_.front().factor(); }  ///< segments of a level / of its predecessor
    /// Points at the places of first_level().
    void first_points(std::span<const Vec3d> control, Vec3d* out) const;
    /// Rows that compute level `level` > first_level() from the level before it.
    const RowPatterns& step_to(int level) const {
        return patterns_[pattern_[std::min(static_cast<std::size_t>(level - first_level()), pattern_.size()) - 1]];
    }
    /// First level on whose points the rows of limits and normals can be used; empty: there is no such level.
    std::optional<int> limit_level() const;
    const RowPatterns& limit() const { return *limit_; }
    bool has_limit() const { return limit_.has_value(); }
    bool has_normals() const { return normals_.has_value(); }
    const RowPatterns& normals() const { return *normals_; }
    /// For each control half-edge, the half-edge of the net's base that gives lattice coordinates in its corner cell
    /// (triangles: in its face): a along it, b away from it. Empty if roots are smaller than these.
    std::span<const std::uint32_t> corner_halfedges() const { return corner_halfedges_; }
    using Faces = RootLattices::Faces;
    Faces faces(const RunContext& context) const { return net_.faces(segments_.back(), context); }

    /// Points of the last level, or their limits if these were demanded. The same bytes for any number of threads.
    /// @param normals  empty, or unit normals as RuleRefiner's
    void refine(std::span<const Vec3d> control, std::span<Vec3d> points, std::span<Vec3d> normals,
                const RunContext& context) const;

  private:
    explicit RepeatedRows(RootLattices net) : net_(std::move(net)) {}

    struct Plan;
    bool learn(const Plan& plan, const SchemeInfo& scheme, const RuleOptions& rules, const Demand& demand,
               const RunContext& context);
    bool fits(std::uint32_t segments) const;
    void at_shared_places(const RootLayout& last, const Vec3d* now, std::span<Vec3d> points, std::span<Vec3d> normals,
                          const RowPatterns::Progress& progress) const;

    RootLattices net_;
    std::vector<std::uint32_t> corner_halfedges_;
    std::size_t control_count_ = 0;
    std::vector<RowPatterns> patterns_;
    std::vector<std::size_t> pattern_;  ///< index into `patterns_` of each step after first_level()
    std::optional<RowPatterns> limit_, normals_;
    int settled_level_ = 0;  ///< from this level on all steps have the same rows; INT_MAX: not within `levels`
    std::unique_ptr<RuleLevels> levels_;
    std::vector<std::uint32_t> segments_;  ///< segments of a root's side on first_level() and each later level
    std::vector<int> vertices_;            ///< vertex of levels_->last() at each place of first_level()
};

}  // namespace tetrakis::detail
