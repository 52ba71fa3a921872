#pragma once

#include "../../hier/base/vec.hpp"

#include <filesystem>
#include <vector>

namespace tetrakis {

/// How an image goes on outside of its edges.
enum class ImageWrap {
    repeat,  ///< by copies of itself, so that u = 0 and u = 1 are the same point: OBJ's and glTF's default
    clamp,   ///< with the values of its outermost pixels
};

/// Heights in [0, 1], row by row from the top.
struct HeightImage {
    int width = 0, height = 0;
    std::vector<float> values;  ///< width * height

    /// Bilinear sample. (0, 0) is the lower left corner of the image and (1, 1) the upper right one; pixel centres lie
    /// at (i + 1/2) / width, so neighbouring pixels are blended half-way between their centres. 0 for an empty image.
    double sample(Vec2d uv, ImageWrap wrap = ImageWrap::repeat) const;
};

/// Reads PNG (8 and 16 bits), JPEG, TGA, BMP, PGM and the like; colours become their luma, alpha is ignored.
/// @throws Error io: missing or unreadable; invalid_input: no picture that can be decoded, with the reason; unsupported
HeightImage load_height_image(const std::filesystem::path& path);

}  // namespace tetrakis
