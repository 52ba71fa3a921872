#pragma once

#include "../../hier/base/vec.hpp"

#include <glm/common.hpp>

#include <cmath>
#include <cstdint>

namespace tetrakis::detail {

/// Sample k of m^2 inside a triangle, as weights (u, v) of its second and third corner. The triangle is cut into m^2
/// equal ones with one sample each. For m = 1 it is the centroid; else the R2 sequence (M. Roberts 2018, generalised
/// golden ratio) places it, so that regular patterns cannot hide between samples. Consecutive samples are in
/// neighbouring parts.
inline Vec2d inside_sample(std::uint64_t k, std::uint32_t m) {
    // Rows are counted from the last one, the single triangle at the third corner, which closes the square m^2.
    const std::uint64_t left = std::uint64_t{m} * m - k;
    auto rows_left = static_cast<std::uint64_t>(std::sqrt(static_cast<double>(left)));
    while (rows_left * rows_left < left) ++rows_left;
    while (rows_left > 1 && (rows_left - 1) * (rows_left - 1) >= left) --rows_left;
    const std::uint64_t row = m - rows_left;
    std::uint64_t column = rows_left * rows_left - left;
    if (row % 2 == 1) column = 2 * rows_left - 2 - column;  // odd rows run backwards
    // 1/g and 1/g^2 of g^3 = g + 1.
    constexpr double k_step_u = 0.75487766624669276005, k_step_v = 0.56984029099805326591;
    Vec2d at(1.0 / 3, 1.0 / 3);
    if (m > 1) {
        at = Vec2d(glm::fract(at.x + static_cast<double>(k) * k_step_u),
                   glm::fract(at.y + static_cast<double>(k) * k_step_v));
        if (at.x + at.y > 1) at = Vec2d(1) - at;
    }
    const Vec2d cell(static_cast<double>(column / 2), static_cast<double>(row));
    return (column % 2 == 0 ? cell + at : cell + Vec2d(1) - at) / static_cast<double>(m);
}

}  // namespace tetrakis::detail
