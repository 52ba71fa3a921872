#pragma once

#include "../../hier/base/memory.hpp"
#include "bicubic.hpp"

#include <array>
#include <memory>

namespace tetrakis::detail {

/// The points of a star: in place up to valence 8.
class StarPoints {
  public:
    void resize(std::size_t size) {
        size_ = size;
        if (size > inside_.size()) outside_ = std::make_unique<Vec3d[]>(size);
    }
    std::size_t size() const { return size_; }
    std::size_t outside_bytes() const { return outside_ ? size_ * sizeof(Vec3d) : 0; }
    Vec3d* data() { return outside_ ? outside_.get() : inside_.data(); }
    const Vec3d* data() const { return outside_ ? outside_.get() : inside_.data(); }
    Vec3d& operator[](std::size_t i) { return data()[i]; }
    const Vec3d& operator[](std::size_t i) const { return data()[i]; }
    const Vec3d* begin() const { return data(); }
    const Vec3d* end() const { return data() + size_; }

  private:
    std::size_t size_ = 0;
    std::array<Vec3d, 24> inside_;
    std::unique_ptr<Vec3d[]> outside_;
};

/// The 2n + 8 points around a cell with one extraordinary, smooth, interior corner of valence n (Stam 1998), in the
/// cell's frame turned so that this corner is (0, 0).
///
/// points: [0] the corner; [1 + 2i] its edge neighbours e_i and [2 + 2i] the face points f_i between e_i and e_(i+1),
/// counter-clockwise, e_0 = (1, 0), f_0 = (1, 1), e_1 = (0, 1); [2n + 1 ..] the outer seven (2,-1) (2,0) (2,1) (2,2)
/// (1,2) (0,2) (-1,2).
struct QuadStar : PoolNew {
    int valence = 0;
    float reach = 0;  ///< no point is farther from `limit`, so nor is the surface of the cell
    Vec3d limit{0};   ///< limit position of the corner, the same at every level
    StarPoints points;

    static std::size_t point_count(int valence) { return 2 * static_cast<std::size_t>(valence) + 8; }
    const Vec3d& edge(int i) const { return points[static_cast<std::size_t>(1 + 2 * wrap(i))]; }
    const Vec3d& face(int i) const { return points[static_cast<std::size_t>(2 + 2 * wrap(i))]; }
    const Vec3d& outer(int i) const { return points[static_cast<std::size_t>(2 * valence + 1 + i)]; }
    std::size_t memory_bytes() const { return sizeof(QuadStar) + points.outside_bytes(); }
    int wrap(int i) const { return i < 0 ? i + valence : (i < valence ? i : i % valence); }
    /// Sets the limit from the points (MASKS, Catmull-Clark at an interior vertex), and the reach.
    void find_limit();
    void find_reach();
};

/// One Catmull-Clark step: the cell at the extraordinary corner (again a star) and the nets of the three regular
/// quarters, in the star's frame: regular[0] = (1, 0), [1] = (1, 1), [2] = (0, 1).
void subdivide(const QuadStar& star, QuadStar& child, std::array<Net16, 3>& regular);

}  // namespace tetrakis::detail
