#pragma once

#include "surface.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

namespace tetrakis::detail {

/// A ray, and its first hit among the triangles that were tested so far.
class RayCast {
  public:
    RayCast(const Vec3d& origin, const Vec3d& direction, double farthest)
        : origin_(origin), direction_(direction), first_(farthest) {}

    const Vec3d& direction() const { return direction_; }
    std::optional<lod::SurfaceHit> hit() const {
        return found_ ? std::optional(lod::SurfaceHit{skipped_ + first_, unit_or_zero(across_)}) : std::nullopt;
    }
    /// Whether the ray is in a box before the first hit.
    bool enters(const Vec3d& center, const Vec3d& half_sides) const { return entry(center, half_sides).has_value(); }
    /// Moves the origin to where the ray enters a box that holds all triangles: from far away they lose digits.
    void skip_to(const Vec3d& center, const Vec3d& half_sides) {
        const double begin = entry(center, half_sides).value_or(0);
        origin_ += begin * direction_;
        first_ -= begin;
        skipped_ += begin;
    }
    void meet(const Vec3d& a, const Vec3d& b, const Vec3d& c) {
        // Which side of each edge the ray passes on; on an edge both triangles are met.
        const Vec3d pa = a - origin_, pb = b - origin_, pc = c - origin_;
        const double u = glm::dot(direction_, glm::cross(pb, pc)), v = glm::dot(direction_, glm::cross(pc, pa)),
                     w = glm::dot(direction_, glm::cross(pa, pb)), sum = u + v + w;
        if (sum == 0 || std::min({u, v, w}) * std::max({u, v, w}) < 0) return;
        const double t = glm::dot(u * pa + v * pb + w * pc, direction_) / (sum * glm::dot(direction_, direction_));
        if (!(t >= 0 && t <= first_)) return;
        first_ = t;
        across_ = glm::cross(b - a, c - a);
        found_ = true;
    }

  private:
    /// Parameter at which the ray enters a box, if before the first hit.
    std::optional<double> entry(const Vec3d& center, const Vec3d& half_sides) const {
        double begin = 0, end = first_;
        for (int axis = 0; axis < 3; ++axis) {
            const double off = center[axis] - origin_[axis], half = half_sides[axis];
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

    Vec3d origin_, direction_;
    double skipped_ = 0, first_;  // parameters: of origin_; of the first hit, or the largest allowed, from there
    Vec3d across_{};              // the first triangle's normal, of any length
    bool found_ = false;
};

}  // namespace tetrakis::detail
