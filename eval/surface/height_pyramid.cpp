#include "height_pyramid.hpp"

#include "../../hier/base/parallel.hpp"
#include "local_frame.hpp"

#include <algorithm>
#include <cmath>

namespace tetrakis {

// All in pixels: the centre of pixel (x, y) of the image's copy (i, j) stands at (x + i width, y + j height).
struct HeightPyramid::Search {
    Vec2d origin;                     // corner 0 of the triangle
    Vec2d to_b1, to_b2;               // gradients of the barycentrics
    std::array<double, 3> heights;    // of the plane
    std::int64_t first[2], last[2];   // centres looked at
    std::int64_t offset[2] = {0, 0};  // of the copy of the image being searched
    double least, enough;
    Departure found;

    std::array<double, 3> weights(std::int64_t x, std::int64_t y) const {
        const Vec2d d = Vec2d(static_cast<double>(x), static_cast<double>(y)) - origin;
        const double b1 = glm::dot(to_b1, d), b2 = glm::dot(to_b2, d);
        return {1 - b1 - b2, b1, b2};
    }
    double plane(const std::array<double, 3>& b) const {
        return b[0] * heights[0] + b[1] * heights[1] + b[2] * heights[2];
    }
    bool done() const { return std::abs(found.height) > enough; }
};

HeightPyramid::HeightPyramid(const HeightImage& image)
    : image_(image),
      width_(image.values.empty() ? 0 : static_cast<std::uint32_t>(image.width)),
      height_(image.values.empty() ? 0 : static_cast<std::uint32_t>(image.height)) {
    for (std::uint32_t size = 2; size / 2 < std::max(width_, height_); size *= 2) {
        Level level;
        level.columns = (width_ - 1) / size + 1;
        level.rows = (height_ - 1) / size + 1;
        level.departure.resize(std::size_t{level.columns} * level.rows);
        const Level* below = levels_.empty() ? nullptr : &levels_.back();
        for_each_index(
            level.rows,
            [&](std::uint32_t row) {
                for (std::uint32_t column = 0; column < level.columns; ++column) {
                    const std::uint32_t x0 = column * size, x1 = std::min(x0 + size, width_), xm = x0 + size / 2;
                    const std::uint32_t y0 = row * size, y1 = std::min(y0 + size, height_), ym = y0 + size / 2;
                    const double h[2][2] = {{pixel(x0, y0), pixel(x1, y0)}, {pixel(x0, y1), pixel(x1, y1)}};
                    // The quarters' corners against this block's interpolation; inside them, their own departure more.
                    double largest = 0;
                    for (const std::uint32_t y : {y0, std::min(ym, y1), y1})
                        for (const std::uint32_t x : {x0, std::min(xm, x1), x1}) {
                            const double s = static_cast<double>(x - x0) / (x1 - x0);
                            const double t = static_cast<double>(y - y0) / (y1 - y0);
                            const double between =
                                (1 - t) * ((1 - s) * h[0][0] + s * h[0][1]) + t * ((1 - s) * h[1][0] + s * h[1][1]);
                            largest = std::max(largest, std::abs(pixel(x, y) - between));
                        }
                    double inside = 0;
                    if (below)
                        for (std::uint32_t r = 2 * row; r < std::min(2 * row + 2, below->rows); ++r)
                            for (std::uint32_t c = 2 * column; c < std::min(2 * column + 2, below->columns); ++c)
                                inside =
                                    std::max<double>(inside, below->departure[std::size_t{r} * below->columns + c]);
                    level.departure[std::size_t{row} * level.columns + column] = detail::round_up(largest + inside);
                }
            },
            16);
        levels_.push_back(std::move(level));
    }
}

double HeightPyramid::pixel(std::uint32_t x, std::uint32_t y) const {
    return image_.values[std::size_t{y == height_ ? 0 : y} * width_ + (x == width_ ? 0 : x)];
}

void HeightPyramid::visit(Search& search, std::size_t level, std::uint32_t column, std::uint32_t row) const {
    const std::uint32_t x0 = column << level, y0 = row << level;
    const std::uint32_t x1 = std::min(x0 + (1u << level), width_), y1 = std::min(y0 + (1u << level), height_);
    const std::int64_t left = search.offset[0] + x0, top = search.offset[1] + y0;
    if (left > search.last[0] || search.offset[0] + x1 <= search.first[0] || top > search.last[1] ||
        search.offset[1] + y1 <= search.first[1])
        return;
    if (level == 0) {
        const std::array<double, 3> b = search.weights(left, top);
        constexpr double k_rounding = -1e-9;
        if (*std::min_element(b.begin(), b.end()) < k_rounding) return;
        const double height = pixel(x0, y0) - search.plane(b);
        if (std::abs(height) > std::max(search.least, std::abs(search.found.height))) search.found = {height, b};
        return;
    }
    double largest = 0;
    for (const std::uint32_t y : {y0, y1})
        for (const std::uint32_t x : {x0, x1})
            largest = std::max(
                largest,
                std::abs(pixel(x, y) - search.plane(search.weights(search.offset[0] + x, search.offset[1] + y))));
    const Level& blocks = levels_[level - 1];
    largest += blocks.departure[std::size_t{row} * blocks.columns + column];
    if (largest <= std::max(search.least, std::abs(search.found.height))) return;
    const std::uint32_t half = 1u << (level - 1);
    for (std::uint32_t r = 0; r < 2; ++r)
        for (std::uint32_t c = 0; c < 2; ++c)
            if (x0 + c * half < width_ && y0 + r * half < height_ && !search.done())
                visit(search, level - 1, 2 * column + c, 2 * row + r);
}

HeightPyramid::Departure HeightPyramid::departure(const std::array<Vec2d, 3>& uv, const std::array<double, 3>& heights,
                                                  double least, double enough) const {
    Search search{};
    if (width_ == 0) return search.found;
    // Whole turns are taken off first: pixel numbers of any finite UV then fit an integer.
    const Vec2d turns = glm::floor(glm::min(uv[0], glm::min(uv[1], uv[2])));
    std::array<Vec2d, 3> corner;
    for (std::size_t k = 0; k < 3; ++k) {
        corner[k] = {(uv[k].x - turns.x) * width_ - 0.5, -(uv[k].y - turns.y) * height_ - 0.5};
        constexpr double k_farthest = 1e12;
        if (!(std::abs(corner[k].x) < k_farthest && std::abs(corner[k].y) < k_farthest)) return search.found;
    }
    const Vec2d d1 = corner[1] - corner[0], d2 = corner[2] - corner[0];
    const double area = d1.x * d2.y - d1.y * d2.x;
    if (area == 0) return search.found;
    search.origin = corner[0];
    search.to_b1 = Vec2d(d2.y, -d2.x) / area;
    search.to_b2 = Vec2d(-d1.y, d1.x) / area;
    search.heights = heights;
    search.least = least;
    search.enough = enough;
    const Vec2d lower = glm::min(corner[0], glm::min(corner[1], corner[2]));
    const Vec2d upper = glm::max(corner[0], glm::max(corner[1], corner[2]));
    std::int64_t copies[2][2];
    for (int axis = 0; axis < 2; ++axis) {
        search.first[axis] = static_cast<std::int64_t>(std::ceil(lower[axis]));
        search.last[axis] = static_cast<std::int64_t>(std::floor(upper[axis]));
        if (search.first[axis] > search.last[axis]) return search.found;
        const double size = axis == 0 ? width_ : height_;
        copies[axis][0] = static_cast<std::int64_t>(std::floor(static_cast<double>(search.first[axis]) / size));
        copies[axis][1] = std::min(static_cast<std::int64_t>(std::floor(static_cast<double>(search.last[axis]) / size)),
                                   copies[axis][0] + 1);
    }
    for (std::int64_t j = copies[1][0]; j <= copies[1][1]; ++j)
        for (std::int64_t i = copies[0][0]; i <= copies[0][1] && !search.done(); ++i) {
            search.offset[0] = i * width_;
            search.offset[1] = j * height_;
            visit(search, levels_.size(), 0, 0);
        }
    return search.found;
}

}  // namespace tetrakis
