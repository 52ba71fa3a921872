#pragma once

#include "../../schemes/core/scheme_table.hpp"
#include "dual_face_bound.hpp"
#include "dual_leaf_error.hpp"
#include "dual_surface.hpp"

#include <functional>
#include <span>
#include <vector>

namespace tetrakis::detail {

/// Certified errors of the mesh of a vertex forest's leaves at their limit points: for each face of it a part of the
/// limit surface, around the point where its leaves meet and cut off along lines from vertex to vertex, so that neither
/// is farther from the other anywhere. All parts together are the surface.
///
/// Where four cells meet, or three along the side of one, those are rectangles in the plane; lines are straight there,
/// and the surface is compared with the triangles parameter by parameter: the difference is a polynomial on each cell,
/// whose Bernstein coefficients bound it. It maps the part onto the triangle, so that it bounds both directions.
///
/// Around other points the surface has no such parameters. There the flat face F (ConvexFace) is a convex set, and the
/// distance from it is a convex function: at most that of the coefficients, and of the control points nearest to the
/// point, whose hull holds the rest (`forward`). The other way, the map to the nearest point of F is continuous. It
/// takes the surface over a side to within some distance of that side (`in_plane`), so that it goes around each point
/// of F that is farther than that from all sides once, and meets it; and from the other points of F to the surface over
/// the side it is no more than that and `off` again, the distance of that line from the side. The triangles themselves
/// are as far from F as their corners are from its plane.
///
/// What that leaves above the tolerance is looked at with the pieces around (DualCloseBound): beside an extraordinary
/// point the surface slides along the mesh by a share of the cell's size, however small, which is no error.
///
/// Where a crease ends, two lines lead from one vertex to the other, and what lies between is compared with the edge.
class DualBound {
  public:
    /// Doo-Sabin and midedge, by either of their weights: quadratic, with no negative weight anywhere.
    static bool has(const SchemeInfo& scheme);

    /// @param points  gives the limit points; lives longer
    /// @param roots   without holes
    DualBound(const PartialLevels& points, const SchemeInfo& scheme, const VertexRoots& roots, const Box3d& box);

    /// How well errors are to be known.
    struct Wanted {
        double decide_at;  ///< errors up to this need not be smaller
        bool tight;        ///< errors above it are bounds, too; else they may be any number above it
    };
    struct Errors {
        std::vector<double> of_vertex;  ///< the largest over its cell; of a face that is bounded as a whole, all of it
        std::vector<double> of_triangle;  ///< of the face that it is of
        double largest = 0;
    };
    /// @param positions  of the mesh's vertices: their limit points
    Errors errors(const VertexForest& forest, const DualTriangles& mesh, std::span<const Vec3d> positions,
                  const Wanted& wanted, const std::function<void(double)>& report);

    /// Forgets what it knows of slots from this number on: a forest is taken back to an earlier state.
    void forget_from(std::uint32_t slot) { surface_.forget_from(slot); }

  private:
    void find_points(const VertexForest& forest, const DualFaces& faces, std::span<const std::uint8_t> wanted,
                     int deeper, const std::function<void(double)>& report);
    /// The points that a face's leaves touch; whether there are any.
    bool add_points(const VertexForest& forest, const DualNet& net, std::uint32_t face,
                    std::vector<std::uint8_t>& wanted) const;

    DualSurface surface_;
    double rounding_;
};

}  // namespace tetrakis::detail
