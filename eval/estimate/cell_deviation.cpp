#include "cell_deviation.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace tetrakis {

namespace {

// Parts of a cell that are no larger, and no larger a share of the piece, are corners and edges that rounding has given
// an area.
constexpr double k_no_area = 1e-12, k_no_share = 1e-6;

CellPlace cell_corner(int k, int cell_corners) {
    constexpr CellPlace k_quad[] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}}, k_triangle[] = {{0, 0}, {1, 0}, {0, 1}};
    return cell_corners == 4 ? k_quad[k] : k_triangle[k];
}

/// Barycentrics of a triangle in the plane.
class Barycentrics {
  public:
    explicit Barycentrics(const PieceCorners& at) : origin_(at[0]) {
        const double ax = at[1][0] - at[0][0], ay = at[1][1] - at[0][1];
        const double bx = at[2][0] - at[0][0], by = at[2][1] - at[0][1];
        const double area = ax * by - ay * bx;
        one_ = {by / area, -bx / area};
        two_ = {-ay / area, ax / area};
    }
    std::array<double, 3> operator()(const CellPlace& p) const {
        const double x = p[0] - origin_[0], y = p[1] - origin_[1];
        const double b1 = one_[0] * x + one_[1] * y, b2 = two_[0] * x + two_[1] * y;
        return {1 - b1 - b2, b1, b2};
    }

  private:
    CellPlace origin_, one_, two_;
};

}  // namespace

Covered covered(const PieceCorners& triangle, int cell_corners) {
    constexpr double k_beside = 1e-12;  // on an edge, but for rounding
    const Barycentrics barycentrics(triangle);
    Covered part;
    for (int k = 0; k < cell_corners; ++k) {
        const CellPlace p = cell_corner(k, cell_corners);
        part.add(p, barycentrics(p));
    }
    for (std::size_t side = 0; side < 3; ++side) {
        const Covered before = part;
        part.count = 0;
        for (int i = 0; i < before.count; ++i) {
            const int j = (i + 1) % before.count;
            const double here = before.b[i][side], next = before.b[j][side];
            if (here >= -k_beside)
                part.add(before.at[i], before.b[i]);
            else
                part.whole = false;
            if ((here > k_beside && next < -k_beside) || (here < -k_beside && next > k_beside)) {
                const double s = here / (here - next);
                CellPlace p;
                std::array<double, 3> b;
                for (std::size_t c = 0; c < 2; ++c) p[c] = before.at[i][c] + s * (before.at[j][c] - before.at[i][c]);
                for (std::size_t c = 0; c < 3; ++c) b[c] = before.b[i][c] + s * (before.b[j][c] - before.b[i][c]);
                part.add(p, b);
            }
        }
    }
    const auto area = [](auto&& corner, int count) {
        double sum = 0;
        for (int i = 0; i < count; ++i) {
            const CellPlace &p = corner(i), &q = corner((i + 1) % count);
            sum += p[0] * q[1] - p[1] * q[0];
        }
        return sum;
    };
    const double covered_area = area([&](int i) -> const CellPlace& { return part.at[i]; }, part.count);
    const double whole =
        std::abs(area([&](int i) -> const CellPlace& { return triangle[static_cast<std::size_t>(i)]; }, 3));
    if (!(covered_area > std::min(k_no_area, k_no_share * whole))) part.count = 0;
    return part;
}

Deviation deviation(const Covered& part, const std::array<Vec3d, 4>& corner, int cell_corners,
                    const SlidTriangle& triangle) {
    double off = 0;
    CellPlace low{1, 1}, high{0, 0};
    std::array<double, 3> least{1, 1, 1}, most{0, 0, 0};
    for (int i = 0; i < part.count; ++i) {
        const auto [x, y] = part.at[i];
        const std::array<double, 3>& b = part.b[i];
        const Vec3d p = cell_corners == 3 ? (1 - x - y) * corner[0] + x * corner[1] + y * corner[2]
                                          : (1 - y) * ((1 - x) * corner[0] + x * corner[1]) +
                                                y * ((1 - x) * corner[3] + x * corner[2]);
        off = std::max(off, glm::length(p - triangle(b)));
        for (std::size_t c = 0; c < 2; ++c) {
            low[c] = std::min(low[c], part.at[i][c]);
            high[c] = std::max(high[c], part.at[i][c]);
        }
        for (std::size_t k = 0; k < 3; ++k) {
            least[k] = std::min(least[k], b[k]);
            most[k] = std::max(most[k], b[k]);
        }
    }
    // Every point of the part is a mean of its corners, in a whole cell with the weights that its patch has; so is the
    // difference, but for what bends.
    double bend = triangle.bend({most[0] - least[0], most[1] - least[1], most[2] - least[2]});
    if (cell_corners == 4 && !part.whole)
        bend +=
            0.25 * (high[0] - low[0]) * (high[1] - low[1]) * glm::length(corner[0] - corner[1] + corner[2] - corner[3]);
    return {off, off + bend, part.whole};
}

CellPlace in_child(const CellPlace& p, int child, int cell_corners) {
    if (cell_corners == 3 && child == 3) return {1 - 2 * p[0], 1 - 2 * p[1]};
    const CellPlace base = cell_corner(child, cell_corners);
    return {2 * p[0] - base[0], 2 * p[1] - base[1]};
}

CellPlace from_next_corner(const CellPlace& p, int cell_corners) {
    return {p[1], cell_corners == 4 ? 1 - p[0] : 1 - p[0] - p[1]};
}

SlidTriangle::SlidTriangle(const std::array<Vec3d, 3>& corners, const std::array<Vec3d, 3>& middles) : corner(corners) {
    constexpr double k_most = 0.9;
    for (std::size_t k = 0; k < 3; ++k) {
        const Vec3d side = corners[(k + 1) % 3] - corners[k];
        const double squared = glm::dot(side, side);
        if (!(squared > 0)) continue;
        const double along = glm::dot(middles[k] - corners[k], side) / squared;
        slide[k] = std::clamp(4 * (along - 0.5), -k_most, k_most);
    }
}

Vec3d SlidTriangle::operator()(const std::array<double, 3>& b) const {
    Vec3d p = b[0] * corner[0] + b[1] * corner[1] + b[2] * corner[2];
    for (std::size_t k = 0; k < 3; ++k) {
        const std::size_t next = (k + 1) % 3;
        p += slide[k] * b[k] * b[next] * (corner[next] - corner[k]);
    }
    return p;
}

double SlidTriangle::bend(const std::array<double, 3>& width) const {
    // The covariance of two numbers is at most a quarter of the product of their ranges.
    double bend = 0;
    for (std::size_t k = 0; k < 3; ++k) {
        const std::size_t next = (k + 1) % 3;
        bend += 0.25 * std::abs(slide[k]) * width[k] * width[next] * glm::length(corner[next] - corner[k]);
    }
    return bend;
}

}  // namespace tetrakis
