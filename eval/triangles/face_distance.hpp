#pragma once

#include "../../hier/base/vec.hpp"
#include "mesh_sliding.hpp"

#include <algorithm>
#include <span>
#include <vector>

namespace tetrakis::detail {

/// Rounding margin: a value not above limit / stretch is, times the stretch, not above the limit.
inline constexpr double k_stretch_rounding = 1 + 1e-15;

/// Distances to one triangle or flat convex face, and to its edges (edge k from corner k to the next). Except for
/// rounding they are never too small, not even for slivers. A face of more than three corners is flattened: its corners
/// are projected onto the plane perpendicular to the face's mean normal.
///
/// Points are given in the face's own frame: two coordinates in its plane, and the height over it. A sliver of a
/// triangle has no reliable normal: its frame is space relative to corner 0. Both frames are affine, so means of points
/// may be taken in the frame.
///
/// With sliding edges, to_face() and to_edge() are bounds on the errors of EdgeSliding, divided by stretch(). The
/// largest value at the ends of a line bounds the error on the whole line.
class FaceDistance {
  public:
    FaceDistance() = default;
    /// For slivers, `sliding` is ignored.
    explicit FaceDistance(const std::array<Vec3d, 3>& triangle, const EdgeSliding& sliding = {}) {
        set(triangle, sliding);
    }
    /// Distances exist only if the result is convex().
    explicit FaceDistance(std::span<const Vec3d> corners) { set(corners); }
    /// Becomes another face, without allocating memory if the last one had as many corners.
    void set(const std::array<Vec3d, 3>& triangle, const EdgeSliding& sliding);
    void set(std::span<const Vec3d> corners);

    /// Whether the corners in their order are a convex polygon.
    bool convex() const { return convex_; }
    /// Largest distance of a corner from the plane. Every triangulation of the face is that close to the flat polygon,
    /// point over point; twice that if flaps (see EdgeSliding) of at most 45 degrees are unfolded over an edge.
    double height() const { return height_; }
    /// @param fold, flap  of edge k (from corner k to the next), for the triangle there of the face's triangulation
    /// @param normal      unit normal of that triangle
    void set_sliding(std::size_t k, double fold, double flap, const Vec3d& normal);

    Vec3d local(const Vec3d& p) const {
        const Vec3d d = p - corner_[0];
        return sliver_ ? d : Vec3d(glm::dot(x_, d), glm::dot(y_, d), glm::dot(normal_, d));
    }
    /// Whether edge k slides.
    bool slides(std::size_t k) const { return edge_[k].slides; }
    /// Factor by which the errors have been divided; 1 if no edge slides.
    double stretch() const { return stretch_; }

    double to_face(const Vec3d& local) const;
    double to_edge(const Vec3d& local, std::size_t k) const;

    static constexpr std::size_t k_most_points = 28;
    /// Squares of distances by number of the point: to the face, then to edges 0, 1 and 2.
    using Squares = std::array<std::array<double, k_most_points>, 4>;
    /// Whether squares() is defined: for a triangle that neither slides nor is a sliver.
    bool has_squares() const { return has_squares_; }
    /// Squares of to_face() and to_edge() for `count` points in space, several at once.
    /// @param points  their coordinates: all x, all y, all z
    /// @param count   a multiple of 4, at most k_most_points
    void squares(const std::array<const double*, 3>& points, std::size_t count, Squares& out) const;

  private:
    struct Edge {
        Vec2d start{0}, along{0};  ///< in the plane; `along` is of unit length
        double length = 0;
        bool slides = false;
        double fold = 0, flap = 0;

        Vec2d out() const { return {along.y, -along.x}; }
        double outside(const Vec3d& local) const { return glm::dot(Vec2d(local) - start, out()); }
        double place(const Vec3d& local) const { return glm::dot(Vec2d(local) - start, along); }
        /// Squared distance from the edge of a point's foot, which is `off` from the edge's line.
        double squared_distance(const Vec3d& local, double off) const {
            const double at = place(local), beyond = at - std::clamp(at, 0.0, length);
            return off * off + beyond * beyond;
        }
        /// Whether the foot, at distance `off` from the edge's line, lies in the flaps there.
        bool in_flaps(const Vec3d& local, double off) const {
            const double at = place(local);
            return off <= flap * std::min(at, length - at);
        }
    };
    bool turns_once() const;

    std::vector<Vec3d> corner_;  ///< projected
    std::vector<Edge> edge_;
    Vec3d normal_{0}, x_{0}, y_{0};
    double height_ = 0, fold_ = 0, stretch_ = 1;
    bool convex_ = false, sliver_ = false, has_squares_ = false;
};

}  // namespace tetrakis::detail
