#pragma once

#include "../../hier/base/vec.hpp"

#include <span>
#include <vector>

namespace tetrakis::detail {

/// A face of a mesh laid flat: its corners dropped onto the plane across its mean normal.
class ConvexFace {
  public:
    explicit ConvexFace(std::span<const Vec3d> corners);

    /// Whether the corners are those of a convex polygon, in their order. What follows needs it.
    bool convex() const { return convex_; }
    /// How far the corners are from the plane at most; no triangulation of them is farther from the flat polygon, point
    /// over point.
    double height() const { return height_; }
    double distance(const Vec3d& p) const;
    const Vec3d& normal() const { return normal_; }
    std::span<const Vec3d> corners() const { return corner_; }  ///< dropped onto the plane
    double above(const Vec3d& p) const { return glm::dot(normal_, p - corner_[0]); }
    /// In the plane, away from the line of the side from corner i to the next one, to the inner side.
    Vec3d inward(std::size_t i) const {
        return glm::normalize(glm::cross(normal_, corner_[(i + 1) % corner_.size()] - corner_[i]));
    }
    /// From the flat side from corner i to the next one.
    double side_distance(const Vec3d& p, std::size_t i) const;
    /// The same of where p is dropped onto the plane.
    double side_distance_in_plane(const Vec3d& p, std::size_t i) const;

  private:
    bool turns_once() const;

    std::vector<Vec3d> corner_;
    Vec3d normal_{0};
    double height_ = 0;
    bool convex_ = false;
};

}  // namespace tetrakis::detail
