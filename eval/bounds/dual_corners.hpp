#pragma once

#include "../../hier/forest/vertex_roots.hpp"

#include <cstdint>
#include <span>
#include <vector>

namespace tetrakis::detail {

/// The points where the roots of vertex quadtrees do not meet in fours: around a face of the mesh of another size, and
/// where a crease ends inside (there is no face, but two ways from one vertex to the other).
class DualCorners {
  public:
    static constexpr std::uint32_t none = 0xFFFF'FFFFu;

    struct Member {
        std::uint32_t root;
        int corner;
    };
    struct Point {
        std::vector<Member> around;  ///< counter-clockwise
        bool closed = true;          ///< the last is beside the first; else a crease lies between
        bool is_face() const { return closed && around.size() > 2; }
    };

    explicit DualCorners(const VertexRoots& roots);

    std::span<const Point> points() const { return points_; }
    /// Number of the point at a corner of a root; `none` where the net is regular: four cells meet, or the surface ends
    /// there, or a crease runs.
    std::uint32_t point(std::uint32_t root, int corner) const { return point_[4 * std::size_t{root} + index(corner)]; }
    /// The point that a cell touches, as a corner of its root; -1: none. One of them, where a root has two.
    int corner_of(const VertexCell& cell) const;

  private:
    static std::size_t index(int corner) { return static_cast<std::size_t>(corner); }
    std::vector<Point> points_;
    std::vector<std::uint32_t> point_;  // 4 per root
};

}  // namespace tetrakis::detail
