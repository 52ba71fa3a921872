#pragma once

#include "box_spline.hpp"
#include "corner_ring.hpp"

#include <optional>
#include <vector>

namespace tetrakis::detail {

/// A cell by the rings of its corners: what is left when it is neither regular nor a star.
struct LoopRings {
    std::array<CornerRing, 3> corner;

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
