#pragma once

#include "../../hier/base/vec.hpp"

#include <array>
#include <cstddef>

namespace tetrakis::detail {

inline Vec2d mix(const Vec2d& a, const Vec2d& b, double t) { return a + t * (b - a); }
inline std::array<double, 3> mix(const std::array<double, 3>& a, const std::array<double, 3>& b, double t) {
    return {a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1]), a[2] + t * (b[2] - a[2])};
}

template <class Point>
struct LabelledTriangle {
    std::array<Point, 3> at{};
    std::array<int, 3> edge{-1, -1, -1};  ///< that side k (corner k to k + 1) lies on, or -1
};

/// A convex polygon cut from a triangle by some lines. It knows which of its sides lie on edges of something else.
/// @tparam Point  has mix(a, b, t), the point a + t (b - a)
template <class Point>
class LabelledPolygon {
  public:
    LabelledPolygon() = default;
    LabelledPolygon(const LabelledTriangle<Point>& whole) : size_(3) {
        for (std::size_t k = 0; k < 3; ++k) corner_[k] = {whole.at[k], whole.edge[k]};
    }

    /// The part where value(point), an affine function, is not negative.
    template <class Value>
    LabelledPolygon clipped(Value&& value) const {
        LabelledPolygon out;
        for (std::size_t i = 0; i < size_; ++i) {
            const Corner &a = corner_[i], &b = corner_[(i + 1) % size_];
            const double va = value(a.at), vb = value(b.at);
            if (va >= 0) out.corner_[out.size_++] = {a.at, va == 0 && vb < 0 ? -1 : a.edge};
            if ((va > 0 && vb < 0) || (va < 0 && vb > 0))
                out.corner_[out.size_++] = {mix(a.at, b.at, va / (va - vb)), va > 0 ? -1 : a.edge};
        }
        return out;
    }
    /// With map(point), which keeps the order of corners, in place of each point.
    template <class Map>
    LabelledPolygon mapped(Map&& map) const {
        LabelledPolygon out = *this;
        for (std::size_t i = 0; i < size_; ++i) out.corner_[i].at = map(corner_[i].at);
        return out;
    }
    bool empty() const { return size_ < 3; }
    std::size_t size() const { return size_; }
    const Point& corner(std::size_t i) const { return corner_[i].at; }
    /// That the side from corner i to the next one lies on, or -1.
    int edge(std::size_t i) const { return corner_[i].edge; }
    /// Calls take(LabelledTriangle) for triangles that it is made of.
    template <class Take>
    void for_each_triangle(Take&& take) const {
        for (std::size_t i = 1; i + 1 < size_; ++i)
            take(LabelledTriangle<Point>{
                {corner_[0].at, corner_[i].at, corner_[i + 1].at},
                {i == 1 ? corner_[0].edge : -1, corner_[i].edge, i + 2 == size_ ? corner_[i + 1].edge : -1}});
    }

  private:
    struct Corner {
        Point at;
        int edge;
    };
    static constexpr std::size_t k_most = 8;  ///< of a triangle cut by five lines

    std::array<Corner, k_most> corner_;
    std::size_t size_ = 0;
};

/// What the quarter (x, y) of a quad has of a polygon in it, in lengths of the quarter's sides.
inline LabelledPolygon<Vec2d> in_quarter(const LabelledPolygon<Vec2d>& whole, int x, int y) {
    return whole.clipped([&](const Vec2d& p) { return (2 * x - 1) * (p.x - 0.5); })
        .clipped([&](const Vec2d& p) { return (2 * y - 1) * (p.y - 0.5); })
        .mapped([&](const Vec2d& p) { return 2.0 * p - Vec2d(x, y); });
}

}  // namespace tetrakis::detail
