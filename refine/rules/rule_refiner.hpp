#pragma once

#include "../../hier/base/vec.hpp"
#include "../../hier/mesh/control_mesh.hpp"
#include "../../schemes/core/rule_step.hpp"
#include "../../schemes/core/scheme_table.hpp"
#include "refine_options.hpp"

#include <cstdint>
#include <memory>
#include <span>

namespace tetrakis {

namespace detail {
class RuleLevels;
/// @throws Error  invalid_input, with both numbers, where a caller's array has the wrong length
void check_length(const char* what, std::size_t length, std::size_t expected);
/// @throws Error  invalid_input, as RuleRefiner
void check_rounds(int levels, const RefineOptions& options);
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
/// values. refine() has much faster ways for most of them.
///
/// Faces and vertices are in the order of the schemes' rules (RuleStep). Holes and isolated vertices are left in.
class RuleRefiner {
  public:
    /// @param levels  >= 0: steps of the scheme (a sqrt3 or 4-8 step is two of its simple steps)
    /// @throws Error  invalid_input: levels or smoothing < 0, or a mesh that the scheme cannot take (the message says
    ///                why); unsupported: more elements than 31 bits can count, or a limit that the scheme has no mask
    ///                for; memory_limit (with the numbers, before they are allocated); cancelled
    /// Cost: one to six microseconds per point of the last level (Doo-Sabin 1, Loop to Kobbelt 3, biquartic 6), one
    /// thread.
    RuleRefiner(const ControlMesh& mesh, const SchemeInfo& scheme, int levels, const RefineOptions& options = {});
    /// From the first levels on, where someone has them already.
    RuleRefiner(const ControlMesh& mesh, const SchemeInfo& scheme, int levels, const RefineOptions& options,
                std::unique_ptr<detail::RuleLevels> first_levels);
    ~RuleRefiner();
    RuleRefiner(RuleRefiner&&) noexcept;
    RuleRefiner& operator=(RuleRefiner&&) noexcept;

    std::uint32_t vertex_count() const;
    std::uint32_t face_count() const;
    /// Connectivity and tags of the last level.
    const RuleMesh& last() const;
    /// The control face that a face belongs to: that in which it lies, of a dual scheme that in which most of its
    /// corners do, the first one of several.
    std::uint32_t control_face(std::uint32_t face) const;

    /// With a limit: vertices beyond the end of the surface, where boundaries recede (AveragingBoundary); what refine()
    /// says of them is of the control net. Ascending.
    std::span<const int> vertices_beyond() const;

    /// Values of the last level (limits where the options say so), `width` numbers per vertex: positions or any other
    /// attribute. The same bytes for any number of threads.
    /// @throws Error  invalid_input: width < 1, a span of the wrong length
    void refine(std::span<const double> control, int width, std::span<double> out) const;
    /// @param normals  empty, or unit limit normals: where a vertex has no tangents (corners, schemes without tangent
    ///                 masks there) the mean normal of the faces around it; the mean of both sides on a crease
    /// @throws Error   invalid_input: a span of the wrong length, or normals that the options did not ask for
    void refine(std::span<const Vec3d> control, std::span<Vec3d> positions, std::span<Vec3d> normals = {}) const;

    /// What refine() does, as one row per vertex of weights of control vertices.
    /// @param wanted  by vertex, 0: leave its row out; empty: all rows
    /// @throws Error  memory_limit (with the numbers, before the table is allocated); invalid_input: the wrong length
    StencilTable stencils(std::span<const char> wanted = {}) const;

  private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace tetrakis
