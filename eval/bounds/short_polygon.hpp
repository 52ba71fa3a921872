#pragma once

#include "../../hier/base/vec.hpp"

#include <array>
#include <cassert>
#include <cstddef>
#include <initializer_list>
#include <span>
#include <vector>

namespace tetrakis::detail {

/// A convex polygon in the plane, of few corners: what rectangles and their diagonals cut out of a triangle, or out of
/// the polygon around some points. Also, with two corners, a segment.
class ShortPolygon {
  public:
    ShortPolygon() = default;
    ShortPolygon(std::initializer_list<Vec2d> corners) : ShortPolygon(std::span(corners.begin(), corners.size())) {}
    explicit ShortPolygon(std::span<const Vec2d> corners) {
        for (const Vec2d& p : corners) add(p);
    }
    /// The smallest that holds all points.
    static ShortPolygon around(std::vector<Vec2d> points);

    std::size_t size() const { return size_; }
    const Vec2d& operator[](std::size_t i) const { return corner_[i]; }
    void add(const Vec2d& p) {
        assert(size_ < corner_.size());
        corner_[size_++] = p;
    }

    /// What is left where normal . p is at least this.
    ShortPolygon beyond(const Vec2d& normal, double least) const;
    /// What is left within a rectangle.
    ShortPolygon within(const Vec2d& low, const Vec2d& high) const;
    /// Signed, counter-clockwise positive.
    double area() const;
    /// Whether it is what rounding makes of a corner or side that it shares with a rectangle of this size.
    bool is_nothing_beside(const Vec2d& size) const;

  private:
    // Of a triangle and a rectangle seven; of the points around a bent one three times as many, and two cuts more.
    std::array<Vec2d, 24> corner_{};
    std::size_t size_ = 0;
};

}  // namespace tetrakis::detail
