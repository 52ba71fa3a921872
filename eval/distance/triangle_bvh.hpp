#pragma once

#include "../../hier/base/run_context.hpp"
#include "../../hier/base/vec.hpp"
#include "../surface/triangle_mesh.hpp"

#include <array>
#include <cstdint>
#include <limits>
#include <memory>
#include <span>
#include <vector>

namespace tetrakis {

/// The point of a triangle mesh nearest to a query point: a + u (b - a) + v (c - a) of the triangle (a, b, c).
struct ClosestPoint {
    static constexpr std::uint32_t k_none = 0xFFFF'FFFFu;
    Vec3d point{0.0};
    double distance = std::numeric_limits<double>::infinity();
    std::uint32_t triangle = k_none;
    double u = 0, v = 0;
    bool found() const { return triangle != k_none; }
};

/// Where a ray meets a triangle mesh: at origin + t direction; u and v are the barycentrics there, as in ClosestPoint.
struct RayHit {
    double t = std::numeric_limits<double>::infinity();
    std::uint32_t triangle = ClosestPoint::k_none;
    double u = 0, v = 0;
    bool found() const { return triangle != ClosestPoint::k_none; }
};

/// Closest points and ray casts on a triangle mesh. Embree finds candidates in float, in a local frame and with radii
/// rounded outward; distances are computed and compared in double. So the closest point is exact to double rounding,
/// even for distances tiny beside the model. It does not depend on the hierarchy: of equal distances the lowest
/// triangle counts. Degenerate triangles count as segments or points. All queries are thread-safe.
class TriangleBvh {
  public:
    /// Keeps references: `positions` and `triangles` must not move or change while this object lives.
    /// @throws Error invalid_input: an index is out of range, or a position used is not finite;
    ///               memory_limit: context.max_memory_bytes would be exceeded (only Embree's memory counts)
    /// Cost: O(T log T), parallel; about 45 bytes a triangle.
    TriangleBvh(std::span<const Vec3d> positions, std::span<const std::array<std::uint32_t, 3>> triangles,
                const RunContext& context = {});
    explicit TriangleBvh(const TriangleMesh& mesh, const RunContext& context = {})
        : TriangleBvh(mesh.positions, mesh.triangles, context) {}
    explicit TriangleBvh(TriangleMesh&&, const RunContext& = {}) = delete;
    ~TriangleBvh();
    TriangleBvh(TriangleBvh&&) noexcept;
    TriangleBvh& operator=(TriangleBvh&&) noexcept;

    std::uint32_t triangle_count() const;
    double longest_side(std::uint32_t triangle) const;
    Box3d bounds() const;                ///< of the positions that triangles use
    std::uint64_t memory_bytes() const;  ///< held by the hierarchy and its float copy of the vertices

    /// The closest point within `max_distance` (inclusive). A known upper bound of the distance makes it much cheaper.
    ClosestPoint closest(const Vec3d& point,
                         double max_distance = std::numeric_limits<double>::infinity()) const noexcept;
    /// All triangles within `distance` of a point, and perhaps some a little farther away, in any order.
    std::vector<std::uint32_t> within(const Vec3d& point, double distance) const;

    /// First hit with t in [t_min, t_max], t_min >= 0, on either side of a triangle. Embree finds the triangle in
    /// float: a ray closer to an edge than 1e-7 of the model may hit the neighbour instead, one right through a vertex
    /// nothing. Then t, u and v are recomputed in double.
    RayHit intersect(const Vec3d& origin, const Vec3d& direction, double t_min = 0,
                     double t_max = std::numeric_limits<double>::infinity()) const noexcept;
    /// Whether the ray meets a triangle at some t in [t_min, t_max].
    bool occluded(const Vec3d& origin, const Vec3d& direction, double t_min = 0,
                  double t_max = std::numeric_limits<double>::infinity()) const noexcept {
        return intersect(origin, direction, t_min, t_max).found();
    }

    /// closest() of many points, in parallel. Consecutive points should be near each other: the triangle inequality
    /// gives each search an upper bound from the one before.
    /// @throws Error invalid_input: the spans differ in size; cancelled
    void closest(std::span<const Vec3d> points, std::span<ClosestPoint> out, const RunContext& context = {}) const;

  private:
    struct State;
    std::unique_ptr<State> state_;
};

/// Closest points for a sequence of query points near each other: the last answer bounds the next distance.
class CoherentClosest {
  public:
    explicit CoherentClosest(const TriangleBvh& bvh) : bvh_(&bvh) {}
    ClosestPoint closest(const Vec3d& point) noexcept;

  private:
    const TriangleBvh* bvh_;
    Vec3d last_point_{0.0};
    double last_distance_ = std::numeric_limits<double>::infinity();
};

}  // namespace tetrakis
