#pragma once

#include "../../hier/base/run_context.hpp"
#include "../../hier/mesh/control_mesh.hpp"
#include "../../refine/points/position_source.hpp"
#include "../../schemes/core/scheme_table.hpp"
#include "../surface/surface_point.hpp"

#include <cstdint>
#include <memory>
#include <span>

namespace tetrakis {

/// The limit surface of Catmull-Clark or Loop, exact at any point, by a patch tree over the control mesh
/// (eval/patches/README.md). Plain rules only: no RuleOptions, no corner angles. Keeps a reference to the mesh;
/// thread-safe; a result depends on its arguments alone.
///
/// A Hierarchy can take its limit points from here (HierarchyOptions::limit_positions). They equal those by the
/// scheme's rules to rounding error, and take half the time.
///
/// Cost: O(half-edges) to build; then about one patch evaluation per point. Sources: Stam 1998 (extraordinary points);
/// Niessner et al. 2012 (semi-sharp creases), in closed form here.
class LimitSurface final : public PositionSource {
  public:
    /// @throws Error  invalid_input: Loop, and a face is not a triangle; unsupported: corner angles; memory_limit
    LimitSurface(const ControlMesh& mesh, SchemeKind scheme, const RunContext& context = {});
    LimitSurface(const ControlMesh&&, SchemeKind, const RunContext& = {}) = delete;
    ~LimitSurface() override;

    /// Position, derivatives by x and y, and normal at parameters of a root. Catmull-Clark: of the half-edge's corner
    /// cell, in [0, 1]^2; (0, 0) is the vertex, (1, 1) the centre of the face. Loop: of the triangle of the half-edge,
    /// its face's first one; x, y >= 0, x + y <= 1. On creases and at corners, values are of this root's side.
    /// @throws Error  invalid_input: no such root, or parameters outside of it
    SurfacePoint evaluate(HalfedgeId root, double x, double y) const;
    /// Position, first derivatives and normal of a vertex. On an infinitely sharp edge the normal is the mean of the
    /// normals on both sides.
    /// @throws Error  invalid_input: no site of a root
    SurfacePoint vertex(const Site& site) const;
    /// @param sites  of corner cells (Catmull-Clark) or face triangles (Loop), of levels up to k_max_level
    /// @throws Error  invalid_input: any other site, or spans of different lengths
    void positions(std::span<const Site> sites, std::span<Vec3d> out) const override;

    /// Bytes of the trees, which grow with the points asked for.
    std::uint64_t memory_bytes() const;

  private:
    struct Patches;
    std::unique_ptr<Patches> patches_;
};

}  // namespace tetrakis
