#pragma once

#include "root_kernels.hpp"

#include <cstddef>
#include <cstdint>

namespace tetrakis::detail {

/// Of a row: a place of a root's grid, in numbers from that of the result, and its weight.
struct GridTerm {
    std::ptrdiff_t offset;
    double weight;
};

/// Sums of one row for `count` points side by side, three numbers each, the first at `at`; written `stride` points
/// apart.
using RowRun = void (*)(const double* at, const GridTerm* terms, std::size_t term_count, std::uint32_t count,
                        std::uint32_t stride, double* to);
/// All sets give the same bytes.
RowRun row_run(KernelSet set = best_kernels());

}  // namespace tetrakis::detail
