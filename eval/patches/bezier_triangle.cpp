#include "bezier_triangle.hpp"

#include "../triangles/avx2.hpp"

#include <cstring>
#include <iterator>

namespace tetrakis::detail {

template <int Degree>
TETRAKIS_FOR_AVX2_TOO BezierTriangle<Degree> combined(
    std::span<const Vec3d> points, std::span<const typename BezierTriangle<Degree>::Coordinates> weights) {
    using Lanes [[gnu::vector_size(BezierTriangle<Degree>::k_lanes * sizeof(double))]] = double;
    BezierTriangle<Degree> result;
    for (std::size_t k = 0; k < 3; ++k) {
        Lanes sum[sizeof(result.c[k]) / sizeof(Lanes)] = {};  // stays in registers
        for (std::size_t p = 0; p < points.size(); ++p)
            for (std::size_t i = 0; i < std::size(sum); ++i) {
                Lanes weight;
                std::memcpy(&weight, &weights[p][i * result.k_lanes], sizeof(weight));
                sum[i] += (&points[p].x)[k] * weight;
            }
        std::memcpy(&result.c[k], sum, sizeof(sum));
    }
    return result;
}

template BezierTriangle<1> combined(std::span<const Vec3d>, std::span<const BezierTriangle<1>::Coordinates>);
template BezierTriangle<4> combined(std::span<const Vec3d>, std::span<const BezierTriangle<4>::Coordinates>);
template BezierTriangle<6> combined(std::span<const Vec3d>, std::span<const BezierTriangle<6>::Coordinates>);

}  // namespace tetrakis::detail
