#include "bicubic.hpp"

#include "bezier_triangle.hpp"

namespace tetrakis::detail {

namespace {

using Rows4 = std::array<Weights4, 4>;

/// Weights of a curve's control points in those of its part over [low, high].
Rows4 rows_over(double low, double high) {
    const double h = high - low;
    Rows4 rows;
    for (int i = 0; i < 4; ++i)
        rows[static_cast<std::size_t>(i)] = cubic_polar(low + (i - 2) * h, low + (i - 1) * h, low + i * h);
    return rows;
}

/// The same across a crease, for a part of one piece.
/// @param low, high  distances from the crease
Rows4 rows_over(const CreasePieces::Piece& piece, double low, double high) {
    const Rows4 own = rows_over((low - piece.origin) / piece.span, (high - piece.origin) / piece.span);
    Rows4 rows{};
    for (std::size_t i = 0; i < 4; ++i)
        for (std::size_t k = 0; k < 4; ++k)
            for (std::size_t j = 0; j < 4; ++j) rows[i][j] += own[i][k] * piece.control[k][j];
    return rows;
}

}  // namespace

TETRAKIS_FOR_AVX2_TOO
Net16 net_over(const Net16& net, SideCrease crease, int piece, const Vec2d& low, const Vec2d& high) {
    Rows4 by_x = rows_over(low.x, high.x), by_y = rows_over(low.y, high.y);
    if (crease) {
        const int axis = crease.across_y() ? 1 : 0;
        const double from = crease.far() ? 1 - high[axis] : low[axis], to = crease.far() ? 1 - low[axis] : high[axis];
        Rows4& across = axis == 1 ? by_y : by_x;
        across = rows_over(crease_pieces(crease.sharpness).piece[static_cast<std::size_t>(piece)], from, to);
        if (crease.far()) {
            std::ranges::reverse(across);
            for (Weights4& row : across) std::ranges::reverse(row);
        }
    }
    Net16 out;
    for (int k = 0; k < 3; ++k) {
        double rows[16];
        for (std::size_t y = 0; y < 4; ++y) {
            const double* p = net.c[k] + 4 * y;
            for (std::size_t x = 0; x < 4; ++x)
                rows[4 * y + x] = by_x[x][0] * p[0] + by_x[x][1] * p[1] + by_x[x][2] * p[2] + by_x[x][3] * p[3];
        }
        for (std::size_t y = 0; y < 4; ++y)
            for (std::size_t x = 0; x < 4; ++x)
                out.c[k][4 * y + x] = by_y[y][0] * rows[x] + by_y[y][1] * rows[4 + x] + by_y[y][2] * rows[8 + x] +
                                      by_y[y][3] * rows[12 + x];
    }
    return out;
}

const CreasePieces& crease_pieces(float sharpness) {
    // Most models have creases of one sharpness, or of a few.
    thread_local float known = 0;
    thread_local CreasePieces pieces = CreasePieces::make(known);
    if (sharpness != known) {
        pieces = CreasePieces::make(sharpness);
        known = sharpness;
    }
    return pieces;
}

void regular_basis(SideCrease crease, double x, double y, Weights4 (&wx)[3], Weights4 (&wy)[3]) {
    wx[0] = cubic_basis(x), wx[1] = cubic_basis_d1(x), wx[2] = cubic_basis_d2(x);
    wy[0] = cubic_basis(y), wy[1] = cubic_basis_d1(y), wy[2] = cubic_basis_d2(y);
    if (!crease) return;
    const bool across_y = crease.across_y(), far = crease.far();
    Weights4(&w)[3] = across_y ? wy : wx;
    const double t = across_y ? y : x;
    for (int d = 0; d < 3; ++d) {
        w[d] = crease_basis(crease_pieces(crease.sharpness), far ? 1 - t : t, d);
        if (far) std::reverse(w[d].begin(), w[d].end());
    }
    if (!far) return;
    for (double& d : w[1]) d = -d;
}

}  // namespace tetrakis::detail
