#include "box_spline.hpp"

namespace tetrakis::detail {

namespace {

// The basis functions by symmetry classes, 12 times their value; u, v, w are the coordinates of the corners they are
// near. A point beside one corner u, on the side of v.
double single(double u, double v) { return u * u * u * (u + 2 * v); }
// A point across the edge of u and v.
double across(double u, double v, double w) {
    const double s = u + v, uv = u * v;
    const double q = u * u + v * v;
    return q * q + uv * (6 * q + 10 * uv) + 2 * w * s * s * s;
}
// The corner u itself; symmetric in v and w.
double corner(double u, double v, double w) {
    const double s = v + w, p = v * w;
    const double s2 = s * s;
    // v^2 + w^2 = s^2 - 2p, v^3 + w^3 = s (s^2 - 3p), v^4 + w^4 = s^4 - 4 s^2 p + 2 p^2.
    return u * u * (6 * u * u + 24 * u * s + 24 * s2 + 12 * p) + u * s * (8 * s2 + 12 * p) + s2 * s2 + 2 * s2 * p +
           2 * p * p;
}

constexpr double k_scale = 1.0 / 12;

struct Gradient {
    double u, v, w;
};
Gradient single_gradient(double u, double v) { return {u * u * (4 * u + 6 * v), 2 * u * u * u, 0}; }
Gradient across_gradient(double u, double v, double w) {
    const double s = u + v, s2 = s * s;
    const double uv = u * v;
    return {4 * u * u * u + 18 * u * uv + 24 * uv * v + 6 * v * v * v + 6 * w * s2,
            4 * v * v * v + 18 * v * uv + 24 * uv * u + 6 * u * u * u + 6 * w * s2, 2 * s2 * s};
}
Gradient corner_gradient(double u, double v, double w) {
    const double u2 = u * u, v2 = v * v, w2 = w * w, vw = v * w;
    return {
        24 * u2 * u + 72 * u2 * (v + w) + 48 * u * (v2 + w2) + 120 * u * vw + 8 * (v2 * v + w2 * w) + 36 * vw * (v + w),
        24 * u2 * u + 48 * u2 * v + 60 * u2 * w + 24 * u * v2 + 36 * u * (2 * vw + w2) + 4 * v2 * v + 18 * v * vw +
            6 * w2 * w + 24 * vw * w,
        24 * u2 * u + 48 * u2 * w + 60 * u2 * v + 24 * u * w2 + 36 * u * (2 * vw + v2) + 4 * w2 * w + 18 * w * vw +
            6 * v2 * v + 24 * vw * v};
}

/// All second derivatives of a regular triangle. Along edge e (corner e to corner e + 1) the second derivative is the
/// bilinear box spline of the net's second differences along the edge (de Boor, Hoellig, Riemenschneider 1993, ch. I),
/// and on the triangle that is: linear between the differences at the corners, plus the product of the barycentric
/// coordinates of the edge's two ends times one fourth difference.
struct BoxSplineHessian {
    std::array<std::array<Vec3d, 3>, 3> corner;  ///< [edge][corner]
    std::array<Vec3d, 3> bend;                   ///< [edge]

    explicit BoxSplineHessian(const Net12& net) {
        const auto second = [&](int a, int b, int c) { return net[a] + net[b] - 2.0 * net[c]; };
        corner[0] = {second(1, 4, 0), second(8, 0, 1), second(9, 3, 2)};
        corner[1] = {second(3, 6, 0), second(2, 7, 1), second(11, 1, 2)};
        corner[2] = {second(2, 5, 0), second(9, 6, 1), second(10, 0, 2)};
        bend[0] = second(7, 5, 6) + corner[0][2] - corner[0][0] - corner[0][1];
        bend[1] = second(10, 8, 9) + corner[1][0] - corner[1][1] - corner[1][2];
        bend[2] = second(11, 4, 3) + corner[2][1] - corner[2][2] - corner[2][0];
    }
    Vec3d along(int edge, const Bary& b) const {
        return b[0] * corner[edge][0] + b[1] * corner[edge][1] + b[2] * corner[edge][2] +
               (b[edge] * b[edge == 2 ? 0 : edge + 1]) * bend[edge];
    }
};

}  // namespace

std::array<double, 12> box_spline_weights(const Bary& at) {
    const double u = at[0], v = at[1], w = at[2];
    return {k_scale * corner(u, v, w), k_scale * corner(v, w, u), k_scale * corner(w, u, v), k_scale * across(w, u, v),
            k_scale * single(u, w),    k_scale * single(u, v),    k_scale * across(u, v, w), k_scale * single(v, u),
            k_scale * single(v, w),    k_scale * across(v, w, u), k_scale * single(w, v),    k_scale * single(w, u)};
}

Vec3d box_spline_position(const Net12& net, const Bary& at) {
    const auto weights = box_spline_weights(at);
    Vec3d sum = weights[0] * net[0];
    for (int i = 1; i < 12; ++i) sum += weights[i] * net[i];
    return sum;
}

Vec3d box_spline_corner(const Net12& net, int corner) {
    constexpr int ring[3][6] = {{1, 2, 3, 4, 5, 6}, {0, 2, 6, 7, 8, 9}, {0, 1, 3, 9, 10, 11}};
    const int* r = ring[corner];
    return 0.5 * net[static_cast<std::size_t>(corner)] +
           k_scale * ((net[r[0]] + net[r[1]]) + (net[r[2]] + net[r[3]]) + (net[r[4]] + net[r[5]]));
}

BoxSplineTangents box_spline_tangents(const Net12& net, const Bary& at) {
    const double u = at[0], v = at[1], w = at[2];
    BoxSplineTangents out{Vec3d(0), Vec3d(0)};
    const auto add = [&](int i, double gu, double gv, double gw) {
        out.dx += (k_scale * (gv - gu)) * net[i];
        out.dy += (k_scale * (gw - gu)) * net[i];
    };
    Gradient g = corner_gradient(u, v, w);
    add(0, g.u, g.v, g.w);
    g = corner_gradient(v, w, u);
    add(1, g.w, g.u, g.v);
    g = corner_gradient(w, u, v);
    add(2, g.v, g.w, g.u);
    g = across_gradient(w, u, v);
    add(3, g.v, g.w, g.u);
    g = single_gradient(u, w);
    add(4, g.u, 0, g.v);
    g = single_gradient(u, v);
    add(5, g.u, g.v, 0);
    g = across_gradient(u, v, w);
    add(6, g.u, g.v, g.w);
    g = single_gradient(v, u);
    add(7, g.v, g.u, 0);
    g = single_gradient(v, w);
    add(8, 0, g.u, g.v);
    g = across_gradient(v, w, u);
    add(9, g.w, g.u, g.v);
    g = single_gradient(w, v);
    add(10, 0, g.v, g.u);
    g = single_gradient(w, u);
    add(11, g.v, 0, g.u);
    return out;
}

BoxSplineBends box_spline_bends(const Net12& net, const Bary& at) {
    const BoxSplineHessian hessian(net);
    const Vec3d dxx = hessian.along(0, at), dyy = hessian.along(2, at);
    return {dxx, 0.5 * (dxx + dyy - hessian.along(1, at)), dyy};
}

}  // namespace tetrakis::detail
