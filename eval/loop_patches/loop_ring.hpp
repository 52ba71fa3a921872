#pragma once

#include "../surface/surface_point.hpp"
#include "box_spline.hpp"

#include <optional>
#include <vector>

namespace tetrakis::detail {

/// A corner of a cell with everything around it that its rules look at. A ring evolves from level to level by itself:
/// the next ring are the vertex point and the edge points of the edges at the centre.
struct LoopRing {
    /// An edge at the centre.
    struct Spoke {
        Vec3d point{0};       ///< its other end
        float sharpness = 0;  ///< of the edge (infinity at a boundary)
        float near_half = 0;  ///< sharpness of its half at the centre, one level further down
        float far_half = 0;   ///< of its half at the other end
    };
    Vec3d centre{0};
    float sharpness = 0;        ///< of the centre
    bool boundary = false;      ///< the first and last spokes are boundary edges
    bool chaikin = false;       ///< how sharpness passes on
    int cell = 0;               ///< the cell lies between spokes cell and cell + 1
    std::vector<Spoke> spokes;  ///< counter-clockwise

    int size() const { return static_cast<int>(spokes.size()); }
    int wrap(int i) const { return (i % size() + size()) % size(); }

    /// Fills the spokes' near_half from their sharpness.
    void halve();
    Vec3d edge_point(int spoke) const;
    Vec3d vertex_point() const;
    /// The ring one level further down, around the same vertex.
    LoopRing child() const;

    /// No tag that will go away.
    bool is_stationary() const;
    /// Interior, and nothing sharp.
    bool is_smooth() const;
    /// Six neighbours, counter-clockwise from the cell's next corner, with which the regular rules give what this
    /// ring's rules give, at this level and below, on the cell's side; empty if there are none. Across a boundary or
    /// crease with three triangles on the cell's side the missing neighbours are reflected: c + p_0 - p_1; at a corner
    /// with a single triangle, through the centre too.
    std::optional<std::array<Vec3d, 6>> regular_neighbours() const;
    /// Limit position, normal, and tangents of the cell's sector.
    SurfacePoint limit() const;
};

/// A cell by the rings of its corners: what is left when it is neither regular nor a star.
struct LoopRings {
    std::array<LoopRing, 3> corner;

    /// The four quarters: at corner k (corners in the parent's order), and [3] the centre (mid12, mid02, mid01).
    std::array<LoopRings, 4> children() const;
    /// The 12 points, if the cell is regular or can be made so.
    std::optional<Net12> regular_net() const;
    /// Which corner is smooth and extraordinary while the others are regular, or -1.
    int star_corner() const;
    /// loop_star_size(valence) points, turned so that `corner` comes first.
    std::vector<Vec3d> star_points(int corner) const;
    /// All points; the limit surface over the cell is in their convex hull.
    std::vector<Vec3d> points() const;
};

}  // namespace tetrakis::detail
