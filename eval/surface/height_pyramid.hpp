#pragma once

#include "height_image.hpp"

#include <array>
#include <cstdint>
#include <vector>

namespace tetrakis {

/// What samples of a height image may miss: for square blocks of 2^k pixels, how far the image departs from bilinear
/// interpolation between the block's corners. A slope or a gentle wave takes a look at a few blocks, a spike is found
/// wherever it is. The image repeats (ImageWrap::repeat).
class HeightPyramid {
  public:
    /// @param image  must outlive this object. O(pixels), a third of the image's memory.
    explicit HeightPyramid(const HeightImage& image);

    const HeightImage& image() const { return image_; }

    struct Departure {
        double height = 0;                ///< of the image above the plane, negative below; 0: none was found
        std::array<double, 3> weights{};  ///< where, in barycentrics of the triangle
    };
    /// The pixel centre inside a triangle of texture space where the image departs most from the plane over its
    /// corners, if by more than `least`; or the first one found to depart by more than `enough`. Centres it is, because
    /// between them the image is bilinear. Where a triangle covers the image more than twice over, a part of it is
    /// searched.
    /// @param heights  of the plane at the corners
    Departure departure(const std::array<Vec2d, 3>& uv, const std::array<double, 3>& heights, double least,
                        double enough) const;

  private:
    struct Level {
        std::uint32_t columns = 0, rows = 0;
        std::vector<float> departure;  ///< per block, rounded up
    };
    struct Search;
    double pixel(std::uint32_t x, std::uint32_t y) const;
    void visit(Search& search, std::size_t level, std::uint32_t column, std::uint32_t row) const;

    const HeightImage& image_;
    std::uint32_t width_ = 0, height_ = 0;
    std::vector<Level> levels_;  ///< levels_[k - 1]: blocks of 2^k pixels
};

}  // namespace tetrakis
