#pragma once

#include "../../hier/base/run_context.hpp"
#include "../../hier/forest/corner_cell.hpp"
#include "../../hier/trees/vertex_roots.hpp"
#include "../../refine/points/level_source.hpp"
#include "../../schemes/core/scheme_table.hpp"
#include "../bounds/dual_cells.hpp"

#include <memory>
#include <span>

namespace tetrakis::detail {

/// The limit surface of a scheme over the lattice of a SampledSurface.
class LatticeLimits {
  public:
    virtual ~LatticeLimits() = default;
    /// Limit positions and unit normals of sites of the roots.
    virtual void points(std::span<const Site> sites, std::span<Vec3d> positions, std::span<Vec3d> normals) const = 0;
    /// Bounds on the distance of the limit surface over each of these finest triangles from that triangle, or from the
    /// triangles around it. All are of one corner cell.
    virtual void bound(std::span<const CellTriangle> triangles, std::span<double> errors) const = 0;
};

/// Quads over whose corner cells a dual surface is parametrised: the cells of level 1, in their order. Quads share
/// vertices across creases, too. Positions and uvs are interpolated linearly in the control faces; quads along
/// boundaries and creases collapse to the edge.
/// @throws Error  as vertex_roots() does; unsupported: holes, or two cells that have two sides in common
ControlMesh dual_roots(const ControlMesh& control, const SchemeInfo& scheme, const RuleOptions& rules);

/// The limit surface of Doo-Sabin or midedge. A point where cells of a level meet has the mean of their vertices as its
/// limit position, as no later step changes this mean.
class DualLimits final : public LatticeLimits {
  public:
    /// @param level  of the lattice: 2^level steps to a side of a corner cell of dual_roots()
    /// Keeps references to the mesh and the scheme.
    DualLimits(const ControlMesh& control, const SchemeInfo& scheme, const RuleOptions& rules, int level,
               const RunContext& context);

    void points(std::span<const Site> sites, std::span<Vec3d> positions, std::span<Vec3d> normals) const override;
    void bound(std::span<const CellTriangle> triangles, std::span<double> errors) const override;

  private:
    using Corner = VertexRoots::Corner;

    /// A point of the lattice as a corner of a cell of its finest squares.
    Corner corner(const Site& site) const;
    void points(std::span<const Corner> corners, std::span<Vec3d> positions, std::span<Vec3d> normals) const;

    VertexRoots roots_;
    int level_;  // of the cells that are the finest squares
    bool midedge_;
    std::shared_ptr<const LevelSource> source_;
    int to_a_point_;   // levels that a descent to a point takes
    DualCells cells_;  // empty; bound() calls find() of a copy
};

}  // namespace tetrakis::detail
