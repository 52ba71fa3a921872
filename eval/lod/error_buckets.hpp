#pragma once

#include "candidates.hpp"

#include <array>
#include <cmath>
#include <cstddef>
#include <limits>

namespace tetrakis::detail {

// Errors are counted in multiples of the budget's pixels, four buckets to a doubling.
inline constexpr int k_buckets_a_doubling = 4, k_limit_bucket = 48;
/// Errors of a bucket are from its edge on and below the next one's.
inline const std::array<double, Candidates::k_buckets + 1> k_edges = [] {
    std::array<double, Candidates::k_buckets + 1> edges{};
    for (int i = 1; i < Candidates::k_buckets; ++i)
        edges[i] = std::exp2(double(i - k_limit_bucket) / k_buckets_a_doubling);
    edges.back() = std::numeric_limits<double>::infinity();
    return edges;
}();
inline double edge_of(int bucket) { return k_edges[static_cast<std::size_t>(bucket)]; }
inline int bucket_of(double error) {
    static_assert(k_buckets_a_doubling == 4 && k_limit_bucket % 4 == 0);
    if (!(error >= edge_of(1))) return 0;
    if (error >= edge_of(Candidates::k_buckets - 1)) return Candidates::k_buckets - 1;
    // What std::log2() says, but faster and never beyond an edge.
    const int octave = 4 * std::ilogb(error) + k_limit_bucket;
    if (octave < 0) return error >= edge_of(2) ? error >= edge_of(3) ? 3 : 2 : 1;
    return octave + (error >= edge_of(octave + 1)) + (error >= edge_of(octave + 2)) + (error >= edge_of(octave + 3));
}

}  // namespace tetrakis::detail
