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

/// Structured refinement by the rules of any scheme that cuts faces into lattices (face splits, 4-8, sqrt3 by two steps
/// at a time), and of dual schemes.
///
/// Rows of weights are the same all over the lattices but along sharp sides and around special corners, where they
/// repeat themselves from level to level (RowPatterns). What they are the rules say of each kind of corner by itself;
/// where tags turn smooth on the way, steps have rows of their own as long as these differ. On the mesh the rules make
/// the first level, or the first few where masks are wide or tags soon gone; all later ones only read those rows, at
/// places found by arithmetic.
class RepeatedRows {
  public:
    /// What a result is, and takes: points, faces (with where they begin and the control face of each) and their
    /// corners.
    struct Demand {
        bool limit = false, normals = false;
        bool even_if_slower = false;  ///< on meshes so small that the rules would be done before rows are learned
        bool any_level = false;       ///< rows of single points on levels however deep: no last one is made
        double most_points = std::numeric_limits<double>::infinity();  ///< about, that the rules may make on a level
        std::uint64_t point_bytes = sizeof(Vec3d), face_bytes = 2 * sizeof(std::uint32_t),
                      corner_bytes = sizeof(std::uint32_t);
    };
    /// Null where there is nothing to gain or it cannot be done: too few levels; a scheme or mesh (boundaries that
    /// recede, roots glued to themselves) whose rows do not repeat; no limit.
    /// @param levels_by_rules  not advanced yet; taken, or else left with the levels that the attempt has needed
    /// @param levels           from the control mesh to the last
    /// @throws Error  as RuleRefiner
    static std::unique_ptr<RepeatedRows> make(const ControlMesh& mesh, const SchemeInfo& scheme, int levels,
                                              const RuleOptions& rules, std::unique_ptr<RuleLevels>& levels_by_rules,
                                              const Demand& demand, const RunContext& context);

    std::uint32_t point_count() const { return net_.point_numbers(net_.layout(segments_.back())).count; }
    /// Whether all points are known to be corners of faces.
    bool uses_all_points() const;
    std::size_t control_count() const { return control_count_; }
    const RootLattices& net() const { return net_; }
    /// The last level made by the rules; and segments of a root's sides there and further down.
    int first_level() const { return levels_->level(); }
    std::uint32_t segments(int level) const;
    std::uint32_t factor() const { return patterns_.front().factor(); }  ///< of a level's to those of the one above
    /// Points at the places of the first level.
    void first_points(std::span<const Vec3d> control, Vec3d* out) const;
    /// The rows of a level deeper than the first one, of the points of the level above.
    const RowPatterns& step_to(int level) const {
        return patterns_[pattern_[std::min(static_cast<std::size_t>(level - first_level()), pattern_.size()) - 1]];
    }
    /// From this level on limits and normals have rows of its points; empty: they never have.
    std::optional<int> limit_level() const;
    const RowPatterns& limit() const { return *limit_; }
    bool has_limit() const { return limit_.has_value(); }
    bool has_normals() const { return normals_.has_value(); }
    const RowPatterns& normals() const { return *normals_; }
    /// By control half-edge the half-edge of the net's base from which the lattice of its corner cell (triangles: of
    /// its face) is seen: a along it, b away from it. Empty where roots are smaller than that.
    std::span<const std::uint32_t> corner_halfedges() const { return corner_halfedges_; }
    using Faces = RootLattices::Faces;
    Faces faces(const RunContext& context) const { return net_.faces(segments_.back(), context); }

    /// Points of the last level, on the limit surface where the demand was such. The same bytes for any number of
    /// threads.
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
    std::vector<std::size_t> pattern_;  ///< of each step after the levels by rules
    std::optional<RowPatterns> limit_, normals_;
    int settled_level_ = 0;  ///< from there on no rows change any more; none: beyond the last step
    std::unique_ptr<RuleLevels> levels_;
    std::vector<std::uint32_t> segments_;  ///< of the last level by rules, and of those after it
    std::vector<int> vertices_;            ///< the rules' number at each place of that level
};

}  // namespace tetrakis::detail
