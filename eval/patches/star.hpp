#pragma once

#include "../../hier/base/memory.hpp"
#include "bicubic.hpp"
#include "box_spline.hpp"
#include "corner_ring.hpp"

#include <algorithm>
#include <array>

namespace tetrakis::detail {

/// Cell coordinates of the point (x, y) of corner k's frame, whose x axis is the side to the next corner.
inline std::array<int, 2> from_corner(int k, int x, int y) {
    std::array<int, 2> at{x, y};
    for (; k > 0; --k) at = {1 - at[1], at[0]};
    return at;
}

/// The points around a cell whose corners are smooth and interior: the corners, then the others in their rings,
/// counter-clockwise. A ring has the ends of n edges and, of quads, the far corners of the n faces between them.
///
/// A quad with (0, 0) of valence n, (1, 1) of valence k and two regular corners has 2 (n + k) points (Stam 1998 has k =
/// 4); the first outer one is (-1, 1). In cells of the first step (1, 1) is the face's centre. A triangle has n0 + n1 +
/// n2 - 6 points; the first outer one lies across the side from corner 2 to corner 0. With three valences of 6 they are
/// Net12. Below a root at most one corner is extraordinary: corner 0.
template <int Corners>
struct Star : PoolNew {
    static constexpr int k_corners = Corners;
    static constexpr int k_regular = Corners == 4 ? 4 : 6;
    static constexpr int k_per_edge = Corners == 4 ? 2 : 1;  ///< ring points per edge
    using Valences = std::array<int, Corners>;

    Valences valence{};
    PoolVector<Vec3d> points;

    /// @param n  valences of at least 3; for quads n[1] and n[3] are 4
    void resize(const Valences& n) {
        valence = n;
        // Three triangles around one point close without another one.
        points.resize(static_cast<std::size_t>(Corners + std::max(1, outer_before(Corners))));
    }
    /// Valence n for corner 0; the other corners are regular.
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
    /// For quads only (0, 0) counts: the quarter at the far corner has that corner as its own (0, 0).
    bool is_extraordinary(int corner) const { return Corners == 4 ? corner == 0 : valence_of(corner) != k_regular; }
    std::size_t memory_bytes() const { return sizeof(Star) + points.capacity() * sizeof(Vec3d); }
    /// Point i of a corner's ring, counter-clockwise from the next corner on.
    const Vec3d& ring(int corner, int i) const { return points[ring_place(corner, i)]; }
    /// Its index in `points`.
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
    /// Number of outer points before the first one of a corner's ring.
    int outer_before(int corner) const {
        constexpr int k_shared = 2 * Corners - 3;  // with the corners before and after, the corners themselves included
        int count = 0;
        for (int k = 0; k < corner; ++k) count += k_per_edge * valence_of(k) - k_shared;
        return count;
    }
};
using QuadStar = Star<4>;
using LoopStar = Star<3>;

/// Control net of a regular cell; its corner `corner` is corner 0 of the star.
Net16 net_of(const QuadStar& star, int corner);
Net12 net_of(const LoopStar& star, int corner);

/// Limit position of a corner.
Vec3d corner_limit(const QuadStar& star, int corner);
Vec3d corner_limit(const LoopStar& star, int corner);

/// One Catmull-Clark step. Quarter k lies at corner k of the star, which becomes corner 0 of the quarter's star.
void subdivide(const QuadStar& star, std::array<QuadStar, 4>& quarters);

/// One Loop step. Quarter k < 3 lies at corner k of the star, which becomes corner 0 of the quarter's star. Quarter 3
/// is the central one; its corner k lies opposite the star's corner k.
void subdivide(const LoopStar& star, std::array<LoopStar, 4>& quarters);

}  // namespace tetrakis::detail
