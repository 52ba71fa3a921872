#pragma once

#include "../../hier/base/parallel.hpp"
#include "../../hier/base/vec.hpp"
#include "../../hier/mesh/control_mesh.hpp"
#include "../../schemes/core/block_runner.hpp"
#include "../../schemes/core/rule_step.hpp"
#include "../../schemes/core/scheme_table.hpp"
#include "refine_options.hpp"
#include "rule_limit.hpp"

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace tetrakis {

namespace detail {

/// Blocks of a step's rows on all threads.
class ParallelBlocks final : public BlockRunner {
  public:
    void run(int count, const std::function<void(int)>& block) const override {
        for_each_index(
            static_cast<std::uint32_t>(count), [&](std::uint32_t i) { block(static_cast<int>(i)); }, 1);
    }
    bool is_parallel() const override { return !one_thread(); }
};

/// Writes every row's combination: row by row, in the order of its terms.
template <class T>
void apply(const StencilTable& table, const T* in, T* out) {
    for_each_index(static_cast<std::uint32_t>(table.row_count()), [&](std::uint32_t r) {
        const auto points = table.points(static_cast<int>(r));
        const auto weights = table.weights(static_cast<int>(r));
        T sum(0);
        for (std::size_t i = 0; i < points.size(); ++i) sum += weights[i] * in[points[i]];
        out[r] = sum;
    });
}

/// The control faces that a dual scheme's points and faces lie in.
struct CornerFaces {
    std::vector<int> control_face;  ///< by face
    /// By half-edge, from level 1 on: of the corner there, on its side of creases; one for all corners at the end of a
    /// crease.
    std::vector<int> point_face;

    /// From a level to the next one.
    void follow(const RuleMesh& level, const RuleStep& step);
};

/// A control mesh refined step by step by the rules of a scheme; what depends on connectivity and tags is kept.
class RuleLevels {
  public:
    /// @param smoothing  rounds before the first step; see RefineOptions
    RuleLevels(const ControlMesh& mesh, const SchemeInfo& scheme, const RuleOptions& rules, int smoothing);
    RuleLevels(const RuleLevels&) = delete;
    RuleLevels& operator=(const RuleLevels&) = delete;

    /// One step more. Returns RuleStep::child_halfedge.
    /// @throws Error  invalid_input: the scheme cannot take the mesh
    std::vector<int> advance();

    int level() const { return level_; }
    const RuleMesh& last() const { return last_; }
    /// The control face that a face lies in. Dual schemes: most of its corners, or the first such face of several.
    int control_face(int face) const { return faces_.control_face[static_cast<std::size_t>(face)]; }
    /// The control faces that the corners at the half-edges' origins come from.
    std::vector<std::uint32_t> control_face_of_corners() const;
    /// The rounds of smoothing and the steps so far, each from one level to the next.
    std::span<const StencilTable> steps() const { return steps_; }
    /// The last level's points from the control mesh's.
    void net(std::span<const Vec3d> control, std::span<Vec3d> out) const;

  private:
    ParallelBlocks runner_;
    const SchemeInfo& scheme_;
    RuleOptions rules_;
    std::string source_;
    int level_ = 0;
    RuleMesh last_;
    std::vector<StencilTable> steps_;
    CornerFaces faces_;  ///< other schemes: of faces alone
};

/// Of the first levels of those asked for.
/// @param beside  bytes that something else will take then
/// @throws Error  unsupported, memory_limit, as RuleRefiner; before anything is allocated
void check_rule_memory(const ControlMesh& mesh, const SchemeInfo& scheme, int levels, int asked,
                       const RunContext& context, std::uint64_t beside = 0);

}  // namespace detail

/// The control mesh as the rules of any scheme take it, same numbers of vertices, half-edges and faces, with its corner
/// angles and, where the rules measure them, those of the other sectors at corners.
/// @param sharp_for_ever  semi-sharp tags are infinitely sharp ones
RuleMesh rule_mesh(const ControlMesh& mesh, const RuleOptions& rules = {}, bool sharp_for_ever = false);
/// As a scheme takes it (splits_vertices()).
RuleMesh rule_mesh(const ControlMesh& mesh, const SchemeInfo& scheme, const RuleOptions& rules);
/// The first step over such a mesh: some schemes begin in another way where there are other faces than quads, and then
/// take parts of the mesh as they take the whole.
RuleStep (*first_rule_step(const SchemeInfo& scheme, const RuleMesh& mesh))(const RuleMesh&, const RuleOptions&);

/// Refines by any scheme of the table, by its rules: the general path, for every scheme, choice and kind of mesh. All
/// that depends on connectivity and tags is done once and kept as stencils; refine() then applies them to any control
/// points. The function refine() has much faster ways for most of them.
///
/// Faces and vertices are in the order of the schemes' rules (RuleStep). Holes and isolated vertices are left in.
class RuleRefiner {
  public:
    /// @param levels        >= 0: steps of the scheme (a sqrt3 or 4-8 step is two of its simple steps)
    /// @param first_levels  where someone has them already
    /// @throws Error  invalid_input: a mesh that the scheme cannot take (the message says why); unsupported: more
    ///                elements than 31 bits can count, or a limit that the scheme has no mask for; memory_limit (with
    ///                the numbers, before they are allocated); cancelled
    /// Cost: one to six microseconds per point of the last level (Doo-Sabin 1, Loop to Kobbelt 3, biquartic 6), one
    /// thread.
    RuleRefiner(const ControlMesh& mesh, const SchemeInfo& scheme, int levels, const RefineOptions& options = {},
                std::unique_ptr<detail::RuleLevels> first_levels = nullptr);

    std::uint32_t vertex_count() const { return static_cast<std::uint32_t>(last().vertex_count()); }
    std::uint32_t face_count() const { return static_cast<std::uint32_t>(last().face_count()); }
    /// Connectivity and tags of the last level.
    const RuleMesh& last() const { return levels_->last(); }
    /// The control face that a face belongs to: that in which it lies, of a dual scheme that in which most of its
    /// corners do, the first one of several.
    std::uint32_t control_face(std::uint32_t face) const {
        return static_cast<std::uint32_t>(levels_->control_face(static_cast<int>(face)));
    }

    /// With a limit: vertices beyond the end of the surface, where boundaries recede (AveragingBoundary); what refine()
    /// says of them is of the control net. Ascending.
    std::span<const int> vertices_beyond() const { return limits_.missing; }

    /// Points of the last level (limits where the options say so). The same bytes for any number of threads.
    /// @param normals  empty, or unit limit normals, where the options ask for these: where a vertex has no tangents
    ///                 (corners, schemes without tangent masks there) the mean normal of the faces around it; the mean
    ///                 of both sides on a crease
    void refine(std::span<const Vec3d> control, std::span<Vec3d> positions, std::span<Vec3d> normals = {}) const;

    /// What refine() does, as one row per vertex of weights of control vertices.
    /// @param wanted  by vertex, 0: leave its row out; empty: all rows
    /// @throws Error  memory_limit (with the numbers, before the table is allocated)
    StencilTable stencils(std::span<const char> wanted = {}) const;

  private:
    /// coarse.then(fine), where it finds room.
    StencilTable composed(const StencilTable& coarse, const StencilTable& fine) const;
    /// What levels and limits take, with a table of stencils from the control vertices.
    std::uint64_t bytes_with(const StencilTable& table) const;
    void check_memory(const std::string& what, std::uint64_t bytes) const;

    std::uint32_t control_vertices_;
    RefineOptions options_;
    std::unique_ptr<detail::RuleLevels> levels_;
    std::string source_;
    detail::RuleLimits limits_;
};

}  // namespace tetrakis
