#pragma once

#include "../../hier/base/memory.hpp"
#include "bicubic.hpp"
#include "box_spline.hpp"
#include "corner_ring.hpp"

#include <algorithm>
#include <array>

namespace tetrakis::detail {

/// Where (x, y), as seen from corner k with x along the side that leaves it counter-clockwise, lies in the cell.
inline std::array<int, 2> from_corner(int k, int x, int y) {
    std::array<int, 2> at{x, y};
    for (; k > 0; --k) at = {1 - at[1], at[0]};
    return at;
}

/// The 2 (n + k) points around a cell whose corners are smooth and interior: (0, 0) of valence n, (1, 1) of valence k,
/// the other two regular (Stam 1998 has k = 4). Cells of the first step have their face's centre at (1, 1); below it
/// one corner at most is extraordinary, and it is (0, 0).
///
/// points: the corners, then those around them, counter-clockwise from (-1, 1) on.
struct QuadStar : PoolNew {
    int valence = 0;
    int far_valence = 4;
    PoolVector<Vec3d> points;

    static std::size_t point_count(int valence, int far_valence = 4) {
        return 2 * (static_cast<std::size_t>(valence) + static_cast<std::size_t>(far_valence));
    }
    /// @param n  from 3 on
    void resize(int n, int k = 4) {
        valence = n, far_valence = k;
        points.resize(point_count(n, k));
    }
    int valence_of(int corner) const { return corner == 0 ? valence : corner == 2 ? far_valence : 4; }
    bool regular() const { return valence == 4 && far_valence == 4; }
    /// (0, 0); the far corner's quarters have it as that.
    static bool is_extraordinary(int corner) { return corner == 0; }
    /// The points of a regular cell, one of whose corners is (0, 0).
    Net16 net(int corner) const;
    std::size_t memory_bytes() const { return sizeof(QuadStar) + points.capacity() * sizeof(Vec3d); }
    /// Neighbour i of a corner, counter-clockwise: 0 the next corner, 1 the one opposite, and so on to 2 n - 1; edges'
    /// ends are even.
    const Vec3d& ring(int corner, int i) const { return points[ring_place(corner, i)]; }
    /// Its number.
    std::size_t ring_place(int corner, int i) const;
    CornerRing corner_ring(int corner) const;
    /// Limit position of a corner, (0, 0) (1, 0) (1, 1) (0, 1).
    Vec3d corner_limit(int corner) const;
};

/// One Catmull-Clark step: the quarters at the corners, each from its corner of the star on.
void subdivide(const QuadStar& star, std::array<QuadStar, 4>& quarters);

/// The points around a triangle whose corners are smooth and interior, of valences n0, n1, n2: its corners, and the
/// n0 + n1 + n2 - 9 others in their rings, counter-clockwise from the one across the side from corner 2 to corner 0.
/// With three valences of 6 that is Net12. Source: Stam 1998, whose cells have n1 = n2 = 6, as all stars below a root
/// have.
struct LoopStar : PoolNew {
    std::array<int, 3> valence{};
    PoolVector<Vec3d> points;

    /// @param n  from 3 on
    void resize(const std::array<int, 3>& n) {
        valence = n;
        points.resize(3 + outer_count());
    }
    bool regular() const { return !is_extraordinary(0) && !is_extraordinary(1) && !is_extraordinary(2); }
    bool is_extraordinary(int corner) const { return valence[static_cast<std::size_t>(corner)] != 6; }
    /// The points of a regular cell, one of whose corners is corner 0.
    Net12 net(int corner) const;
    std::size_t memory_bytes() const { return sizeof(LoopStar) + points.capacity() * sizeof(Vec3d); }
    /// Neighbour i of a corner, counter-clockwise from the next corner on.
    const Vec3d& ring(int corner, int i) const { return points[ring_place(corner, i)]; }
    /// Its number.
    std::size_t ring_place(int corner, int i) const {
        if (i < 2) return static_cast<std::size_t>((corner + 1 + i) % 3);
        const int before = corner == 0 ? 0 : corner == 1 ? valence[0] - 3 : valence[0] + valence[1] - 6;
        const auto outer = static_cast<std::size_t>(before + i - 2);
        return 3 + (outer < outer_count() ? outer : 0);
    }
    CornerRing corner_ring(int corner) const;
    Vec3d corner_limit(int corner) const;

  private:
    std::size_t outer_count() const {
        return static_cast<std::size_t>(std::max(1, valence[0] + valence[1] + valence[2] - 9));
    }
};

/// One Loop step: the quarters at the corners, each from its corner of the star on; and the centre, whose corners lie
/// opposite the star's.
void subdivide(const LoopStar& star, std::array<LoopStar, 4>& quarters);

}  // namespace tetrakis::detail
