#pragma once

#include "../../hier/mesh/control_mesh.hpp"
#include "../../schemes/core/scheme_table.hpp"
#include "surface_bound.hpp"

#include <vector>

namespace tetrakis {

/// Certified errors over the surfaces of bilinear and midpoint refinement, which are polynomials. Midpoint refinement
/// stays on the triangles of the control mesh. A corner cell of bilinear refinement is the bilinear patch of its
/// corners. It differs from the flat triangle between three of its points by the twist vector times the interpolation
/// error of x y. That is at most |dx dy| / 4 of an edge. This bounds the parametric difference, and so the distance in
/// both directions; the rounding of positions is included. Over a convex face whose corners are within e of a plane,
/// cells and triangles lie over the same polygon: there the bound is 2 e if that is less.
class LinearBound final : public SurfaceBound {
  public:
    /// @param mesh    must outlive the bound
    /// @param scheme  a scheme with is_linear()
    LinearBound(const ControlMesh& mesh, const SchemeInfo& scheme);
    LinearBound(const ControlMesh&&, const SchemeInfo&) = delete;

    double bound(const CellTriangle& triangle) const;
    /// Bound of a face cut along diagonals; infinite if it has more than four corners and is no flat convex polygon.
    double fan_bound(FaceId face) const;
    void bound(std::span<const CellTriangle> triangles, std::optional<double> known,
               std::span<double> errors) const override;
    void bound_fans(const FanChoice& fans, std::span<const FaceId> faces, std::span<const Vec3d> corners,
                    std::optional<double> known, std::span<double> errors) const override;

  private:
    Vec3d twist(HalfedgeId cell) const;
    double flat_face_bound(FaceId face) const;

    const ControlMesh& mesh_;
    bool flat_;
    double rounding_;
    std::vector<double> face_bound_;  ///< per face, if it is flat and convex; else infinite
};

}  // namespace tetrakis
