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

/// The 2 (n + k) points around a cell whose corners are smooth and interior: (0, 0) of valence n, (1, 1) of valence k,
/// the other two regular (Stam 1998 has k = 4). Cells of the first step have their face's centre at (1, 1); below it
/// one corner at most is extraordinary, and it is (0, 0).
///
/// points: [0] the corner; [1 + 2i] its edge neighbours e_i and [2 + 2i] the face points f_i between e_i and e_(i+1),
/// counter-clockwise, e_0 = (1, 0), f_0 = (1, 1), e_1 = (0, 1); [2n + 1 ..] those beyond: (2, -1), the far corner's own
/// ring from (2, 0) to (0, 2), and (-1, 2).
struct QuadStar : PoolNew {
    int valence = 0;
    int far_valence = 4;
    Vec3d limit{0};  ///< limit position of the corner, the same at every level
    StarPoints points;

    static std::size_t point_count(int valence, int far_valence = 4) {
        return 2 * (static_cast<std::size_t>(valence) + static_cast<std::size_t>(far_valence));
    }
    void resize(int n, int k = 4) {
        valence = n, far_valence = k;
        points.resize(point_count(n, k));
    }
    const Vec3d& edge(int i) const { return points[static_cast<std::size_t>(1 + 2 * wrap(i))]; }
    const Vec3d& face(int i) const { return points[static_cast<std::size_t>(2 + 2 * wrap(i))]; }
    const Vec3d& outer(int i) const { return points[static_cast<std::size_t>(2 * valence + 1 + i)]; }
    /// The ring of (1, 1), in the frame turned by half: its e_0 = (0, 1), f_0 = (0, 0), e_1 = (1, 0).
    const Vec3d& far_edge(int i) const {
        const int j = i < 0 ? i + far_valence : i % far_valence;
        return j == 0 ? edge(1) : j == 1 ? edge(0) : outer(2 * j - 2);
    }
    const Vec3d& far_face(int i) const {
        const int j = i < 0 ? i + far_valence : i % far_valence;
        return j == 0 ? points[0] : outer(2 * j - 1);
    }
    bool regular() const { return valence == 4 && far_valence == 4; }
    /// The points of a regular cell as a net.
    void put(Net16& net) const;
    std::size_t memory_bytes() const { return sizeof(QuadStar) + points.outside_bytes(); }
    int wrap(int i) const { return i < 0 ? i + valence : (i < valence ? i : i % valence); }
    /// Sets the limit from the points (MASKS, Catmull-Clark at an interior vertex).
    void find_limit();
    /// Limit position of a corner, (0, 0) (1, 0) (1, 1) (0, 1).
    Vec3d corner_limit(int corner) const;
};

/// One Catmull-Clark step: the four quarters in the order of the corners, in the star's frame, as nets; as stars in the
/// frames of their own corners where (0, 0) or (1, 1) is extraordinary.
struct StarQuarters {
    std::array<Net16, 4> net;
    QuadStar far;  ///< where far_valence is not 4
};
/// @param near  the quarter at (0, 0), where valence is not 4
void subdivide(const QuadStar& star, QuadStar& near, StarQuarters& quarters);

}  // namespace tetrakis::detail
