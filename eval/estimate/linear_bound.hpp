#pragma once

#include "../../hier/mesh/control_mesh.hpp"
#include "../../schemes/core/scheme_table.hpp"
#include "surface_bound.hpp"

#include <vector>

namespace tetrakis {

/// Certified errors over the surfaces of bilinear and midpoint refinement, which are polynomials: midpoint refinement
/// stays on the triangles of the control mesh; a corner cell of bilinear refinement is the bilinear patch of its
/// corners, whose difference from the flat triangle between three of its points is the twist vector times that of x y
/// from its own interpolation, which is largest on an edge: |dx dy| / 4. It bounds the parametric difference, and so
/// the distance in both directions; the rounding of positions is included. Over a convex face that is flat but for e,
/// cells and triangles lie over the same polygon, whatever slides along it: there it is 2 e if that is less.
class LinearBound final : public SurfaceBound {
  public:
    /// @param mesh    lives longer
    /// @param scheme  is_linear()
    LinearBound(const ControlMesh& mesh, const SchemeInfo& scheme);
    LinearBound(const ControlMesh&&, const SchemeInfo&) = delete;

    double bound(const CellTriangle& triangle) const;
    /// Of a face cut along its diagonals; infinite for more than four corners that are no flat convex polygon.
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
    std::vector<double> face_bound_;  ///< of flat convex faces; infinite for the others
};

}  // namespace tetrakis
