#pragma once

#include "tetrakis/hier/vec.hpp"

#include <array>
#include <cstddef>
#include <initializer_list>

namespace tetrakis::detail {

/// A convex polygon in the plane, of at most eight corners: what a rectangle cuts out of a triangle, and smaller
/// rectangles out of that (a side of the triangle or of the rectangle each has one).
class ShortPolygon {
  public:
    ShortPolygon() = default;
    ShortPolygon(std::initializer_list<Vec2d> corners) {
        for (const Vec2d& p : corners) add(p);
    }
    std::size_t size() const { return size_; }
    const Vec2d& operator[](std::size_t i) const { return corner_[i]; }
    void add(const Vec2d& p) { corner_[size_++] = p; }

    /// What is left within a rectangle.
    ShortPolygon within(const Vec2d& low, const Vec2d& high) const;
    /// Signed, counter-clockwise positive.
    double area() const;
    /// Whether it is what rounding makes of a corner or side that it shares with a rectangle of this size.
    bool is_nothing_beside(const Vec2d& size) const { return !(area() > k_no_share * size.x * size.y); }

  private:
    static constexpr double k_no_share = 1e-12;
    std::array<Vec2d, 8> corner_{};
    std::size_t size_ = 0;
};

/// A straight line from point to point, likewise.
struct ShortSegment {
    Vec2d from{0}, to{0};

    ShortSegment within(const Vec2d& low, const Vec2d& high) const;
    bool is_nothing_beside(const Vec2d& size) const {
        constexpr double k_no_share = 1e-12;
        return !(glm::length(to - from) > k_no_share * glm::length(size));
    }
};

}  // namespace tetrakis::detail
