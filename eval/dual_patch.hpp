#pragma once

#include "tetrakis/hier/site.hpp"
#include "tetrakis/hier/vec.hpp"
#include "tetrakis/hier/vertex_roots.hpp"

#include <array>
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
    /// Where a vertex is, in sides of the root: in the middle of its cell, or on the line where the surface ends.
    Vec2d vertex_place(const VertexCell& cell) const;
    Vec2d vertex(const VertexCell& cell) const { return (*this)(vertex_place(cell)); }
    /// Whether the coordinate along a side of the root is that of the square.
    bool is_bent_along(int side) const { return (outer_ & (side % 2 == 0 ? 10u : 5u)) != 0; }

  private:
    static double along(double x, bool ends_low, bool ends_high) {
        return ends_low ? 0.5 * x * x : ends_high ? -0.5 * (1 - x) * (1 - x) : x;
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

/// A cell of a surface that is a biquadratic polynomial there, in its root's coordinates.
class DualPatch {
  public:
    /// Vertices two levels below a cell, row by row, which a patch is found from.
    static constexpr int k_bits = 2;
    static constexpr std::size_t k_points = 16;
    static constexpr std::size_t k_coefficients = 15;
    using Coefficients = std::array<Vec3d, k_coefficients>;

    DualPatch() = default;
    /// @param points  k_points limit points, as add_cells_below() orders their cells
    DualPatch(const DualAxes& axes, const VertexCell& cell, std::span<const Vec3d> points);

    /// Bernstein coefficients (degree 4) over a triangle, given in the root's coordinates: its points are means of
    /// them. In the order of k_exponents.
    Coefficients over(const std::array<Vec2d, 3>& triangle) const;
    /// Exponents of the coefficients; a quarter of them are the barycentrics of a coefficient's place.
    static const std::array<std::array<int, 3>, k_coefficients> k_exponents;

    /// How far a point that the patch was not found from is from it, which is rounding: so much it may be off itself.
    double slack() const { return slack_; }

  private:
    Vec3d at(double s, double t) const;

    Vec2d low_{0}, scale_{1};         // to 0..1 over the cell
    std::array<Vec3d, 9> monomial_{};  // s^i t^j: number 3 j + i
    double slack_ = 0;
};

}  // namespace tetrakis::detail
