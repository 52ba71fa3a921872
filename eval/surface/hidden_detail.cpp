#include "hidden_detail.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace tetrakis::detail {

HeightRanges::HeightRanges(const HeightImage& heights)
    : image(heights), pieces((static_cast<std::size_t>(heights.width) + k_piece - 1) / k_piece) {
    for (auto at = image.values.begin(); at != image.values.end();)
        for (int left = image.width; left > 0; left -= k_piece) {
            const auto end = at + std::min(left, k_piece);
            const auto [low, high] = std::minmax_element(at, end);
            range.push_back({*low, *high});
            at = end;
        }
}

Departure departure(const HeightRanges& of, const std::array<Vec2d, 3>& uv, const Vec3d& corner_heights, double least,
                    double enough) {
    const HeightImage& image = of.image;
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
        const auto row = static_cast<std::size_t>(wrapped(y, image.height));
        const float* const values = image.values.data() + row * static_cast<std::size_t>(image.width);
        const double plane = glm::dot(at_lower, corner_heights), slope = glm::dot(step, corner_heights);
        std::int64_t column = wrapped(lower.x + begin, image.width);
        for (double x = begin; x <= end;) {
            const std::int64_t piece = column / HeightRanges::k_piece,
                               next = std::min<std::int64_t>((piece + 1) * HeightRanges::k_piece, image.width);
            const double last = std::min(std::floor(end), x + static_cast<double>(next - column - 1));
            const auto [low, high] = of.range[row * of.pieces + static_cast<std::size_t>(piece)];
            const auto [lowest, highest] = std::minmax({plane + slope * x, plane + slope * last});
            const bool may_depart = std::max(high - lowest, highest - low) > std::max(least, std::abs(found.height));
            for (; may_depart && x <= last; ++x, ++column) {
                const double height = double{values[column]} - (plane + slope * x);
                if (std::abs(height) <= std::max(least, std::abs(found.height))) continue;
                found = {height, at_lower + x * step};
                if (std::abs(height) > enough) return found;
            }
            x = last + 1;
            column = next < image.width ? next : 0;
        }
    }
    return found;
}

}  // namespace tetrakis::detail
