#pragma once

#include "../../hier/base/vec.hpp"
#include "edge_slack.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace tetrakis::detail {

/// So that what is not above a limit divided by a stretch is not above the limit when multiplied by it.
inline constexpr double k_stretch_rounding = 1 + 1e-15;

/// Distances to one triangle and to its edges (edge k from corner k to the next). Rounding aside they are never too
/// small, slivers included.
///
/// Points are given in the triangle's own frame: barycentrics of corners 1 and 2 of the foot on the plane, and the
/// height over it. A sliver has no normal to rely on: its frame is the space around corner 0. Either is affine, so that
/// means of points may be taken in the frame.
///
/// With slack at some edges (EdgeSlack) to_face() and to_edge() are bounds on the errors there, divided by
/// stretch(): like distances they are at most the distance from any point of the triangle or the edge, and differ
/// between two points by at most their distance. At the ends of a line they bound a convex function on all of it.
class TriangleDistance {
  public:
    TriangleDistance() = default;
    explicit TriangleDistance(const std::array<Vec3d, 3>& corners);
    TriangleDistance(const std::array<Vec3d, 3>& corners, const EdgeSlack& slack) : TriangleDistance(corners) {
        set_slack(slack);
    }

    bool sliver() const { return sliver_; }
    /// Of no length for slivers.
    const Vec3d& normal() const { return normal_; }
    /// Least height of the triangle; 0 for slivers.
    double least_height() const { return std::min({height_[0], height_[1], height_[2]}); }

    /// What takes a vector to its barycentrics of corners 1 and 2; of no length for slivers.
    const Vec3d& to_b1() const { return to_b1_; }
    const Vec3d& to_b2() const { return to_b2_; }

    Vec3d local(const Vec3d& p) const { return local_vector(p - corners_[0]); }
    Vec3d local_vector(const Vec3d& d) const {
        return sliver_ ? d : Vec3d(glm::dot(to_b1_, d), glm::dot(to_b2_, d), glm::dot(normal_, d));
    }

    /// The triangle's own point with these barycentrics of corners 1 and 2, in its frame.
    Vec3d inside(double b1, double b2) const {
        return sliver_ ? b1 * (corners_[1] - corners_[0]) + b2 * (corners_[2] - corners_[0]) : Vec3d(b1, b2, 0);
    }

    /// Height over the plane and squared distance of the foot from the triangle; the squared distance is the sum of
    /// squares. Of slivers all counts as distance of the foot.
    struct Split {
        double height, squared_beside;
    };
    Split split(const Vec3d& local) const {
        if (!sliver_ && local.x >= 0 && local.y >= 0 && local.x + local.y <= 1) return {std::abs(local.z), 0};
        return split_beside(local);
    }
    /// Of a point over the triangle: how far its foot may move without leaving it.
    double margin(const Vec3d& local) const {
        if (sliver_) return 0;
        return std::min({local.y * height_[0], (1 - local.x - local.y) * height_[1], local.x * height_[2]});
    }
    /// From here on errors are those of EdgeSlack; slivers take no slack.
    void set_slack(const EdgeSlack& slack);
    bool has_slack() const { return has_slack_; }
    /// Whether edge k has slack.
    bool slides(std::size_t k) const { return has_slack_ && slack_.fold[k] >= 0; }
    /// What the errors have been divided by; 1 without slack.
    double stretch() const { return stretch_; }

    double to_face(const Vec3d& local) const {
        if (has_slack_) return sliding(local, 0, 0);
        const Split s = split(local);
        return s.squared_beside == 0 ? s.height : std::sqrt(s.height * s.height + s.squared_beside);
    }
    /// With slack: to_face() of any point whose height differs by at most `height`, and whose foot lies within
    /// `beside`.
    double around(const Vec3d& local, double height, double beside) const { return sliding(local, height, beside); }
    double to_edge(const Vec3d& local, std::size_t k) const {
        if (slides(k)) return sliding_over(local, k, 0, 0);
        return std::sqrt(squared_to_edge(local, k));
    }
    /// to_edge() of any point that is at most `whole` away, and whose height differs by at most `height`.
    double around_edge(const Vec3d& local, std::size_t k, double height, double whole) const {
        return slides(k) ? sliding_over(local, k, std::min(height, whole), whole) : to_edge(local, k) + whole;
    }
    /// Without slack.
    double squared_to_edge(const Vec3d& local, std::size_t k) const {
        if (!sliver_) {
            const double over = opposite(local, k, 1), place = forward(local, k, 1) + foot_[k] * over;
            if (place >= 0 && place <= 1) {
                const double beside = over * height_[k];
                return local.z * local.z + beside * beside;
            }
        }
        return squared_beyond_edge(local, k);
    }

    /// Of a vector (local_vector()) in a triangle that is no sliver: along edge k, in lengths of the edge; and in the
    /// plane away from the triangle over edge k, in the unit of the model.
    double along(const Vec3d& v, std::size_t k) const { return forward(v, k, 0) + foot_[k] * opposite(v, k, 0); }
    double outward(const Vec3d& v, std::size_t k) const { return -opposite(v, k, 0) * height_[k]; }
    /// The latter of a point (local()).
    double outward_of(const Vec3d& p, std::size_t k) const { return -opposite(p, k, 1) * height_[k]; }

  private:
    /// Barycentric of the corner opposite edge k, for a point (one = 1) or a vector (one = 0).
    static double opposite(const Vec3d& local, std::size_t k, double one) {
        return k == 0 ? local.y : (k == 1 ? one - local.x - local.y : local.x);
    }
    /// Barycentric of corner k + 1.
    static double forward(const Vec3d& local, std::size_t k, double one) {
        return k == 0 ? local.x : (k == 1 ? local.y : one - local.x - local.y);
    }
    double sliding(const Vec3d& local, double height, double beside) const;
    double sliding_over(const Vec3d& local, std::size_t k, double height, double whole) const;
    Vec3d position(const Vec3d& local) const;
    Split split_beside(const Vec3d& local) const;
    double squared_beyond_edge(const Vec3d& local, std::size_t k) const;

    std::array<Vec3d, 3> corners_;
    Vec3d normal_{0}, to_b1_{0}, to_b2_{0};
    std::array<double, 3> height_{};  ///< over edge k
    std::array<double, 3>
        foot_{};  ///< of the corner opposite edge k: place on the edge, 0 at its start and 1 at its end
    bool sliver_ = true, has_slack_ = false;
    EdgeSlack slack_;
    double fold_ = 0, stretch_ = 1;
    std::array<double, 3> length_{};  ///< of edge k, with slack
};

}  // namespace tetrakis::detail
