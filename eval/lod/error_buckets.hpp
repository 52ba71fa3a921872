#pragma once

#include "candidates.hpp"

#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
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
/// Of a normal positive number: 2^result is the largest power of two that is not larger.
inline int exponent_of(double x) { return static_cast<int>(std::bit_cast<std::uint64_t>(x) >> 52) - 1023; }
inline int bucket_of(double error) {
    static_assert(k_buckets_a_doubling == 4 && k_limit_bucket % 4 == 0);
    if (!(error >= edge_of(1))) return 0;
    if (error >= edge_of(Candidates::k_buckets - 1)) return Candidates::k_buckets - 1;
    // What std::log2() says, but faster and never beyond an edge.
    const int octave = 4 * exponent_of(error) + k_limit_bucket;
    return octave + (error >= edge_of(octave + 1)) + (error >= edge_of(octave + 2)) + (error >= edge_of(octave + 3));
}

}  // namespace tetrakis::detail
