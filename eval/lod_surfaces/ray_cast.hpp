#pragma once

#include "surface.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

namespace tetrakis::detail {

/// A ray, and its first hit among the triangles that were tested so far.
class RayCast {
  public:
    /// @param roots  of what the ray is cast at. The origin is moved near them: from far away triangles lose digits.
    RayCast(const Vec3d& origin, const Vec3d& direction, double farthest, const Box3d& roots)
        : origin_(origin),
          length_(glm::length(direction)),
          direction_(direction / length_),
          farthest_(farthest),
          first_(farthest * length_) {
        begin_ = -entry(roots.centre(), roots.upper - roots.lower).value_or(0);  // a box of twice their sides
        origin_ -= begin_ * direction_;
        // Rounded up: hit() limits the result.
        first_ += begin_ + k_rounding * (std::abs(first_) + std::abs(begin_));
    }

    /// Whether origin, direction and farthest point are such that there can be a hit.
    bool is_valid() const {
        constexpr double k_shortest = 1e-100, k_longest = 1e100;
        return std::isfinite(origin_.x + origin_.y + origin_.z) && length_ >= k_shortest && length_ <= k_longest &&
               farthest_ >= 0;
    }
    const Vec3d& direction() const { return direction_; }
    std::optional<lod::SurfaceHit> hit() const {
        if (!found_) return {};
        return lod::SurfaceHit{std::min((first_ - begin_) / length_, farthest_), unit_or_zero(across_)};
    }
    /// Whether the ray is in a box before the first hit.
    bool enters(const Vec3d& center, const Vec3d& half_sides) const { return entry(center, half_sides).has_value(); }
    void meet(const Vec3d& a, const Vec3d& b, const Vec3d& c) {
        // Which side of each edge the ray passes on; on an edge both triangles are met.
        const Vec3d pa = a - origin_, pb = b - origin_, pc = c - origin_;
        const double u = glm::dot(direction_, glm::cross(pb, pc)), v = glm::dot(direction_, glm::cross(pc, pa)),
                     w = glm::dot(direction_, glm::cross(pa, pb)), sum = u + v + w;
        if (sum == 0 || std::min({u, v, w}) * std::max({u, v, w}) < 0) return;
        const double t = glm::dot(u * pa + v * pb + w * pc, direction_) / sum;
        if (!(t >= begin_ && t <= first_)) return;
        first_ = t;
        across_ = glm::cross(b - a, c - a);
        found_ = true;
    }

  private:
    /// Way to where the ray enters a box, if before the first hit.
    std::optional<double> entry(const Vec3d& center, const Vec3d& half_sides) const {
        // Larger boxes, so that triangles at a box's side are met in spite of rounding.
        const Vec3d size = glm::abs(center) + half_sides + glm::abs(origin_);
        const double room = k_rounding * (size.x + size.y + size.z);
        double begin = begin_, end = first_;
        for (int axis = 0; axis < 3; ++axis) {
            const double off = center[axis] - origin_[axis], half = half_sides[axis] + room;
            if (direction_[axis] == 0) {
                if (std::abs(off) > half) return {};
                continue;
            }
            const double a = (off - half) / direction_[axis], b = (off + half) / direction_[axis];
            begin = std::max(begin, std::min(a, b));
            end = std::min(end, std::max(a, b));
        }
        return begin <= end ? std::optional(begin) : std::nullopt;
    }

    static constexpr double k_rounding = 0x1p-48;

    Vec3d origin_;
    double length_;  // of the direction as it was given
    Vec3d direction_;
    double farthest_;           // in lengths of the direction
    double begin_ = 0, first_;  // ways from origin_: to the ray's begin; to the first hit, or the farthest allowed
    Vec3d across_{};            // the first triangle's normal, of any length
    bool found_ = false;
};

}  // namespace tetrakis::detail
