#pragma once

#include "../../hier/base/vec.hpp"

#include <cstdint>
#include <span>
#include <vector>

namespace tetrakis::detail {

/// A stretch of the samples of a mesh: from sample `first_sample` of triangle `first_triangle` to the same of the end.
struct SampleBlock {
    std::uint32_t first_triangle = 0, end_triangle = 0;  ///< triangles touched: [first, end)
    std::uint64_t first_sample = 0, end_sample = 0;      ///< in the first and in the last triangle
};

/// How many samples each triangle gets, and how they are cut into blocks of about equal work.
struct SamplingPlan {
    std::vector<std::uint32_t> inside;  ///< samples inside triangle t: a square number
    std::vector<SampleBlock> blocks;
    double area = 0;
};

/// @param areas  one per triangle
SamplingPlan plan_samples(const std::vector<double>& areas, std::uint64_t samples);

/// Side of the square number `inside`.
std::uint32_t rows_of(std::uint32_t inside);

/// Samples on one side of an edge of a triangle with m^2 samples inside: as dense along as the inside is across.
std::uint32_t edge_sample_count(std::uint32_t m);

/// Sample k of the m^2 inside a triangle, as weights (u, v) of its second and third corner: the triangle is cut into
/// m^2 equal ones, and each holds one sample; for m = 1 the centroid, else placed in it by the R2 sequence (M. Roberts
/// 2018, generalised golden ratio) so that no regular pattern can hide between the samples. Consecutive samples are
/// neighbours.
Vec2d inside_sample(std::uint64_t k, std::uint32_t m);

/// Sample k on an edge as a fraction of it. The two sides of an edge get different ones; `lower` starts at the middle.
double edge_sample(std::uint32_t k, bool lower);

}  // namespace tetrakis::detail
