#pragma once

#include "../../hier/base/run_context.hpp"
#include "../../hier/base/vec.hpp"

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace tetrakis {

/// Edges of a mesh's triangle T over which its part of the surface may slide, and the room that the mesh has there.
///
/// Across a sliding edge lies another triangle, whose plane makes an angle of at most `fold` with T's. Both triangles
/// contain a flap: the isosceles triangle over the edge whose base angles have the tangent `flap`. Flaps of one
/// triangle do not overlap.
///
/// Let p be a point of the leaf's surface, f its foot on T's plane, h its height over the plane. D is T with the flaps
/// beyond its sliding edges, unfolded into the plane (convex); R is the two flaps at an edge. Let f lie t beyond the
/// line of a sliding edge, w be that edge's fold, W the largest fold. The leaf's error with sliding is the largest of
///     sqrt(h^2 + dist(f, D)^2) + max(0, w t)                         for all points and all sliding edges,
///     dist(p, edge)                                                  for points on sides that do not slide,
///     sqrt(h^2 + dist(f, R)^2) (1 + W^2 / 4) + W dist(f, edge)       for points on sliding sides.
/// If the errors of all leaves are at most E, mesh and surface are within E of each other in both directions. Proof:
/// there is a continuous map F of the surface into the mesh that moves no point by more than E. F(p) is the point of D
/// nearest to f, folded back. On a sliding side it is the nearest point of R, unfolded into the plane that halves the
/// fold, so that both leaves agree there; on a fixed side, the nearest point of the edge. (Projections onto convex sets
/// that contain the edge do not increase the distance from it, nor t, and folding moves a point by at most w t. The
/// mesh has room for the flaps; smaller ones only increase a bound. If the two leaves of an edge have different flaps,
/// one R contains the other and is convex, so a collar as below joins their points in it.) In a narrow collar F changes
/// from one rule's point u to the other's point v. In a leaf's own unfolded plane both are within E of p, so the point
/// where the line between them crosses the edge is, too. In the folded mesh each of the line's two parts lies in a
/// plane, where distances are convex. A leaf with a fixed side at an edge where its neighbour slides has such a collar,
/// too. F and the parametrisation of the surface by the mesh map each leaf into the same T with flaps. This set is
/// contractible, so the maps are homotopic; F has degree 1 and meets every point of the mesh.
///
/// If all folds are 0, sliding is in a plane and adds nothing to the error.
struct EdgeSliding {
    std::array<bool, 3> edge{};    ///< whether edge k, from corner k to k + 1, slides
    std::array<double, 3> fold{};  ///< upper bounds on the folds of sliding edges, in radians
    std::array<double, 3> flap{};  ///< tangents of the base angles of flaps at sliding edges

    bool any() const { return edge[0] || edge[1] || edge[2]; }
};

/// Largest fold of a sliding edge, in radians: sliding over larger ones helps little.
inline constexpr double k_largest_fold = 0.25;

/// The folds of a conforming triangle mesh, and the room that its triangles leave at their edges (EdgeSliding).
class MeshSliding {
  public:
    /// For an oriented mesh. Edges of more than two triangles do not slide. Keeps a reference to `triangles`. O(T).
    MeshSliding(std::span<const std::array<std::uint32_t, 3>> triangles, std::span<const Vec3d> positions);

    /// The sliding of triangle t: over its `soft` edges that have a fold of at most k_largest_fold.
    EdgeSliding of(std::uint32_t t, const std::array<bool, 3>& soft) const;

  private:
    static constexpr std::uint32_t k_none = 0xffffffffu;
    struct Facet {
        Vec3f normal{0};                 ///< unit length, or none
        std::array<float, 3> tangent{};  ///< lower bound on the tangent of half the angle at each corner
    };

    std::span<const std::array<std::uint32_t, 3>> triangles_;
    std::vector<std::uint32_t> twin_;  ///< by edge 3 t + k: the edge 3 t' + k' of the triangle across, or k_none
    std::vector<Facet> facets_;
};

}  // namespace tetrakis
