#pragma once

#include "../../hier/base/vec.hpp"
#include "../../hier/mesh/control_mesh.hpp"
#include "../../schemes/core/scheme_table.hpp"
#include "../rules/refine_options.hpp"

#include <memory>
#include <span>
#include <string_view>

namespace tetrakis {

/// Refines a control mesh whose vertices move, an animated one, again and again by any scheme: the first time as
/// refine(), from then on only its positions, by the way that refine() has taken, without looking at connectivity and
/// tags once more.
///
/// What a refinement measures in the control mesh (RuleOptions::measure_corner_angles) stays as it was at first. One
/// object serves one thread at a time; the work is parallel, and gives the same bytes for any number of threads.
class PositionRefiner {
  public:
    /// All arguments are refine()'s. The mesh outlives the refiner; so does what the progress callback refers to, which
    /// is told of later calls, too.
    /// @throws Error  as refine(); invalid_input: faces that a triangle scheme would have to cut first
    /// Cost: that of refine(); beside its mesh are kept points of the levels above the last, by rules all weights.
    PositionRefiner(const ControlMesh& mesh, const SchemeInfo& scheme, int levels, const RefineOptions& options = {});
    PositionRefiner(const ControlMesh& mesh, std::string_view scheme, int levels, const RefineOptions& options = {});
    // A temporary mesh would be gone before the refiner is used.
    PositionRefiner(const ControlMesh&&, const SchemeInfo&, int, const RefineOptions& = {}) = delete;
    PositionRefiner(const ControlMesh&&, std::string_view, int, const RefineOptions& = {}) = delete;
    ~PositionRefiner();
    PositionRefiner(PositionRefiner&&) noexcept;
    PositionRefiner& operator=(PositionRefiner&&) noexcept;

    /// What refine() gives, with the positions and normals of the control mesh as it is; refine() below leaves it so.
    const PolygonMesh& mesh() const;

    /// Positions (on the limit surface where the options say so) and unit limit normals for other control positions:
    /// byte for byte those of refine() of a control mesh that has them, its tags being the same.
    /// @param control    as many as the control mesh has vertices; they are not checked: a position that is not finite
    ///                   makes all points around it so
    /// @param positions  as many as mesh() has, in its order, to be written
    /// @param normals    as many as mesh() has, to be written; or empty: none
    /// @throws Error     invalid_input: a span of the wrong length, so for normals that the options did not ask for;
    ///                   cancelled (what is written is then worth nothing)
    /// Cost: 5 ns per vertex by the kernels of Catmull-Clark and Loop, 10 to 25 by other rows that repeat, 30 to 50 by
    /// rules (refine() says when); with limits and normals 30, 40 to 150, and 60 to 500. Points are written where they
    /// stay, unless the mesh has holes, isolated vertices or a boundary that recedes: then by way of one more buffer.
    void refine(std::span<const Vec3d> control, std::span<Vec3d> positions, std::span<Vec3d> normals = {}) const;

  private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace tetrakis
