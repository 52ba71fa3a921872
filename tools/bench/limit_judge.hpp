#pragma once

#include "../../hier/mesh/control_mesh.hpp"
#include "../../schemes/core/scheme_table.hpp"
#include "../../tests/kit/nearest.hpp"
#include "peers/peer_osd.hpp"

#include <array>
#include <cstdint>
#include <limits>
#include <memory>
#include <vector>

namespace tetrakis::bench {

using test::NearestTriangle;

inline constexpr BfrLevels k_judge_levels{10, 10};

/// Measures any triangle mesh against a limit surface, without this library's evaluators: the surface is OpenSubdiv's
/// Bfr in double with its approximation levels at 10 (k_judge_levels), sampled on a grid of each face (its corners and
/// edges included) and at one jittered point per cell of the grid.
class LimitJudge {
  public:
    /// @param samples  at least so many grid points in all; the jittered ones come on top
    LimitJudge(const ControlMeshData& data, SchemeKind scheme, std::uint64_t samples = 200'000);
    ~LimitJudge();

    double diagonal() const { return diagonal_; }  ///< of the limit surface's bounding box: the unit of tolerances

    /// Largest distance from the limit surface to the mesh, absolute.
    /// @param enough  stop as soon as a distance exceeds it (the result is then some distance above it)
    double limit_to_mesh(const NearestTriangle& mesh, double enough = std::numeric_limits<double>::infinity()) const;

    /// Largest distance from the mesh to the limit surface, absolute: at least `samples` points spread over the
    /// triangles by area, every vertex, edge midpoint and centre among them; each one's nearest point of the sampled
    /// surface, then a descent on the surface itself for all that can be the largest: in every patch that has a
    /// sampled triangle near enough, from several starts. Every distance is to a point of the surface, so what is
    /// stated is never too small; it is too large only where all descents miss the nearest point.
    double mesh_to_limit(const std::vector<Vec3d>& points, const std::vector<std::array<std::uint32_t, 3>>& triangles,
                         std::uint64_t samples = 200'000) const;

    /// The largest normal component of the distance, at corresponding parameters, between Bfr's surface at these
    /// levels and the judge's.
    double own_error(const ControlMeshData& data, SchemeKind scheme, BfrLevels levels) const;

  private:
    struct Surfaces;
    struct Foot;
    Foot start_at(const NearestTriangle::Hit& hit, const Vec3d& point) const;
    void descend(Foot& foot, const Vec3d& point, double enough) const;
    double distance_to_limit(const Vec3d& point, const NearestTriangle::Hit& nearest, double enough) const;

    std::unique_ptr<Surfaces> surfaces_;
    std::vector<Vec3d> grid_, jittered_;
    std::vector<std::uint32_t> grid_patch_;      ///< per triangle of the sampled surface
    std::vector<std::array<float, 2>> grid_uv_;  ///< per grid point, in its patch
    std::unique_ptr<NearestTriangle> sampled_;   ///< the grid as triangles
    double sampled_error_ = 0;                   ///< how far the jittered points are from it
    int intervals_ = 1;                          ///< of the grid, on each side of a patch
    double diagonal_ = 0;
};

}  // namespace tetrakis::bench
