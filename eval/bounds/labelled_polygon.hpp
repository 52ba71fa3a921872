#pragma once

#include "../patches/cell.hpp"

#include <array>
#include <cstddef>

namespace tetrakis::detail {

/// A triangle in a cell, in lengths of its sides.
struct LabelledTriangle {
    std::array<Vec2d, 3> at{};
    std::array<int, 3> edge{-1, -1, -1};  ///< number of the edge that side k (corner k to k + 1) lies on, or -1
};

/// A convex polygon cut from a triangle by some lines. Each side knows the number of the outer edge that it lies on.
class LabelledPolygon {
  public:
    LabelledPolygon() = default;
    LabelledPolygon(const LabelledTriangle& whole) : size_(3) {
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
                out.corner_[out.size_++] = {a.at + va / (va - vb) * (b.at - a.at), va > 0 ? -1 : a.edge};
        }
        return out.empty() ? LabelledPolygon() : out;  // nothing is left of a side that lies on the line
    }
    /// The polygon with map(point) in place of each corner; the map must keep the orientation.
    template <class Map>
    LabelledPolygon mapped(Map&& map) const {
        LabelledPolygon out = *this;
        for (std::size_t i = 0; i < size_; ++i) out.corner_[i].at = map(corner_[i].at);
        return out;
    }
    bool empty() const { return size_ < 3; }
    std::size_t size() const { return size_; }
    const Vec2d& corner(std::size_t i) const { return corner_[i].at; }
    /// Number of the edge that the side from corner i to the next one lies on, or -1.
    int edge(std::size_t i) const { return corner_[i].edge; }
    /// Calls take(LabelledTriangle) for the triangles of a fan that makes up the polygon.
    template <class Take>
    void for_each_triangle(Take&& take) const {
        for (std::size_t i = 1; i + 1 < size_; ++i)
            take(LabelledTriangle{
                {corner_[0].at, corner_[i].at, corner_[i + 1].at},
                {i == 1 ? corner_[0].edge : -1, corner_[i].edge, i + 2 == size_ ? corner_[i + 1].edge : -1}});
    }

  private:
    struct Corner {
        Vec2d at;
        int edge;
    };
    static constexpr std::size_t k_most = 8;  ///< corners of a triangle cut by the sides of a cell, and one to spare

    std::array<Corner, k_most> corner_;
    std::size_t size_ = 0;
};

/// The part of a polygon in a quarter of a cell with n corners, in lengths of the quarter's sides.
inline LabelledPolygon in_quarter(LabelledPolygon part, int quarter, int n) {
    // Lines where x, y and, of triangles, 1 - x - y are 1/2.
    const auto keep = [&](int k, bool above) {
        part = part.clipped([&](const Vec2d& p) {
            return (above ? 1 : -1) * ((k == 0 ? 1 - p.x - p.y : k == 1 ? p.x : p.y) - 0.5);
        });
    };
    if (n == 4) {
        keep(1, quarter == 1 || quarter == 2);
        keep(2, quarter >= 2);
    } else if (quarter < 3) {
        keep(quarter, true);
    } else {
        for (int k = 0; k < 3; ++k) keep(k, false);
    }
    return part.mapped([&](const Vec2d& p) { return in_quarter(p, quarter, n); });
}

/// Calls take(part, is_next) for the parts of a polygon in a corner cell, where x <= 1, and in the next corner's.
template <class Take>
void for_each_corner_cell(const LabelledPolygon& whole, Take&& take) {
    const LabelledPolygon here = whole.clipped([](const Vec2d&p) { return 1 - p.x; }),
                          next = whole.clipped([](const Vec2d&p) { return p.x - 1; }).mapped([](const Vec2d&p) {
                              return Vec2d(p.y, 2 - p.x);
                          });
    if (!here.empty()) take(here, false);
    if (!next.empty()) take(next, true);
}

}  // namespace tetrakis::detail
