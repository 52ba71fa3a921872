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

/// The points around a cell whose corners are smooth and interior: the corners, then the others in their rings,
/// counter-clockwise. A ring has the ends of n edges and, of quads, the far corners of the n faces between them.
///
/// A quad, (0, 0) of valence n and (1, 1) of valence k, the other two regular, has 2 (n + k) points (Stam 1998 has
/// k = 4); the first outer one is (-1, 1). Cells of the first step have their face's centre at (1, 1). A triangle has
/// n0 + n1 + n2 - 6 points; the first outer one lies across the side from corner 2 to corner 0. With three valences of
/// 6 they are Net12. Below a root one corner at most is extraordinary, and it is corner 0.
template <int Corners>
struct Star : PoolNew {
    static constexpr int k_corners = Corners;
    static constexpr int k_regular = Corners == 4 ? 4 : 6;
    static constexpr int k_per_edge = Corners == 4 ? 2 : 1;  ///< points of a ring
    using Valences = std::array<int, Corners>;

    Valences valence{};
    PoolVector<Vec3d> points;

    /// @param n  from 3 on; of quads the second and the last one 4
    void resize(const Valences& n) {
        valence = n;
        // Three triangles around one point close without another one.
        points.resize(static_cast<std::size_t>(Corners + std::max(1, outer_before(Corners))));
    }
    /// All but corner 0 regular.
    static Valences with_first(int n) {
        Valences valence;
        valence.fill(k_regular);
        valence[0] = n;
        return valence;
    }
    int valence_of(int corner) const { return valence[static_cast<std::size_t>(corner)]; }
    bool regular() const {
        return std::ranges::all_of(valence, [](int n) { return n == k_regular; });
    }
    /// Of quads (0, 0); the far corner's quarters have it as that.
    bool is_extraordinary(int corner) const { return Corners == 4 ? corner == 0 : valence_of(corner) != k_regular; }
    std::size_t memory_bytes() const { return sizeof(Star) + points.capacity() * sizeof(Vec3d); }
    /// Neighbour i of a corner, counter-clockwise from the next corner on.
    const Vec3d& ring(int corner, int i) const { return points[ring_place(corner, i)]; }
    /// Its number.
    std::size_t ring_place(int corner, int i) const {
        if (i < Corners - 1) return static_cast<std::size_t>((corner + 1 + i) % Corners);
        const int outer = outer_before(corner) + i - (Corners - 1), count = static_cast<int>(points.size()) - Corners;
        return static_cast<std::size_t>(Corners + (outer < count ? outer : outer - count));
    }
    CornerRing corner_ring(int corner) const {
        CornerRing out;
        out.scheme = Corners == 4 ? SchemeKind::catmull_clark : SchemeKind::loop;
        out.centre = points[static_cast<std::size_t>(corner)];
        for (int i = 0; i < valence_of(corner); ++i)
            out.spokes.push_back(
                {ring(corner, k_per_edge * i), Corners == 4 ? ring(corner, k_per_edge * i + 1) : Vec3d(0)});
        return out;
    }

  private:
    /// Outer points before those that a corner's ring has first.
    int outer_before(int corner) const {
        constexpr int k_shared = 2 * Corners - 3;  // with the corners before and after, the corners themselves included
        int count = 0;
        for (int k = 0; k < corner; ++k) count += k_per_edge * valence_of(k) - k_shared;
        return count;
    }
};
using QuadStar = Star<4>;
using LoopStar = Star<3>;

/// The points of a regular cell, one of whose corners is corner 0 of the star.
Net16 net_of(const QuadStar& star, int corner);
Net12 net_of(const LoopStar& star, int corner);

/// Limit position of a corner.
Vec3d corner_limit(const QuadStar& star, int corner);
Vec3d corner_limit(const LoopStar& star, int corner);

/// One Catmull-Clark step: the quarters at the corners, each from its corner of the star on.
void subdivide(const QuadStar& star, std::array<QuadStar, 4>& quarters);

/// One Loop step: the quarters at the corners, each from its corner of the star on; and the centre, whose corners lie
/// opposite the star's.
void subdivide(const LoopStar& star, std::array<LoopStar, 4>& quarters);

}  // namespace tetrakis::detail
