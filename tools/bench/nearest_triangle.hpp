#pragma once

#include "../../hier/base/vec.hpp"

#include <embree3/rtcore.h>

#include <array>
#include <cstdint>
#include <limits>
#include <vector>

namespace tetrakis::bench {

/// Nearest point on triangles: candidates from Embree's hierarchy in float, distances in double. The judge's own,
/// so that no error of the library's measurement can hide one of its tessellation.
class NearestTriangle {
  public:
    struct Hit {
        std::uint32_t triangle = 0xFFFF'FFFFu;
        double distance = std::numeric_limits<double>::infinity();
        Vec3d weights{0.0};  ///< barycentric, of the nearest point
    };

    /// Keeps references to neither argument.
    NearestTriangle(std::vector<Vec3d> points, std::vector<std::array<std::uint32_t, 3>> triangles);
    ~NearestTriangle();
    NearestTriangle(const NearestTriangle&) = delete;
    NearestTriangle& operator=(const NearestTriangle&) = delete;

    /// @param within  a distance that is known to suffice; the hit is none where nothing is nearer
    Hit nearest(const Vec3d& point, double within = std::numeric_limits<double>::infinity()) const;
    /// All triangles that are no farther than `radius`, nearest first; those as near by their number.
    std::vector<Hit> within(const Vec3d& point, double radius) const;
    const std::array<std::uint32_t, 3>& triangle(std::uint32_t t) const { return triangles_[t]; }

  private:
    struct Search;
    struct Gathering;
    static bool candidate(RTCPointQueryFunctionArguments* arguments);
    static bool gather(RTCPointQueryFunctionArguments* arguments);
    Hit nearest_on(std::uint32_t triangle, const Vec3d& point) const;
    template <class Query>
    void query(const Vec3d& point, double radius, RTCPointQueryFunction function, Query& query) const;

    std::vector<Vec3d> points_;
    std::vector<std::array<std::uint32_t, 3>> triangles_;
    Vec3d centre_{0.0};
    double scale_ = 1;  ///< to Embree's frame, where the mesh lies within [-1, 1]
    RTCDevice device_ = nullptr;
    RTCScene scene_ = nullptr;
};

/// Barycentric weights of the point of triangle a, b, c that is nearest to p.
Vec3d nearest_weights(const Vec3d& p, const Vec3d& a, const Vec3d& b, const Vec3d& c);

}  // namespace tetrakis::bench
