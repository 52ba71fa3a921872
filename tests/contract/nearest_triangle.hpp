#pragma once

#include "../../hier/base/vec.hpp"

#include <array>
#include <cstdint>
#include <limits>
#include <vector>

namespace tetrakis::contract {

/// Nearest points on triangles, by a tree of boxes, in doubles. It is the judges' own, so that no error of the
/// library's measurement can hide one of its tessellation.
class NearestTriangle {
  public:
    static constexpr double k_infinity = std::numeric_limits<double>::infinity();
    struct Hit {
        std::uint32_t triangle = 0xFFFF'FFFFu;
        double distance = k_infinity;
        Vec3d weights{0.0};  ///< barycentric, of the nearest point
    };

    NearestTriangle(std::vector<Vec3d> points, std::vector<std::array<std::uint32_t, 3>> triangles);

    /// @param below  the hit has no triangle, and this as its distance, where nothing is nearer
    Hit nearest(const Vec3d& p, double below = k_infinity) const;
    double distance(const Vec3d& p) const { return nearest(p).distance; }
    /// All triangles that are no farther than `radius`, nearest first; those as near by their number.
    std::vector<Hit> within(const Vec3d& p, double radius) const;
    const std::array<std::uint32_t, 3>& triangle(std::uint32_t t) const { return triangles_[t]; }

  private:
    struct Node {
        Box3d box;
        std::uint32_t first = 0, count = 0;  ///< a leaf's triangles; count 0: its children are first and first + 1
    };
    void split(std::uint32_t node, std::uint32_t first, std::uint32_t count, const std::vector<Vec3d>& centres);
    Hit hit(std::uint32_t triangle, const Vec3d& p) const;
    /// Calls take(hit) for triangles, near ones first, whose box is no farther than `radius`, which `take` may lower.
    template <class Take>
    void visit(const Vec3d& p, const double& radius, const Take& take) const;

    std::vector<Vec3d> points_;
    std::vector<std::array<std::uint32_t, 3>> triangles_;
    std::vector<std::uint32_t> order_;
    std::vector<Node> nodes_;
};

}  // namespace tetrakis::contract
