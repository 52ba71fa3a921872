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

/// Measures triangle meshes against a limit surface, without this library's evaluators. The surface is OpenSubdiv's Bfr
/// in double precision with approximation levels of 10 (k_judge_levels). It is sampled on a grid over each face,
/// corners and edges included, and at one jittered point in each cell of the grid.
class LimitJudge {
  public:
    /// @param samples  least number of grid points; the jittered points are additional
    LimitJudge(const ControlMeshData& data, SchemeKind scheme, std::uint64_t samples = 200'000);
    ~LimitJudge();

    double diagonal() const { return diagonal_; }  ///< of the limit surface's bounding box: the unit of tolerances

    /// Largest distance from the limit surface to the mesh, absolute.
    /// @param enough  stops as soon as a distance exceeds this, and then returns some distance above it
    double limit_to_mesh(const NearestTriangle& mesh, double enough = std::numeric_limits<double>::infinity()) const;

    /// Largest distance from the mesh to the limit surface, absolute. At least `samples` points are spread over the
    /// triangles by area, with all vertices, edge midpoints and centres. A point that can have the largest distance
    /// descends on the surface, from several starts in each patch that is near enough. Distances are to points of the
    /// surface, so they are never too small. They are too large only if all descents miss the nearest point.
    double mesh_to_limit(const std::vector<Vec3d>& points, const std::vector<std::array<std::uint32_t, 3>>& triangles,
                         std::uint64_t samples = 200'000) const;

    /// Largest normal component of the distance, at equal parameters, between Bfr's surface with approximation levels
    /// `levels` and the judge's surface.
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
    double sampled_error_ = 0;                   ///< largest distance of the jittered points from sampled_
    int intervals_ = 1;                          ///< of the grid, on each side of a patch
    double diagonal_ = 0;
};

}  // namespace tetrakis::bench
