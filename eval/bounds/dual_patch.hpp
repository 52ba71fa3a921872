#pragma once

#include "../../hier/base/vec.hpp"
#include "../../hier/forest/site.hpp"
#include "../../hier/forest/vertex_roots.hpp"
#include "short_polygon.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <span>

namespace tetrakis::detail {

/// Coordinates of a root of vertex quadtrees that the surface of a quadratic dual scheme is well behaved in. Replicated
/// control points make it even across the line where it ends: with t the distance from there, in sides of the root, it
/// stands still at t = 0 and has a tangent plane by t^2 alone. So a root on such a line is measured by t^2 / 2, which
/// meets the coordinates of the next root with the same slope, and in which the surface is a polynomial as before.
class DualAxes {
  public:
    DualAxes() = default;
    /// @param outer  bit s: the surface ends, or a crease runs, along side s
    explicit DualAxes(unsigned outer) : outer_(static_cast<std::uint8_t>(outer)) {}
    /// Of a point in sides of the root.
    Vec2d operator()(const Vec2d& place) const {
        return {along(place.x, (outer_ & 8u) != 0, (outer_ & 2u) != 0),
                along(place.y, (outer_ & 1u) != 0, (outer_ & 4u) != 0)};
    }
    /// The way back, of a point of the root.
    Vec2d place(const Vec2d& p) const {
        return {back(p.x, (outer_ & 8u) != 0, (outer_ & 2u) != 0), back(p.y, (outer_ & 1u) != 0, (outer_ & 4u) != 0)};
    }
    /// Where a vertex is, in sides of the root: in the middle of its cell, or on the line where the surface ends.
    Vec2d vertex_place(const VertexCell& cell) const;
    Vec2d vertex(const VertexCell& cell) const { return (*this)(vertex_place(cell)); }
    /// Whether the coordinate along a side of the root is that of the square.
    bool is_bent_along(int side) const { return (outer_ & (side % 2 == 0 ? 10u : 5u)) != 0; }
    /// Of a point in sides of the root, how far it is from the side that the surface ends at, in that direction.
    Vec2d from_end(const Vec2d& place) const {
        return {(outer_ & 2u) != 0 ? 1 - place.x : place.x, (outer_ & 4u) != 0 ? 1 - place.y : place.y};
    }

  private:
    static double along(double x, bool ends_low, bool ends_high) {
        return ends_low ? 0.5 * x * x : ends_high ? -0.5 * (1 - x) * (1 - x) : x;
    }
    static double back(double x, bool ends_low, bool ends_high) {
        return ends_low ? std::sqrt(std::max(2 * x, 0.0)) : ends_high ? 1 - std::sqrt(std::max(-2 * x, 0.0)) : x;
    }
    std::uint8_t outer_ = 0;
};

/// A corner of a cell, and the middle of a side, in sides of its root.
Vec2d corner_place(const VertexCell& cell, int corner);
Vec2d middle_place(const VertexCell& cell, int side);

/// A rectangle in a root's coordinates.
struct DualBox {
    Vec2d low{0}, high{0};
};
DualBox box_of(const DualAxes& axes, const VertexCell& cell);

/// An affine map from a root's coordinates.
struct FlatMap {
    Vec3d constant{0}, by_x{0}, by_y{0};

    /// By what it does to a triangle.
    FlatMap(const std::array<Vec2d, 3>& at, const std::array<Vec3d, 3>& to);
    Vec3d operator()(const Vec2d& p) const { return constant + p.x * by_x + p.y * by_y; }
};

/// What surfaces are on a regular cell.
enum class DualPieces {
    biquadratic,  ///< one biquadratic polynomial (Doo-Sabin)
    four,         ///< a quadratic one on each of the four triangles that its diagonals cut it in (midedge: the box
                  ///< spline of Zwart and Powell), always in the cell's frame
};

/// What a patch's polynomials are in: the root's coordinates where these are bent and its surface is even across the
/// line that it ends at, which it is all over a root that is regular; else lengths on the cell.
enum class DualFrame { root, cell };

/// Part of a surface that one polynomial is of.
class DualPart {
  public:
    using Monomials = std::array<Vec3d, 9>;  ///< of s^i t^j: number 3 j + i, 0 <= s, t <= 1 over a cell

    /// @param bend    the root's coordinates as polynomials of s and of t
    /// @param within  convex polygon (or segment: two corners) that holds the part, in s and t
    DualPart(const Monomials& monomials, const std::array<Vec2d, 3>& bend, const ShortPolygon& within, double slack)
        : monomials_(monomials), bend_(bend), within_(within), slack_(slack) {}

    /// Calls take(points, slack) for points whose hulls hold the part, but for what the polynomial may be off: of
    /// triangles with one side on the part's border each.
    template <class Take>
    void for_each_hull(Take&& take) const {
        const auto over = [&](const Vec2d& a, const Vec2d& b, const Vec2d& c) {
            const Coefficients points = coefficients(monomials_, {a, b, c});
            take(std::span<const Vec3d>(points), slack_);
        };
        if (within_.size() == 2) return over(within_[0], within_[1], within_[1]);
        Vec2d middle(0);
        for (std::size_t k = 0; k < within_.size(); ++k) middle += within_[k] / static_cast<double>(within_.size());
        for (std::size_t k = 0; k < within_.size(); ++k) over(middle, within_[k], within_[(k + 1) % within_.size()]);
    }
    /// A bound of the difference from a flat map of the root's coordinates.
    double difference(const FlatMap& flat) const;

  private:
    using Coefficients = std::array<Vec3d, 15>;
    /// Bernstein coefficients (degree 4) over a triangle: its points are means of them.
    static Coefficients coefficients(const Monomials& monomials, const std::array<Vec2d, 3>& triangle);
    template <class Take>
    void for_each_triangle(Take&& take) const {
        if (within_.size() == 2) take(std::array<Vec2d, 3>{within_[0], within_[1], within_[1]});
        for (std::size_t k = 1; k + 1 < within_.size(); ++k)
            take(std::array<Vec2d, 3>{within_[0], within_[k], within_[k + 1]});
    }

    const Monomials& monomials_;
    const std::array<Vec2d, 3>& bend_;
    const ShortPolygon& within_;
    double slack_;
};

/// A regular cell of a surface.
class DualPatch {
  public:
    /// Vertices two levels below a cell, row by row, which a patch is found from.
    static constexpr int k_bits = 2;
    static constexpr std::size_t k_points = 16;

    DualPatch() = default;
    /// @param points  k_points limit points, as add_cells_below() orders their cells
    DualPatch(DualPieces pieces, DualFrame frame, const DualAxes& axes, const VertexCell& cell,
              std::span<const Vec3d> points);

    /// Calls take(part) for the parts of the surface within a polygon (or segment) in the root's coordinates, or a
    /// little around it.
    template <class Take>
    void for_each_part(const DualAxes& axes, const VertexCell& cell, const ShortPolygon& polygon, Take&& take) const {
        if (frame_ == DualFrame::root) return take(DualPart(monomials_, bend_, to_cell(polygon), slack_));
        const ShortPolygon within = straightened(axes, cell, polygon);
        if (!ridged_) return take(DualPart(monomials_, bend_, within, slack_));
        for (int side = 0; side < 4; ++side)
            if (const ShortPolygon part = beside(within, side); part.size() >= 2)
                take(DualPart(beside(side), bend_, part, slack_));
    }

  private:
    ShortPolygon to_cell(const ShortPolygon& polygon) const;
    static ShortPolygon straightened(const DualAxes& axes, const VertexCell& cell, const ShortPolygon& polygon);
    static ShortPolygon beside(const ShortPolygon& polygon, int side);
    DualPart::Monomials beside(int side) const;

    void fit_biquadratic(std::span<const double> s, std::span<const double> t, std::span<const Vec3d> points);
    void fit_four(std::span<const double> s, std::span<const double> t, std::span<const Vec3d> points);
    Vec3d at(double s, double t) const;

    std::array<Vec2d, 3> bend_{};
    DualPart::Monomials monomials_{};  ///< of the lowest piece
    std::array<Vec3d, 2> ridge_{};     ///< times the squares of t - s and of s + t - 1 where these are positive
    bool ridged_ = false;
    DualFrame frame_ = DualFrame::root;
    double slack_ = 0;  ///< how far points that it was not found from are from it, which is rounding, and so it may be
};

}  // namespace tetrakis::detail
