#include "cell_facts.hpp"

#include <algorithm>
#include <cmath>

namespace tetrakis::detail {

namespace {

template <int Count>
double largest(const double (&x)[3][Count]) {
    double most = 0;
    for (int i = 0; i < Count; ++i) most = std::max(most, x[0][i] * x[0][i] + x[1][i] * x[1][i] + x[2][i] * x[2][i]);
    return std::sqrt(most);
}

double largest_size(const double* x, int count) {
    double most = 0;
    for (int i = 0; i < count; ++i) most = std::max(most, std::abs(x[i]));
    return most;
}

/// Third differences of a scalar net: B-spline control values of the third derivatives, whose convex hull holds them.
void third_differences(const double* p, double (&xxx)[4], double (&xxy)[6], double (&xyy)[6], double (&yyy)[4]) {
    double dy[12], dyy[8];
    for (int i = 0; i < 12; ++i) dy[i] = p[i + 4] - p[i];
    for (int i = 0; i < 8; ++i) dyy[i] = dy[i + 4] - dy[i];
    for (int i = 0; i < 4; ++i) yyy[i] = dyy[i + 4] - dyy[i];
    for (int r = 0; r < 2; ++r)
        for (int x = 0; x < 3; ++x) xyy[3 * r + x] = dyy[4 * r + x + 1] - dyy[4 * r + x];
    for (int r = 0; r < 3; ++r)
        for (int x = 0; x < 2; ++x) xxy[2 * r + x] = (dy[4 * r + x] + dy[4 * r + x + 2]) - 2 * dy[4 * r + x + 1];
    for (int r = 0; r < 4; ++r) xxx[r] = (p[4 * r + 3] - p[4 * r]) - 3 * (p[4 * r + 2] - p[4 * r + 1]);
}

}  // namespace

ThirdBounds ThirdBounds::along(const Net16& net, const Vec3d& direction) {
    double height[16], xxx[4], xxy[6], xyy[6], yyy[4];
    for (int i = 0; i < 16; ++i)
        height[i] = direction.x * net.c[0][i] + direction.y * net.c[1][i] + direction.z * net.c[2][i];
    third_differences(height, xxx, xxy, xyy, yyy);
    return {largest_size(xxx, 4), largest_size(xxy, 6), largest_size(xyy, 6), largest_size(yyy, 4)};
}

ThirdBounds ThirdBounds::of(const Net16& net) {
    double xxx[3][4], xxy[3][6], xyy[3][6], yyy[3][4];
    for (int k = 0; k < 3; ++k) third_differences(net.c[k], xxx[k], xxy[k], xyy[k], yyy[k]);
    return {largest(xxx), largest(xxy), largest(xyy), largest(yyy)};
}

double ThirdBounds::on_line(const Vec2d& d) const {
    const double x = std::abs(d.x), y = std::abs(d.y);
    return x * x * (x * xxx + 3 * y * xxy) + y * y * (3 * x * xyy + y * yyy);
}

ThirdBounds ThirdBounds::in_frame(const Vec2d& u, const Vec2d& v) const {
    const Vec2d a = glm::abs(u), b = glm::abs(v);
    const auto mixed = [&](const Vec2d& p, const Vec2d& q) {  // twice along p, once along q
        return p.x * p.x * (q.x * xxx + q.y * xxy) + 2 * p.x * p.y * (q.x * xxy + q.y * xyy) +
               p.y * p.y * (q.x * xyy + q.y * yyy);
    };
    return {on_line(u), mixed(a, b), mixed(b, a), on_line(v)};
}

void CellFacts::find_points(const Net16& net) {
    for (int k = 0; k < 3; ++k) {
        const double* p = net.c[k];
        // Cubic B-splines at 0, 1/2 and 1, first along y.
        double rows[3][4];
        for (int x = 0; x < 4; ++x) {
            rows[0][x] = ((p[x] + p[8 + x]) + 4 * p[4 + x]) * (1.0 / 6);
            rows[1][x] = ((p[x] + p[12 + x]) + 23 * (p[4 + x] + p[8 + x])) * (1.0 / 48);
            rows[2][x] = ((p[4 + x] + p[12 + x]) + 4 * p[8 + x]) * (1.0 / 6);
        }
        for (std::size_t y = 0; y < 3; ++y) {
            const double* r = rows[y];
            point[3 * y][k] = ((r[0] + r[2]) + 4 * r[1]) * (1.0 / 6);
            point[3 * y + 1][k] = ((r[0] + r[3]) + 23 * (r[1] + r[2])) * (1.0 / 48);
            point[3 * y + 2][k] = ((r[1] + r[3]) + 4 * r[2]) * (1.0 / 6);
        }
    }
}

}  // namespace tetrakis::detail
