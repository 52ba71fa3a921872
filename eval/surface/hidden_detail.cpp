#include "hidden_detail.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace tetrakis::detail {

Departure departure(const HeightImage& image, const std::array<Vec2d, 3>& uv, const Vec3d& heights, double least,
                    double enough) {
    Departure found;
    if (image.values.empty()) return found;
    const Vec2d size(image.width, image.height);
    // Whole turns are taken off first: pixel numbers of any finite UV then fit an integer.
    const Vec2d turns = glm::floor(glm::min(uv[0], glm::min(uv[1], uv[2])));
    std::array<Vec2d, 3> corner;  // in pixels, whose centres have whole coordinates
    for (std::size_t k = 0; k < 3; ++k) {
        corner[k] = Vec2d(uv[k].x - turns.x, turns.y - uv[k].y) * size - 0.5;
        constexpr double k_farthest = 1e12;
        if (!(std::abs(corner[k].x) < k_farthest && std::abs(corner[k].y) < k_farthest)) return found;
    }
    const Vec2d d1 = corner[1] - corner[0], d2 = corner[2] - corner[0];
    const double area = d1.x * d2.y - d1.y * d2.x;
    if (area == 0) return found;
    // Changes of the barycentrics with a step along x and along y.
    const Vec3d step = Vec3d(d1.y - d2.y, d2.y, -d1.y) / area, down = Vec3d(d2.x - d1.x, -d2.x, d1.x) / area;
    const Vec2d lower = glm::ceil(glm::min(corner[0], glm::min(corner[1], corner[2])));
    const Vec2d upper = glm::min(glm::max(corner[0], glm::max(corner[1], corner[2])), lower + 2.0 * size);
    const auto wrapped = [](double place, int length) {
        return static_cast<std::int64_t>(place - length * std::floor(place / length));
    };
    for (double y = lower.y; y <= upper.y; ++y) {
        const Vec3d at_lower = Vec3d(1, 0, 0) + (lower.x - corner[0].x) * step + (y - corner[0].y) * down;
        // The part of the row where no barycentric is negative.
        constexpr double k_rounding = 1e-9;
        double begin = 0, end = upper.x - lower.x;  // in steps from lower.x
        for (int k = 0; k < 3; ++k) {
            const double to_side = -(at_lower[k] + k_rounding) / step[k];
            if (step[k] > 0) begin = std::max(begin, std::ceil(to_side));
            if (step[k] < 0) end = std::min(end, to_side);
            if (step[k] == 0 && at_lower[k] < -k_rounding) end = -1;
        }
        if (begin > end) continue;
        const float* const row = image.values.data() + wrapped(y, image.height) * image.width;
        const double plane = glm::dot(at_lower, heights), slope = glm::dot(step, heights);
        std::int64_t column = wrapped(lower.x + begin, image.width);
        for (double x = begin; x <= end; ++x, column = column + 1 < image.width ? column + 1 : 0) {
            const double height = double{row[column]} - (plane + slope * x);
            if (std::abs(height) <= std::max(least, std::abs(found.height))) continue;
            found = {height, at_lower + x * step};
            if (std::abs(height) > enough) return found;
        }
    }
    return found;
}

}  // namespace tetrakis::detail
