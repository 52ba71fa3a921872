#pragma once

#include "tetrakis/eval/dual_surface.hpp"
#include "tetrakis/eval/short_polygon.hpp"
#include "tetrakis/hier/vertex_forest.hpp"

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace tetrakis::detail {

/// The mesh of a vertex forest's leaves as DualFaceBound goes over it: its faces, and after them the points where
/// creases end as if they were faces.
struct DualNet {
    DualFaces faces;                   ///< with corners
    std::vector<std::uint32_t> point;  ///< per face the point of DualCorners that it lies around, or none
    std::size_t face_count = 0;        ///< the faces that there are

    std::size_t size() const { return point.size(); }
};
DualNet dual_net(const VertexForest& forest, const DualCorners& corners);

/// How far the faces of the mesh of a vertex forest's leaves are from the parts of a limit surface that they stand for;
/// how this is known says DualBound.
class DualFaceBound {
  public:
    /// @param surface    knows the leaves and the points that they touch
    /// @param positions  of the mesh's vertices: their limit points
    DualFaceBound(const DualSurface& surface, const VertexForest& forest, const DualNet& net,
                  std::span<const Vec3d> positions)
        : surface_(surface), forest_(forest), net_(net), positions_(positions) {}

    /// @param of_corner  per corner of the face, receives the error over that corner's leaf; where the face is bounded
    ///                   as a whole, its coarsest leaves have the error and the others none
    void operator()(std::uint32_t face, std::span<double> of_corner) const;

  private:
    /// A leaf of a face. Sides of its cell are turned so that the face's point lies at the start of side `turn`, or in
    /// the middle of it.
    struct Corner {
        LeafId leaf;
        VertexCell cell;
        int turn;
        bool on_side;
        Vec2d at_place, vertex_place;  ///< of the face's point and the vertex, in sides of the root
        Vec2d at, vertex;              ///< the same in its coordinates
        Vec3d position;

        int side_behind() const { return turn; }
        int side_ahead() const { return on_side ? turn : (turn + 3) % 4; }
        /// Lengths into the cell and along the side to the corner before or behind, which is x or y; of a vector from
        /// the face's point.
        Vec2d from_behind(const Vec2d& v) const;
        Vec2d from_ahead(const Vec2d& v) const;
        /// The point so far along that side.
        Vec2d behind_at(double length) const;
        Vec2d ahead_at(double length) const;
    };
    using Corners = std::vector<Corner>;

    Corners corners_of(std::uint32_t face) const;
    void bound_regular(std::uint32_t face, const Corners& corners, std::span<double> of_corner) const;
    void bound_triangle(const Corners& corners, const std::array<std::size_t, 3>& of, const std::array<Vec2d, 3>& place,
                        std::span<const int> turns, std::span<double> of_corner) const;
    /// Where the lines from a corner's vertex to the next one's and to the one before leave its cell.
    struct Crossings {
        Vec2d ahead, behind;
    };
    /// Whether cells have the same coordinates along the side between them.
    bool agree(const Corner& corner, const Corner& next) const;
    std::vector<Crossings> crossings(const Corners& corners) const;

    double bound_face(const Corners& corners) const;
    double bound_end(const Corners& corners, bool closed) const;
    /// All of both is near the first vertex, which is on both.
    double bound_blindly(const Corners& corners, const std::vector<Crossings>& crossings) const;

    /// Calls take(p, slack) for points whose hull holds the surface over the corner's part of the face: between the
    /// face's point, the crossings and its vertex.
    template <class Take>
    void for_each_around(const Corner& corner, const Crossings& crossings, Take&& take) const;
    /// The same of the line from a corner's vertex to a crossing.
    template <class Take>
    void for_each_on_line(const Corner& corner, const Vec2d& crossing, Take&& take) const;
    template <class Take>
    void for_each_within(const Corner& corner, const ShortPolygon& polygon, Take&& take) const;
    template <class Take>
    void for_each_over(const Corner& corner, const ShortPolygon& shape, Take&& take) const;

    const DualSurface& surface_;
    const VertexForest& forest_;
    const DualNet& net_;
    std::span<const Vec3d> positions_;
};

}  // namespace tetrakis::detail
