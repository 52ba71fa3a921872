#include "cell_points.hpp"

namespace tetrakis::detail {

CellPoints cell_points(const Net16& net) {
    CellPoints point;
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
    return point;
}

}  // namespace tetrakis::detail
