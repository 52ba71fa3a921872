#include "mesh_sampling.hpp"

#include <cmath>

namespace tetrakis::detail {

namespace {

// About two milliseconds of closest points: enough to pay for the task, little enough to share evenly.
constexpr std::uint64_t k_block_samples = 4096;
// What a triangle costs beyond its inside samples, in samples: one on each of its three edges.
constexpr std::uint64_t k_triangle_overhead = 3;

// The largest whose square is a 32-bit number.
constexpr double k_most_rows = 65535;

double fraction(double x) { return x - std::floor(x); }

}  // namespace

SamplingPlan plan_samples(const std::vector<double>& areas, std::uint64_t samples) {
    SamplingPlan plan;
    for (const double area : areas) plan.area += area;
    plan.inside.resize(areas.size());
    SampleBlock block;
    std::uint64_t load = 0;
    const double density = plan.area > 0 ? static_cast<double>(samples) / plan.area : 0.0;
    for (std::uint32_t t = 0; t < areas.size(); ++t) {
        const double rows = std::clamp(std::round(std::sqrt(areas[t] * density)), 1.0, k_most_rows);
        plan.inside[t] = static_cast<std::uint32_t>(rows * rows);
        for (std::uint64_t taken = 0; taken < plan.inside[t];) {
            const std::uint64_t room = load < k_block_samples ? k_block_samples - load : 1;
            const std::uint64_t take = std::min<std::uint64_t>(room, plan.inside[t] - taken);
            if (taken == 0) load += k_triangle_overhead;
            load += take;
            taken += take;
            block.end_triangle = t + 1;
            block.end_sample = taken;
            if (load < k_block_samples) continue;
            plan.blocks.push_back(block);
            load = 0;
            const bool done = taken == plan.inside[t];
            block.first_triangle = done ? t + 1 : t;
            block.first_sample = done ? 0 : taken;
        }
    }
    if (load > 0) plan.blocks.push_back(block);
    return plan;
}

std::uint32_t rows_of(std::uint32_t inside) {
    return static_cast<std::uint32_t>(std::lround(std::sqrt(static_cast<double>(inside))));
}

std::uint32_t edge_sample_count(std::uint32_t m) { return 1 + m / 2; }

Vec2d inside_sample(std::uint64_t k, std::uint32_t m) {
    // Rows are counted from the last one, the single triangle at the third corner, which closes the square m^2.
    const std::uint64_t left = std::uint64_t{m} * m - k;
    auto rows_left = static_cast<std::uint64_t>(std::sqrt(static_cast<double>(left)));
    while (rows_left * rows_left < left) ++rows_left;
    while (rows_left > 1 && (rows_left - 1) * (rows_left - 1) >= left) --rows_left;
    const std::uint64_t row = m - rows_left;
    std::uint64_t column = rows_left * rows_left - left;
    if (row % 2 == 1) column = 2 * rows_left - 2 - column;  // there and back
    // 1/g and 1/g^2 of g^3 = g + 1.
    constexpr double k_step_u = 0.75487766624669276005, k_step_v = 0.56984029099805326591;
    Vec2d at(1.0 / 3, 1.0 / 3);
    if (m > 1) {
        at = Vec2d(fraction(at.x + static_cast<double>(k) * k_step_u),
                   fraction(at.y + static_cast<double>(k) * k_step_v));
        if (at.x + at.y > 1) at = Vec2d(1) - at;
    }
    const Vec2d cell(static_cast<double>(column / 2), static_cast<double>(row));
    return (column % 2 == 0 ? cell + at : cell + Vec2d(1) - at) / static_cast<double>(m);
}

double edge_sample(std::uint32_t k, bool lower) {
    constexpr double k_golden = 0.61803398874989484820;
    // 0.382 is where the sequence that starts at the middle leaves its largest gap longest.
    return fraction((lower ? 0.5 : 0.381966011250105) + k * k_golden);
}

}  // namespace tetrakis::detail
