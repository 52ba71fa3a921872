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
    /// How far the limit surface is at most from each of these finest triangles of one corner cell, or from those
    /// around it.
    virtual void bound(std::span<const CellTriangle> triangles, std::span<double> errors) const = 0;
};

/// The quads over whose corner cells a dual surface lies: the cells of level 1, one after the other. Quads share
/// vertices along creases, too. Positions and uvs are those of the control faces, linear; quads beside boundaries and
/// creases are on the edge.
/// @throws Error  as vertex_roots() does; unsupported: holes, cells of which two have two sides in common
ControlMesh dual_roots(const ControlMesh& control, const SchemeInfo& scheme, const RuleOptions& rules);

/// The limit surface of Doo-Sabin or midedge. Where the cells of a level meet is a point of the surface: the mean of
/// their vertices, which no step changes.
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
    double hull_error(const DualCells& cells, const VertexCell& cell, std::span<const Vec3d> hull) const;

    VertexRoots roots_;
    int level_;  // of the cells that are the finest squares
    bool midedge_;
    std::shared_ptr<const LevelSource> source_;
    DualCells cells_;  // nothing found yet
};

}  // namespace tetrakis::detail
