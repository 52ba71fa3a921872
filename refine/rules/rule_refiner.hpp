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

/// Runs blocks of a refinement step's rows on all threads.
class ParallelBlocks final : public BlockRunner {
  public:
    void run(int count, const std::function<void(int)>& block) const override {
        for_each_index(
            static_cast<std::uint32_t>(count), [&](std::uint32_t i) { block(static_cast<int>(i)); }, 1);
    }
    bool is_parallel() const override { return !one_thread(); }
};

/// Evaluates all rows of the table on the points `in`. The terms of a row are added in their order.
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

/// Which control faces the points and faces of a dual scheme's levels belong to.
struct CornerFaces {
    std::vector<int> control_face;  ///< by face
    /// By half-edge, from level 1 on: the control face of the corner at its origin. At a crease, corners on each side
    /// have that side's face; where a crease ends, all corners around the point have the same face.
    std::vector<int> point_face;

    /// Replaces the control faces of a level by those of the next level.
    void follow(const RuleMesh& level, const RuleStep& step);
};

/// A control mesh refined step by step by the rules of a scheme. It keeps the stencils of all steps and the last mesh.
class RuleLevels {
  public:
    /// @param smoothing  rounds of smoothing before the first step; see RefineOptions
    RuleLevels(const ControlMesh& mesh, const SchemeInfo& scheme, const RuleOptions& rules, int smoothing);
    RuleLevels(const RuleLevels&) = delete;
    RuleLevels& operator=(const RuleLevels&) = delete;

    /// Makes one more step. Returns its RuleStep::child_halfedge.
    /// @throws Error  invalid_input: the scheme cannot take the mesh
    std::vector<int> advance();

    int level() const { return level_; }
    const RuleMesh& last() const { return last_; }
    /// The control face of a face. Dual schemes: of most of its corners, or the lowest such face of several.
    int control_face(int face) const { return faces_.control_face[static_cast<std::size_t>(face)]; }
    /// For each half-edge, the control face that the corner at its origin belongs to.
    std::vector<std::uint32_t> control_face_of_corners() const;
    /// The rounds of smoothing, then the steps made so far. Each table maps points of one level to points of the next.
    std::span<const StencilTable> steps() const { return steps_; }
    /// Computes the points of the last level from the control points.
    void net(std::span<const Vec3d> control, std::span<Vec3d> out) const;

  private:
    ParallelBlocks runner_;
    const SchemeInfo& scheme_;
    RuleOptions rules_;
    std::string source_;
    int level_ = 0;
    RuleMesh last_;
    std::vector<StencilTable> steps_;
    CornerFaces faces_;  ///< schemes that are not dual use `control_face` only
};

/// Checks that the first `levels` of the `asked` levels can be counted and fit into the memory limit.
/// @param beside  bytes that other data will take at the same time
/// @throws Error  unsupported, memory_limit, as RuleRefiner; before anything is allocated
void check_rule_memory(const ControlMesh& mesh, const SchemeInfo& scheme, int levels, int asked,
                       const RunContext& context, std::uint64_t beside = 0);

}  // namespace detail

/// The control mesh in the form that the rules of any scheme take. Vertices, half-edges and faces keep their numbers.
/// The result has the mesh's corner angles and, if `rules` ask for it, angles measured in the other sectors at corners.
/// @param sharp_for_ever  whether semi-sharp tags become infinitely sharp
RuleMesh rule_mesh(const ControlMesh& mesh, const RuleOptions& rules = {}, bool sharp_for_ever = false);
/// The same for one scheme; semi-sharp tags become infinitely sharp if splits_vertices().
RuleMesh rule_mesh(const ControlMesh& mesh, const SchemeInfo& scheme, const RuleOptions& rules);
/// The step that refines this mesh at level 0. Some schemes have a special first step for meshes that have other faces
/// than quads. Parts of such a mesh must be refined by the step of the whole mesh.
RuleStep (*first_rule_step(const SchemeInfo& scheme, const RuleMesh& mesh))(const RuleMesh&, const RuleOptions&);

/// Refines by the rules of any scheme in the table: the general path for every scheme, option and kind of mesh. The
/// constructor turns connectivity and tags into stencils; refine() then applies these to any control points. The
/// function tetrakis::refine() is much faster for most schemes.
///
/// Faces and vertices are in the order of the schemes' rules (RuleStep). Holes and isolated vertices are kept.
class RuleRefiner {
  public:
    /// @param levels        >= 0: steps of the scheme (a sqrt3 or 4-8 step is two of its simple steps)
    /// @param first_levels  the first levels, if the caller has made them already; else null
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
    /// The control face that a face lies in. Dual schemes: the control face of most of its corners, or the lowest such
    /// face of several.
    std::uint32_t control_face(std::uint32_t face) const {
        return static_cast<std::uint32_t>(levels_->control_face(static_cast<int>(face)));
    }

    /// With limits: vertices outside of the surface where boundaries recede (AveragingBoundary), ascending. refine()
    /// gives the position and normal of such a vertex on the last level's mesh.
    std::span<const int> vertices_beyond() const { return limits_.missing; }

    /// Points of the last level, or limits if the options ask for them. The same bytes for any number of threads.
    /// @param normals  empty, or receives unit limit normals, if the options ask for them: on a crease the mean of both
    ///                 sides; where a vertex has no tangents (at corners, or without a tangent mask), the mean normal
    ///                 of the faces around it
    void refine(std::span<const Vec3d> control, std::span<Vec3d> positions, std::span<Vec3d> normals = {}) const;

    /// The stencils that refine() applies: one row per vertex, of weights of control vertices.
    /// @param wanted  one value per vertex, 0 leaves out the vertex's row; empty: all rows
    /// @throws Error  memory_limit (with the numbers, before the table is allocated)
    StencilTable stencils(std::span<const char> wanted = {}) const;

  private:
    /// Returns coarse.then(fine), after a check of its memory.
    StencilTable composed(const StencilTable& coarse, const StencilTable& fine) const;
    /// Bytes of the levels and limits, and of a table of stencils from the control vertices.
    std::uint64_t bytes_with(const StencilTable& table) const;
    void check_memory(const std::string& what, std::uint64_t bytes) const;

    std::uint32_t control_vertices_;
    RefineOptions options_;
    std::unique_ptr<detail::RuleLevels> levels_;
    std::string source_;
    detail::RuleLimits limits_;
};

}  // namespace tetrakis
