#pragma once

#include "../../hier/base/vec.hpp"

#include <array>
#include <cstdint>

namespace tetrakis::detail {

/// Control net of one uniform bicubic B-spline patch, one array per coordinate: entry 4 * row + column, rows y = -1..2,
/// columns x = -1..2; the patch covers [0, 1]^2.
struct Net16 {
    double c[3][16];

    Vec3d at(int x, int y) const {
        const int i = 4 * (y + 1) + x + 1;
        return {c[0][i], c[1][i], c[2][i]};
    }
    void set(int x, int y, const Vec3d& p) {
        const int i = 4 * (y + 1) + x + 1;
        c[0][i] = p.x, c[1][i] = p.y, c[2][i] = p.z;
    }
};

using Weights4 = std::array<double, 4>;

/// Uniform cubic B-spline basis at t in [0, 1], by de Boor's formulas; or its first or second derivative.
inline Weights4 cubic_basis(double t, int derivative = 0) {
    const double s = 1 - t;
    if (derivative == 2) return {s, 3 * t - 2, 1 - 3 * t, t};
    if (derivative == 1) return {-s * s / 2, (3 * t * t - 4 * t) / 2, (-3 * s * s + 4 * s) / 2, t * t / 2};
    return {s * s * s / 6, (3 * t * t * t - 6 * t * t + 4) / 6, (3 * s * s * s - 6 * s * s + 4) / 6, t * t * t / 6};
}

/// Value of the net under tensor weights.
inline Vec3d combine(const Net16& net, const Weights4& wx, const Weights4& wy) {
    Vec3d result;
    for (int k = 0; k < 3; ++k) {
        const double* p = net.c[k];
        double sum = 0;
        for (int r = 0; r < 4; ++r)
            sum += wy[r] * (wx[0] * p[4 * r] + wx[1] * p[4 * r + 1] + wx[2] * p[4 * r + 2] + wx[3] * p[4 * r + 3]);
        result[k] = sum;
    }
    return result;
}

/// Weights of the control points in the polar form of the cubic over [0, 1]: de Boor's algorithm, backwards.
inline Weights4 cubic_polar(double u, double v, double w) {
    const double e0 = 1 - w, e1 = w;
    const double d0 = e0 * (1 - v) / 2, d1 = e0 * (1 + v) / 2 + e1 * (2 - v) / 2, d2 = e1 * v / 2;
    return {d0 * (1 - u) / 3, (d0 * (2 + u) + d1 * (2 - u)) / 3, (d1 * (1 + u) + d2 * (3 - u)) / 3, d2 * u / 3};
}

/// A crease of finite sharpness along one side of an otherwise regular cell (a single-crease patch): the net then holds
/// the real points beyond the crease. Sides: 0 y = 0, 1 x = 1, 2 y = 1, 3 x = 0.
struct SideCrease {
    std::int8_t side = -1;
    float sharpness = 0;
    explicit operator bool() const { return side >= 0; }
    /// Parameter axis across the crease: 0 for x, 1 for y.
    int axis() const { return side == 0 || side == 2 ? 1 : 0; }
    /// Whether the crease is at 1, not at 0, of that axis.
    bool far() const { return side == 1 || side == 2; }
};

/// The curve across a crease, as cubic B-spline pieces in ascending order. Parameter t = 0 is on the crease; control
/// point p_-1 lies beyond it. For sharpness floor + fraction, [2^-floor, 1] follows the infinitely sharp rule. [0,
/// 2^-floor] follows the smooth rule, after one blended step if the fraction is not 0.
struct CreasePieces {
    struct Piece {
        double begin, end;
        double origin, span;              ///< the piece's own parameter is (t - origin) / span
        std::array<Weights4, 4> control;  ///< by control point i - 1: weights of p_-1, p_0, p_1, p_2
    };
    int count = 0;
    std::array<Piece, 3> piece;

    const Piece& at(double t) const {
        std::size_t i = 0;
        while (i + 1 < static_cast<std::size_t>(count) && t >= piece[i].end) ++i;
        return piece[i];
    }
};

/// Pieces for a sharpness. A thread caches its last result; the reference is valid until the thread's next call.
const CreasePieces& crease_pieces(float sharpness);

/// Control net of a cell over [low.x, high.x] x [low.y, high.y]: one bicubic patch. If the cell has a crease, the
/// rectangle must lie in piece `piece` of the curve across it.
Net16 net_over(const Net16& net, SideCrease crease, int piece, const Vec2d& low, const Vec2d& high);

/// Basis of the curve across a crease, or its first or second derivative, at parameter t of the cell.
Weights4 crease_basis(SideCrease crease, double t, int derivative);

/// Basis of a regular or single-crease cell along an axis, or its first or second derivative.
inline Weights4 regular_basis(SideCrease crease, int axis, double t, int derivative = 0) {
    return crease && crease.axis() == axis ? crease_basis(crease, t, derivative) : cubic_basis(t, derivative);
}

inline Vec3d regular_position(const Net16& net, SideCrease crease, double x, double y) {
    return combine(net, regular_basis(crease, 0, x), regular_basis(crease, 1, y));
}

}  // namespace tetrakis::detail
