#pragma once

#include "../../hier/base/run_context.hpp"
#include "../../hier/base/vec.hpp"

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace tetrakis {

/// What is known of a mesh around one of its triangles T, so that the surface over T may slide over T's edges.
///
/// Across a sliding edge another triangle follows, which is turned against T's plane by at most `fold`; and either
/// of the two contains the isosceles triangle over the edge (its flap) whose base angles have the tangent `flap`. Flaps
/// of one triangle do not overlap.
///
/// The error of a leaf, with sliding at some edges: let f be the foot of a point p of its surface on T's plane, h its
/// height, D the triangle together with the flaps beyond its sliding edges (unfolded into the plane: convex), R the
/// two flaps at an edge, t how far f lies beyond the line of a sliding edge, w that edge's fold, W the largest. It
/// is the largest of
///     sqrt(h^2 + dist(f, D)^2) + max(0, w t)                         for all points, the largest over the edges,
///     dist(p, edge)                                                  for those on a fixed side,
///     sqrt(h^2 + dist(f, R)^2) (1 + W^2 / 4) + W dist(f, edge)       for those on a sliding side.
/// Where the errors of all leaves are at most E, the mesh and the surface are within E of each other both ways. Proof:
/// there is a continuous map F of the surface into the mesh that moves no point by more than E: p goes to the point of
/// D that is nearest to f, folded back; on a sliding side to the nearest point of R, unfolded into the plane that
/// halves the fold, so that both leaves agree there; on a fixed one to the nearest point of the edge. (Projections
/// onto convex sets that contain the edge do not increase the distance from it, nor t, and folding moves a point by at
/// most w t. The flaps are those that the mesh has room for; with smaller ones a bound only grows.) In a narrow
/// collar F changes from one rule to the other, from u to v: in a leaf's own unfolded plane both ends are within E of
/// p, so the point where the line between them crosses the edge is, and in the folded mesh each of its two parts lies
/// in a plane, where distances are convex. A leaf with a side that does not slide over an edge at which its neighbour
/// does has such a collar, too. F and the parametrisation of the surface by the mesh carry each leaf into the same T
/// with flaps, which is contractible, so they are homotopic; F has degree 1 and meets every point of the mesh.
///
/// For fold 0 at all edges it is sliding in a plane, which costs nothing.
struct EdgeSliding {
    std::array<bool, 3> edge{};    ///< which edges slide (corner k to k + 1)
    std::array<double, 3> fold{};  ///< of those, in radians
    std::array<double, 3> flap{};  ///< of those; tangents

    bool any() const { return edge[0] || edge[1] || edge[2]; }
};

/// Largest fold of a sliding edge: with more it helps little.
inline constexpr double k_largest_fold = 0.25;

/// The folds of a conforming triangle mesh, and the room that its triangles leave at their edges (EdgeSliding).
class MeshSliding {
  public:
    /// Of an oriented mesh. Edges of more than two triangles do not slide. Keeps a reference to the triangles. O(T).
    MeshSliding(std::span<const std::array<std::uint32_t, 3>> triangles, std::span<const Vec3d> positions);

    /// What triangle t may slide over: its soft edges that bend by at most k_largest_fold.
    EdgeSliding of(std::uint32_t t, const std::array<bool, 3>& soft) const;

  private:
    static constexpr std::uint32_t k_none = 0xffffffffu;
    struct Facet {
        std::array<float, 3> normal{};   ///< unit length, or none
        std::array<float, 3> tangent{};  ///< a lower bound on that of half the angle at each corner
    };
    /// An upper bound on the angle between two triangles' planes, by its tangent; infinite above 60 degrees.
    static double fold(const Facet& a, const Facet& b);
    double flap(std::uint32_t t, std::size_t k, std::uint32_t twin) const;

    std::span<const std::array<std::uint32_t, 3>> triangles_;
    std::vector<std::uint32_t> twin_;  ///< by 3 t + k: 3 t' + k' across, or k_none
    std::vector<Facet> facets_;
};

}  // namespace tetrakis
