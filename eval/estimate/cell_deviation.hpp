#pragma once

#include "../../hier/base/vec.hpp"
#include "../bounds/labelled_polygon.hpp"

#include <array>

namespace tetrakis {

/// A flat triangle whose points slide within it: the point with barycentrics b goes to the sum over its sides (i, j) of
/// slide b_i b_j (corner j - corner i) beyond its own place. With slides of less than 1 the corners stay, sides go onto
/// themselves one to one and nothing leaves the triangle; so all of it is met (by degree), and whatever is near the
/// slid points of a surface's parameters is near the surface.
struct SlidTriangle {
    std::array<Vec3d, 3> corner{};
    std::array<double, 3> slide{};  ///< of the side from corner k to the next

    /// One whose sides meet the surface's points at the middles of their parameters as near as sliding can.
    SlidTriangle(const std::array<Vec3d, 3>& corners, const std::array<Vec3d, 3>& middles);
    /// One that does not slide.
    explicit SlidTriangle(const std::array<Vec3d, 3>& corners) : corner(corners) {}
    SlidTriangle() = default;

    /// Where the point with these barycentrics goes.
    Vec3d operator()(const std::array<double, 3>& b) const;
    /// How far a point of a polygon in the parameters is at most from the mean of the slid corners, weighted as itself
    /// is of the corners.
    /// @param width  of each barycentric over the polygon
    double bend(const std::array<double, 3>& width) const;
};

/// A point in a cell, in its sides.
using CellPlace = Vec2d;
using PieceCorners = std::array<CellPlace, 3>;

/// A point of a piece in a cell.
struct PiecePoint {
    CellPlace at;
    std::array<double, 3> b;  ///< barycentrics
};
inline PiecePoint mix(const PiecePoint& p, const PiecePoint& q, double t) {
    return {detail::mix(p.at, q.at, t), detail::mix(p.b, q.b, t)};
}

/// The part of a cell that a triangle covers.
struct Covered {
    detail::LabelledPolygon<PiecePoint> part;
    bool none, whole;
};

/// @param cell_corners  3 or 4
Covered covered(const PieceCorners& triangle, int cell_corners);

/// How far a cell of a level is from a flat triangle, parameter by parameter.
struct Deviation {
    double at_points;  ///< at the corners of the part that the triangle covers
    double most;
    bool whole;  ///< the part is the cell
};

/// @param corner  of the cell
Deviation deviation(const Covered& covered, const std::array<Vec3d, 4>& corner, int cell_corners,
                    const SlidTriangle& triangle);

/// The same point's coordinates in a quarter of the cell.
CellPlace in_child(const CellPlace& p, int child, int cell_corners);
/// The same point's coordinates as seen from the cell's next corner.
CellPlace from_next_corner(const CellPlace& p, int cell_corners);

}  // namespace tetrakis
