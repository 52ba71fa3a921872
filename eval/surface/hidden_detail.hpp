#pragma once

#include "height_image.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>
#include <vector>

namespace tetrakis::detail {

/// A height image with the least and the largest value of each piece of its rows. The image must outlive it.
struct HeightRanges {
    static constexpr int k_piece = 64;  ///< pixels

    /// O(pixels); takes a 32nd of the image's memory.
    explicit HeightRanges(const HeightImage& heights);

    const HeightImage& image;
    std::size_t pieces;  ///< of a row
    std::vector<std::array<float, 2>> range;
};

struct Departure {
    double height = 0;  ///< of the image above the plane, negative below; 0: none was found
    Vec3d weights{};    ///< of its point: barycentrics of the triangle
};
/// The pixel centre inside a triangle of texture space where the image, which repeats, departs most from the plane over
/// the triangle's corners, if by more than `least`; or the first one found to depart by more than `enough`. Centres
/// suffice, because the image is bilinear between them. If a triangle covers the image more than twice over, only a
/// part of the triangle is searched. Cost: O(pixels in the triangle), a 64th of it where the image is flat.
Departure departure(const HeightRanges& heights, const std::array<Vec2d, 3>& uv, const Vec3d& corner_heights,
                    double least, double enough);

/// A point of a displaced surface, with the normal and UV of the surface that is displaced.
struct DisplacedSample {
    Vec3d position, normal;
    Vec2d uv;
};

/// The error of a leaf with the height image's pixels between its samples. Looks for the largest error at these pixels,
/// or for one above the tolerance.
/// @param samples    (n + 1)(n + 2) / 2 points of a triangle, in rows of 1, 2, ..., n + 1
/// @param error      of the samples, in the unit of the model
/// @param tolerance  0: the largest error is wanted
/// @param distance   double distance(point): to the triangles that stand for the surface
/// @return `error`, or the larger error that was found
template <class Distance>
double with_hidden_detail(const HeightRanges& heights, double amplitude, int n,
                          std::span<const DisplacedSample> samples, double error, double tolerance,
                          Distance&& distance) {
    if (amplitude == 0) return error;
    // A pixel's height above the plane of the samples around it adds to the error of these samples. Heights below this
    // share of the tolerance are not searched for.
    constexpr double k_least_share = 0.25;
    const auto look = [&](std::size_t a, std::size_t b, std::size_t c) {
        const DisplacedSample* corner[3] = {&samples[a], &samples[b], &samples[c]};
        const double least = tolerance > 0 ? std::max(tolerance - error, k_least_share * tolerance) : error;
        const double enough = tolerance > 0 ? 2 * tolerance : std::numeric_limits<double>::infinity();
        std::array<Vec2d, 3> uv;
        Vec3d height(0);
        for (int k = 0; k < 3; ++k) {
            uv[k] = corner[k]->uv;
            height[k] = heights.image.sample(uv[k]);
        }
        const auto found = departure(heights, uv, height, least / std::abs(amplitude), enough / std::abs(amplitude));
        if (found.height == 0) return;
        Vec3d point(0), normal(0);
        for (int k = 0; k < 3; ++k) {
            point += found.weights[k] * corner[k]->position;
            normal += found.weights[k] * corner[k]->normal;
        }
        const double length = glm::length(normal);
        if (length > 0) error = std::max(error, distance(point + amplitude * found.height / length * normal));
    };
    for (int row = 0; row < n; ++row)
        for (int i = 0; i <= row; ++i) {
            const auto above = static_cast<std::size_t>(row * (row + 1) / 2 + i);
            const std::size_t below = above + static_cast<std::size_t>(row) + 1;
            if (tolerance > 0 && error > tolerance) return error;
            look(above, below, below + 1);
            if (i < row) look(above, below + 1, above + 1);
        }
    return error;
}

}  // namespace tetrakis::detail
