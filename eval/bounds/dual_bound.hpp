#pragma once

#include "../../hier/mesh/control_mesh.hpp"
#include "../../schemes/core/scheme_table.hpp"
#include "dual_cells.hpp"
#include "dual_leaf_error.hpp"

#include <functional>
#include <span>
#include <vector>

namespace tetrakis::detail {

/// Certified errors of the mesh whose vertices are the limit points of a vertex forest's leaves. Each face stands for
/// the part of the surface around the point where its leaves meet. Straight lines between vertices, in the cells'
/// parameters, bound that part; in a quad, a line through the point lies over the diagonal. The error of a triangle is
/// that of CellBounder, with the mesh's own sliding (EdgeSliding). Regular cells give polynomials: of degree 4
/// (Doo-Sabin), or four of degree 2 (midedge).
///
/// A face of more than four corners lies around an extraordinary point. It is compared as a whole, as a flat convex
/// polygon; its corners' distance from the plane is added. If it is not convex, face and surface are compared with the
/// face's first corner. Where a crease ends, two lines lead from one vertex to the other, and the surface between them
/// is compared with the edge.
class DualBound {
  public:
    /// Whether there are bounds: for Doo-Sabin and midedge with either of their weights, which are never negative.
    static bool has(const SchemeInfo& scheme);

    /// @param points  gives the control points; must outlive this object
    /// @param roots   without holes; must outlive this object
    DualBound(const LevelSource& points, const SchemeInfo& scheme, const VertexRoots& roots, const ControlMesh& mesh);

    /// How tight errors must be.
    struct Wanted {
        double decide_at;  ///< bounds up to this value need not be tight
        bool tight;        ///< whether larger errors are bounds, too; else they are any number above `decide_at`
    };
    struct Errors {
        std::vector<double> of_vertex;  ///< per vertex, the largest over its cell
        double largest = 0;
    };
    /// @param positions  of the mesh's vertices: their limit points
    Errors errors(const VertexForest& forest, const DualTriangles& mesh, std::span<const Vec3d> positions,
                  const Wanted& wanted, const std::function<void(double)>& report);

  private:
    DualCells cells_;
    bool midedge_;
    double rounding_;
};

}  // namespace tetrakis::detail
