#pragma once

#include "../../hier/base/vec.hpp"
#include "../../hier/mesh/control_mesh.hpp"
#include "../../schemes/core/scheme_table.hpp"
#include "../rules/refine_options.hpp"

#include <memory>
#include <span>
#include <string_view>

namespace tetrakis {

/// Refines an animated control mesh, whose vertices move, again and again by any scheme. The constructor does what
/// tetrakis::refine() does; later calls compute positions and normals only, without any work on connectivity and tags.
///
/// Angles measured in the control mesh (RuleOptions::measure_corner_angles) stay those of the first positions. One
/// object serves one thread at a time; the work is parallel, and gives the same bytes for any number of threads.
class PositionRefiner {
  public:
    /// The arguments are those of tetrakis::refine(). The mesh must outlive the refiner, and so must all that the
    /// progress callback refers to: later calls report progress, too.
    /// @throws Error  as refine(); invalid_input: faces that a triangle scheme would have to cut first
    /// Cost: that of refine(). The refined mesh and the stencil rows are kept; by rules these are the rows of all
    /// levels.
    PositionRefiner(const ControlMesh& mesh, const SchemeInfo& scheme, int levels, const RefineOptions& options = {});
    PositionRefiner(const ControlMesh& mesh, std::string_view scheme, int levels, const RefineOptions& options = {});
    // A temporary mesh would be gone before the refiner is used.
    PositionRefiner(const ControlMesh&&, const SchemeInfo&, int, const RefineOptions& = {}) = delete;
    PositionRefiner(const ControlMesh&&, std::string_view, int, const RefineOptions& = {}) = delete;
    ~PositionRefiner();
    PositionRefiner(PositionRefiner&&) noexcept;
    PositionRefiner& operator=(PositionRefiner&&) noexcept;

    /// The result of tetrakis::refine() for the positions of the control mesh; refine() below does not change it.
    const PolygonMesh& mesh() const;

    /// Positions (on the limit surface if the options say so) and unit limit normals for other control positions. They
    /// are byte for byte those of tetrakis::refine() for a control mesh with these positions and the same tags.
    /// @param control    one position per control vertex; not checked: where one is not finite, all points that
    ///                   depend on it are not finite
    /// @param positions  receives the positions, as many as mesh() has and in its order
    /// @param normals    receives the normals, as many as mesh() has; or empty: no normals
    /// @throws Error     invalid_input: a span of the wrong length, also normals that the options did not ask for;
    ///                   cancelled (the contents of the spans are then undefined)
    /// Cost per vertex: 5 ns by the kernels of Catmull-Clark and Loop, 10 to 25 by other rows that repeat, 30 to 50 by
    /// rules (see tetrakis::refine()); with limits and normals 30, 40 to 150, and 60 to 500. If the mesh has holes,
    /// isolated vertices or a boundary that recedes, points go through a buffer; otherwise they are written directly.
    void refine(std::span<const Vec3d> control, std::span<Vec3d> positions, std::span<Vec3d> normals = {}) const;

  private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace tetrakis
