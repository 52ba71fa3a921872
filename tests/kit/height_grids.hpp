#pragma once

#include "../../eval/terrain/height_grid.hpp"

#include <array>
#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

namespace tetrakis::test {

inline HeightGrid grid_of(std::uint32_t columns, std::uint32_t rows, const auto& height) {
    HeightGrid grid{.columns = columns, .rows = rows, .heights = {}};
    for (std::uint32_t r = 0; r < rows; ++r)
        for (std::uint32_t c = 0; c < columns; ++c) grid.heights.push_back(static_cast<float>(height(c, r)));
    return grid;
}

/// Rough everywhere: waves of halved lengths, each two thirds as high as the one before.
inline HeightGrid rough(std::uint32_t columns, std::uint32_t rows, unsigned seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> angle(0, 6.28);
    std::vector<std::array<double, 3>> waves;
    for (int i = 0; i < 24; ++i) waves.push_back({angle(random), angle(random), std::pow(2.0, i / 3) / 120});
    return grid_of(columns, rows, [&](double c, double r) {
        double sum = 0;
        for (const auto& [turn, phase, rate] : waves)
            sum += std::sin(phase + 6.28 * rate * (c * std::cos(turn) + r * std::sin(turn))) / std::pow(rate, 0.6);
        return sum;
    });
}

}  // namespace tetrakis::test
