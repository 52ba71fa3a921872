#pragma once

#include "row_runs.hpp"

// Included by one file per instruction set; nothing in it may end up in another one's code.
namespace tetrakis::detail {
namespace {

template <std::uint32_t Points>
[[gnu::always_inline]] inline void write_sums(const double* at, const GridTerm* terms, std::size_t term_count,
                                              std::uint32_t stride, double* to) {
    double sum[3 * Points] = {};
    for (std::size_t t = 0; t < term_count; ++t) {
        const double* const p = at + terms[t].offset;
        const double weight = terms[t].weight;
        for (std::uint32_t k = 0; k < 3 * Points; ++k) sum[k] += weight * p[k];
    }
    for (std::uint32_t i = 0; i < Points; ++i)
        for (std::uint32_t k = 0; k < 3; ++k) to[std::size_t{3} * i * stride + k] = sum[3 * i + k];
}

void run_row(const double* at, const GridTerm* terms, std::size_t term_count, std::uint32_t count, std::uint32_t stride,
             double* to) {
    constexpr std::uint32_t k_block = 4;  // 12 numbers, in registers
    if (count < k_block) {
        for (std::uint32_t i = 0; i < count; ++i)
            write_sums<1>(at + std::size_t{3} * i, terms, term_count, stride, to + std::size_t{3} * i * stride);
        return;
    }
    for (std::uint32_t i = 0; i < count; i += k_block) {
        // A last block that is not whole: with points before it once more.
        const std::uint32_t begin = i + k_block <= count ? i : count - k_block;
        write_sums<k_block>(at + std::size_t{3} * begin, terms, term_count, stride,
                            to + std::size_t{3} * begin * stride);
    }
}

}  // namespace
}  // namespace tetrakis::detail
