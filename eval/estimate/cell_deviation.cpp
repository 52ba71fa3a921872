#include "cell_deviation.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace tetrakis {

namespace {

// Parts of a cell that are no larger, and no larger a share of the piece, are corners and edges that rounding has given
// an area.
constexpr double k_no_area = 1e-12, k_no_share = 1e-6;
constexpr double k_beside = 1e-9;  // at a cell's corner, but for rounding

CellPlace cell_corner(int k, int cell_corners) {
    constexpr CellPlace k_quad[] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}}, k_triangle[] = {{0, 0}, {1, 0}, {0, 1}};
    return cell_corners == 4 ? k_quad[k] : k_triangle[k];
}

}  // namespace

Covered covered(const PieceCorners& triangle, int cell_corners) {
    detail::LabelledPolygon<PiecePoint> part(
        {{{triangle[0], {1, 0, 0}}, {triangle[1], {0, 1, 0}}, {triangle[2], {0, 0, 1}}}}, {});
    part = part.clipped([](const PiecePoint& p) { return p.at.x; }).clipped([](const PiecePoint& p) { return p.at.y; });
    if (cell_corners == 3)
        part = part.clipped([](const PiecePoint& p) { return 1 - p.at.x - p.at.y; });
    else
        part = part.clipped([](const PiecePoint& p) { return 1 - p.at.x; }).clipped([](const PiecePoint& p) {
            return 1 - p.at.y;
        });
    const auto cross = [](const CellPlace& p, const CellPlace& q) { return p.x * q.y - p.y * q.x; };
    double twice = 0;  // the area
    for (std::size_t i = 0; i < part.size(); ++i)
        twice += cross(part.corner(i).at, part.corner((i + 1) % part.size()).at);
    const double of_piece = std::abs(cross(triangle[1] - triangle[0], triangle[2] - triangle[0]));
    bool whole = part.size() == static_cast<std::size_t>(cell_corners);
    for (std::size_t i = 0; i < part.size(); ++i) {
        const CellPlace& p = part.corner(i).at;
        whole = whole && glm::length(p - glm::round(p)) < k_beside;
    }
    return {part, !(std::abs(twice) > std::min(k_no_area, k_no_share * of_piece)), whole};
}

Deviation deviation(const Covered& covered, const std::array<Vec3d, 4>& corner, int cell_corners,
                    const SlidTriangle& triangle) {
    double off = 0;
    CellPlace low(1), high(0);
    std::array<double, 3> least{1, 1, 1}, most{0, 0, 0};
    for (std::size_t i = 0; i < covered.part.size(); ++i) {
        const auto& [at, b] = covered.part.corner(i);
        const double x = at.x, y = at.y;
        const Vec3d p = cell_corners == 3 ? (1 - x - y) * corner[0] + x * corner[1] + y * corner[2]
                                          : (1 - y) * ((1 - x) * corner[0] + x * corner[1]) +
                                                y * ((1 - x) * corner[3] + x * corner[2]);
        off = std::max(off, glm::length(p - triangle(b)));
        low = glm::min(low, at);
        high = glm::max(high, at);
        for (std::size_t k = 0; k < 3; ++k) {
            least[k] = std::min(least[k], b[k]);
            most[k] = std::max(most[k], b[k]);
        }
    }
    // Every point of the part is a mean of its corners, in a whole cell with the weights that its patch has; so is the
    // difference, but for what bends.
    double bend = triangle.bend({most[0] - least[0], most[1] - least[1], most[2] - least[2]});
    if (cell_corners == 4 && !covered.whole)
        bend +=
            0.25 * (high[0] - low[0]) * (high[1] - low[1]) * glm::length(corner[0] - corner[1] + corner[2] - corner[3]);
    return {off, off + bend, covered.whole};
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
