#include "tetrakis/eval/second_bounds.hpp"

namespace tetrakis::detail {

namespace {

template <int N>
void ball(const double (&x)[3][N], Vec3d& centre, double& radius, double* largest) {
    for (int k = 0; k < 3; ++k) {
        double sum = 0;
        for (int i = 0; i < N; ++i) sum += x[k][i];
        centre[k] = sum / N;
    }
    double far = 0, norm = 0;
    for (int i = 0; i < N; ++i) {
        double d = 0, n = 0;
        for (int k = 0; k < 3; ++k) {
            const double e = x[k][i] - centre[k];
            d += e * e;
            n += x[k][i] * x[k][i];
        }
        far = std::max(far, d);
        norm = std::max(norm, n);
    }
    radius = std::sqrt(far);
    if (largest) *largest = std::sqrt(norm);
}

}  // namespace

SecondBounds SecondBounds::of(const Net16& net, double scale_x, double scale_y) {
    double uu[3][8], vv[3][8], uv[3][9];
    const double sxx = scale_x * scale_x, sxy = scale_x * scale_y, syy = scale_y * scale_y;
    for (int k = 0; k < 3; ++k) {
        const double* p = net.c[k];
        for (int r = 0; r < 4; ++r)
            for (int x = 0; x < 2; ++x)
                uu[k][2 * r + x] = sxx * (p[4 * r + x] - 2 * p[4 * r + x + 1] + p[4 * r + x + 2]);
        for (int r = 0; r < 2; ++r)
            for (int x = 0; x < 4; ++x)
                vv[k][4 * r + x] = syy * (p[4 * r + x] - 2 * p[4 * r + x + 4] + p[4 * r + x + 8]);
        for (int r = 0; r < 3; ++r)
            for (int x = 0; x < 3; ++x)
                uv[k][3 * r + x] = sxy * ((p[4 * r + x] - p[4 * r + x + 1]) - (p[4 * r + x + 4] - p[4 * r + x + 5]));
    }
    SecondBounds bounds;
    ball<8>(uu, bounds.uu, bounds.radius_uu, &bounds.max_uu);
    ball<8>(vv, bounds.vv, bounds.radius_vv, &bounds.max_vv);
    ball<9>(uv, bounds.uv, bounds.radius_uv, nullptr);
    return bounds;
}

}  // namespace tetrakis::detail
