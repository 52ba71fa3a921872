#include "bicubic.hpp"

#include "../triangles/avx2.hpp"

namespace tetrakis::detail {

namespace {

using Rows4 = std::array<Weights4, 4>;

/// Row i: weights of a curve's control points in control point i of its part over [low, high].
Rows4 rows_over(double low, double high) {
    const double h = high - low;
    Rows4 rows;
    for (int i = 0; i < 4; ++i)
        rows[static_cast<std::size_t>(i)] = cubic_polar(low + (i - 2) * h, low + (i - 1) * h, low + i * h);
    return rows;
}

/// Matrix product.
Rows4 product(const Rows4& a, const Rows4& b) {
    Rows4 rows{};
    for (std::size_t i = 0; i < 4; ++i)
        for (std::size_t k = 0; k < 4; ++k)
            for (std::size_t j = 0; j < 4; ++j) rows[i][j] += a[i][k] * b[k][j];
    return rows;
}

CreasePieces pieces_of(float sharpness) {
    // The infinitely sharp curve ends naturally: p_-1 = 2 p_0 - p_1 on either side.
    constexpr Rows4 k_sharp{{{0, 2, -1, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}, {0, 0, 0, 1}}};
    const double floor = std::floor(static_cast<double>(sharpness)), fraction = sharpness - floor;
    const double h = std::exp2(-floor);
    CreasePieces out;
    const auto add = [&](const CreasePieces::Piece& piece) {
        out.piece[static_cast<std::size_t>(out.count++)] = piece;
    };
    // Control points at level `floor`; row 0 is the actual point beyond the crease, not its reflection.
    Rows4 level = product(rows_over(0, h), k_sharp);
    level[0] = {h, 1 - h, 0, 0};
    if (fraction == 0) {
        add({0, h, 0, h, level});
    } else {
        // Both halves by the smooth rule, except that the point on the crease is blended.
        Rows4 low = product(rows_over(0, 0.5), level), high = product(rows_over(0.5, 1), level);
        for (std::size_t j = 0; j < 4; ++j)
            low[1][j] = high[0][j] = fraction * level[1][j] + (1 - fraction) * low[1][j];
        add({0, h / 2, 0, h / 2, low});
        add({h / 2, h, h / 2, h / 2, high});
    }
    if (h < 1) add({h, 1, 0, 1, k_sharp});
    return out;
}

}  // namespace

TETRAKIS_FOR_AVX2_TOO
Net16 net_over(const Net16& net, SideCrease crease, int piece, const Vec2d& low, const Vec2d& high) {
    Rows4 by_x = rows_over(low.x, high.x), by_y = rows_over(low.y, high.y);
    if (crease) {
        const int axis = crease.axis();
        const double from = crease.far() ? 1 - high[axis] : low[axis], to = crease.far() ? 1 - low[axis] : high[axis];
        Rows4& across = axis == 1 ? by_y : by_x;
        const CreasePieces::Piece& strip = crease_pieces(crease.sharpness).piece[static_cast<std::size_t>(piece)];
        across =
            product(rows_over((from - strip.origin) / strip.span, (to - strip.origin) / strip.span), strip.control);
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
    thread_local CreasePieces pieces = pieces_of(known);
    if (sharpness != known) {
        pieces = pieces_of(sharpness);
        known = sharpness;
    }
    return pieces;
}

Weights4 crease_basis(SideCrease crease, double t, int derivative) {
    const double distance = crease.far() ? 1 - t : t;
    const CreasePieces::Piece& piece = crease_pieces(crease.sharpness).at(distance);
    const double scale = (crease.far() ? -1 : 1) / piece.span;
    const Weights4 basis = cubic_basis((distance - piece.origin) / piece.span, derivative);
    const double factor = derivative == 0 ? 1 : derivative == 1 ? scale : scale * scale;
    Weights4 weights{};
    for (std::size_t k = 0; k < 4; ++k)
        for (std::size_t j = 0; j < 4; ++j)
            weights[crease.far() ? 3 - j : j] += factor * basis[k] * piece.control[k][j];
    return weights;
}

}  // namespace tetrakis::detail
