#pragma once

#include "../../hier/base/vec.hpp"

#include <algorithm>
#include <array>
#include <cmath>
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

/// Uniform cubic B-spline basis at t in [0, 1], by de Boor's formulas.
inline Weights4 cubic_basis(double t) {
    const double s = 1 - t;
    return {s * s * s / 6, (3 * t * t * t - 6 * t * t + 4) / 6, (3 * s * s * s - 6 * s * s + 4) / 6, t * t * t / 6};
}
inline Weights4 cubic_basis_d1(double t) {
    const double s = 1 - t;
    return {-s * s / 2, (3 * t * t - 4 * t) / 2, (-3 * s * s + 4 * s) / 2, t * t / 2};
}
inline Weights4 cubic_basis_d2(double t) { return {1 - t, 3 * t - 2, 1 - 3 * t, t}; }

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
    bool across_y() const { return side == 0 || side == 2; }
    /// The crease is at 1, not at 0.
    bool far() const { return side == 1 || side == 2; }
};

/// Where the across-crease curve is one cubic: pieces, ascending, with the weights of their control points.
/// t = 0 is the crease; p_-1 lies beyond it. With s = floor + fraction: [2^-floor, 1] follows the infinitely sharp
/// rule; [0, 2^-floor] the smooth rule after one blended step, if there is a fraction.
struct CreasePieces {
    struct Piece {
        double begin, end;
        double origin, span;              ///< the piece's own parameter is (t - origin) / span
        std::array<Weights4, 4> control;  ///< by control point i - 1: weights of p_-1, p_0, p_1, p_2
    };
    int count = 0;
    std::array<Piece, 3> piece;

    static CreasePieces make(float sharpness) {
        CreasePieces out;
        const double floor = std::floor(static_cast<double>(sharpness));
        const double fraction = sharpness - floor;
        const double h = std::exp2(-floor);
        // Points at level `floor` of the infinitely sharp curve (natural end: p_-1 = 2 p_0 - p_1 on either side), by
        // blossoming.
        const std::array<Weights4, 4> level{{{h, 1 - h, 0, 0},
                                             {0, 1, 0, 0},
                                             {0, 1 - h, h, 0},
                                             {0, 1 - 2 * h + h * h * h, 2 * h - 2 * h * h * h, h * h * h}}};
        const auto add = [&](const Piece& piece) { out.piece[static_cast<std::size_t>(out.count++)] = piece; };
        const auto mix = [](double a, const Weights4& x, double b, const Weights4& y, double c, const Weights4& z) {
            Weights4 w;
            for (int i = 0; i < 4; ++i) w[i] = a * x[i] + b * y[i] + c * z[i];
            return w;
        };
        if (fraction == 0) {
            add({0, h, 0, h, level});
        } else {
            const Weights4 zero{};
            const Weights4 centre = mix((1 - fraction) / 8, level[0], fraction + 0.75 * (1 - fraction), level[1],
                                        (1 - fraction) / 8, level[2]);
            const Weights4 before = mix(0.5, level[0], 0.5, level[1], 0, zero);
            const Weights4 middle = mix(0.5, level[1], 0.5, level[2], 0, zero);
            const Weights4 one = mix(0.125, level[1], 0.75, level[2], 0.125, level[3]);
            const Weights4 beyond = mix(0.5, level[2], 0.5, level[3], 0, zero);
            add({0, h / 2, 0, h / 2, {before, centre, middle, one}});
            add({h / 2, h, h / 2, h / 2, {centre, middle, one, beyond}});
        }
        // The control points of the sharp curve's own unit patch.
        if (h < 1) add({h, 1, 0, 1, {{{0, 2, -1, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}, {0, 0, 0, 1}}}});
        return out;
    }
    const Piece& at(double t) const {
        std::size_t i = 0;
        while (i + 1 < static_cast<std::size_t>(count) && t >= piece[i].end) ++i;
        return piece[i];
    }
};

/// CreasePieces::make() of the sharpness, known from this thread's last call where that asked for the same one.
const CreasePieces& crease_pieces(float sharpness);

/// Basis of the across-crease curve at t, or its first or second derivative: weights of p_-1, p_0, p_1, p_2.
inline Weights4 crease_basis(const CreasePieces& pieces, double t, int derivative = 0) {
    const CreasePieces::Piece& piece = pieces.at(t);
    const double scale = 1 / piece.span, local = (t - piece.origin) * scale;
    const Weights4 basis = derivative == 0   ? cubic_basis(local)
                           : derivative == 1 ? cubic_basis_d1(local)
                                             : cubic_basis_d2(local);
    const double factor = derivative == 0 ? 1 : derivative == 1 ? scale : scale * scale;
    Weights4 weights{};
    for (std::size_t k = 0; k < 4; ++k)
        for (std::size_t j = 0; j < 4; ++j) weights[j] += factor * basis[k] * piece.control[k][j];
    return weights;
}

/// The net of the part of a cell over [low.x, high.x] x [low.y, high.y] that follows one piece of the curve across its
/// crease, if it has one: that is one bicubic patch.
Net16 net_over(const Net16& net, SideCrease crease, int piece, const Vec2d& low, const Vec2d& high);

/// Bases of a regular or single-crease cell at (x, y): [0] values, [1] first and [2] second derivatives.
void regular_basis(SideCrease crease, double x, double y, Weights4 (&wx)[3], Weights4 (&wy)[3]);

/// Position on a regular or single-crease cell; its weights are the values of regular_basis(), bit by bit.
inline Vec3d regular_position(const Net16& net, SideCrease crease, double x, double y) {
    if (!crease) return combine(net, cubic_basis(x), cubic_basis(y));
    const double t = crease.across_y() ? y : x;
    Weights4 across = crease_basis(crease_pieces(crease.sharpness), crease.far() ? 1 - t : t);
    if (crease.far()) std::reverse(across.begin(), across.end());
    return crease.across_y() ? combine(net, cubic_basis(x), across) : combine(net, across, cubic_basis(y));
}

}  // namespace tetrakis::detail
