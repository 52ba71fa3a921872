#pragma once

#include "../../hier/base/vec.hpp"
#include "mesh_sliding.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace tetrakis::detail {

/// Rounding margin: a value not above limit / stretch is, times the stretch, not above the limit.
inline constexpr double k_stretch_rounding = 1 + 1e-15;

/// Distances to one triangle and to its edges (edge k from corner k to the next). Except for rounding they are never
/// too small, not even for slivers.
///
/// Points are given in the triangle's own frame: the barycentrics 1 and 2 of the foot on its plane, and the height over
/// the plane. A sliver has no reliable normal: its frame is space relative to corner 0. Both frames are affine, so
/// means of points may be taken in the frame.
///
/// With sliding edges, to_face() and to_edge() are bounds on the errors of EdgeSliding, divided by stretch(). The
/// largest value at the ends of a line bounds the error on the whole line.
class TriangleDistance {
  public:
    TriangleDistance() = default;
    /// For slivers, `sliding` is ignored.
    explicit TriangleDistance(const std::array<Vec3d, 3>& corners, const EdgeSliding& sliding = {});

    Vec3d local(const Vec3d& p) const {
        const Vec3d d = p - corners_[0];
        return sliver_ ? d : Vec3d(glm::dot(to_b1_, d), glm::dot(to_b2_, d), glm::dot(normal_, d));
    }
    /// Whether edge k slides.
    bool slides(std::size_t k) const { return slides_ && sliding_.edge[k]; }
    /// Factor by which the errors have been divided; 1 if no edge slides.
    double stretch() const { return stretch_; }

    double to_face(const Vec3d& local) const {
        if (slides_) return sliding(local);
        if (!sliver_ && local.x >= 0 && local.y >= 0 && local.x + local.y <= 1) return std::abs(local.z);
        return std::sqrt(squared_beside(local) + (sliver_ ? 0 : local.z * local.z));
    }
    double to_edge(const Vec3d& local, std::size_t k) const {
        return slides(k) ? sliding_over(local, k) : std::sqrt(squared_to_edge(local, k));
    }

  private:
    /// Barycentric of the corner opposite edge k.
    static double opposite(const Vec3d& local, std::size_t k) {
        return k == 0 ? local.y : (k == 1 ? 1 - local.x - local.y : local.x);
    }
    /// Barycentric of corner k + 1.
    static double forward(const Vec3d& local, std::size_t k) {
        return k == 0 ? local.x : (k == 1 ? local.y : 1 - local.x - local.y);
    }
    /// Position of the foot along edge k: 0 at the edge's start, 1 at its end.
    double place(const Vec3d& local, std::size_t k) const { return forward(local, k) + foot_[k] * opposite(local, k); }
    /// Whether the foot, at distance `off` from the line of edge k, lies in the flaps there.
    bool in_flaps(const Vec3d& local, std::size_t k, double off) const {
        const double along = place(local, k);
        return off <= sliding_.flap[k] * (std::min(along, 1 - along) * length_[k]);
    }
    double sliding(const Vec3d& local) const;
    double sliding_over(const Vec3d& local, std::size_t k) const;
    Vec3d position(const Vec3d& local) const;
    /// Squared distance of the foot from the triangle; for a sliver, of the point itself.
    double squared_beside(const Vec3d& local) const;
    double squared_to_edge(const Vec3d& local, std::size_t k) const {
        if (!sliver_) {
            const double along = place(local, k);
            if (along >= 0 && along <= 1) {
                const double beside = opposite(local, k) * height_[k];
                return local.z * local.z + beside * beside;
            }
        }
        return squared_beyond_edge(local, k);
    }
    double squared_beyond_edge(const Vec3d& local, std::size_t k) const;

    std::array<Vec3d, 3> corners_;
    Vec3d normal_{0}, to_b1_{0}, to_b2_{0};
    std::array<double, 3> height_{};  ///< of the triangle over edge k
    std::array<double, 3> foot_{};    ///< place() of the corner opposite edge k
    bool sliver_ = true, slides_ = false;
    EdgeSliding sliding_;
    double fold_ = 0, stretch_ = 1;
    std::array<double, 3> length_{};  ///< of edge k, if any edge slides
};

}  // namespace tetrakis::detail
