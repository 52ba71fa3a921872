#include "height_image.hpp"

#include "../../hier/base/crc32.hpp"
#include "../../hier/base/error.hpp"
#include "../../hier/base/files.hpp"
#include "picture.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <span>
#include <string_view>

#define STB_IMAGE_STATIC
#define STB_IMAGE_IMPLEMENTATION
#define STBI_NO_STDIO
#define STBI_NO_HDR
#define STBI_NO_GIF
#include <stb/stb_image.h>

namespace tetrakis {

namespace {

// Number of the pixel in the image that stands for pixel `i`, which is at most one outside.
int wrapped(int i, int size, ImageWrap wrap) {
    return wrap == ImageWrap::clamp ? std::clamp(i, 0, size - 1) : (i + size) % size;
}

}  // namespace

double HeightImage::sample(Vec2d uv, ImageWrap wrap) const {
    if (values.empty() || !std::isfinite(uv.x) || !std::isfinite(uv.y)) return 0;
    // Whole turns are taken off first: pixel numbers of any finite UV then fit an integer.
    const auto reduce = [&](double x) {
        return wrap == ImageWrap::repeat ? x - std::floor(x) : std::clamp(x, 0.0, 1.0);
    };
    const double x = reduce(uv.x) * width - 0.5, y = (1 - reduce(uv.y)) * height - 0.5;
    const auto column = static_cast<int>(std::floor(x)), row = static_cast<int>(std::floor(y));
    const double s = x - column, t = y - row;
    const auto at = [&](int c, int r) {
        return static_cast<double>(
            values[static_cast<std::size_t>(wrapped(r, height, wrap)) * width + wrapped(c, width, wrap)]);
    };
    const double upper = at(column, row) * (1 - s) + at(column + 1, row) * s;
    const double lower = at(column, row + 1) * (1 - s) + at(column + 1, row + 1) * s;
    return upper * (1 - t) + lower * t;
}

namespace {

/// Checks the checksums, which stb_image ignores, and finds depths below 8 bits, which it does not report.
void check_png(std::string_view bytes, detail::Picture& picture, const std::filesystem::path& path) {
    const auto number = [&](std::size_t at) {
        std::uint32_t value = 0;
        for (std::size_t i = 0; i < 4; ++i) value = value << 8 | static_cast<std::uint8_t>(bytes[at + i]);
        return value;
    };
    constexpr std::size_t k_signature = 8, k_around = 12, k_bits = 12, k_color_type = 13;
    constexpr char k_grey = 0;
    for (std::size_t at = k_signature; at + k_around <= bytes.size();) {
        const std::size_t size = number(at);
        if (size > bytes.size() - at - k_around) break;  // stb_image has not needed the rest
        const std::string_view chunk = bytes.substr(at + 4, 4 + size);
        if (detail::crc32(std::as_bytes(std::span(chunk))) != number(at + 8 + size))
            throw Error(
                ErrorCode::invalid_input,
                fmt::format("this picture is damaged: the checksum of its part {} at byte {} is wrong; copy it anew",
                            chunk.substr(0, 4), at),
                path);
        // The header is mostly, but not always the first part.
        if (chunk.starts_with("IHDR") && chunk[k_color_type] == k_grey) picture.bits = chunk[k_bits];
        at += k_around + size;
    }
}

}  // namespace

detail::Picture detail::read_picture(const std::filesystem::path& path, const RunContext& context) {
    const std::string bytes = read_file(path, context);
    if (bytes.empty()) throw Error(ErrorCode::invalid_input, "the file is empty", path);
    if (bytes.size() > static_cast<std::size_t>(std::numeric_limits<int>::max()))
        throw Error(ErrorCode::unsupported, "pictures of more than 2 GiB cannot be read", path);
    const auto* const data = reinterpret_cast<const stbi_uc*>(bytes.data());
    const auto size = static_cast<int>(bytes.size());
    Picture picture;
    // 8-bit pictures come out as v * 257, so v / 255 and v / 65535 are the same scale.
    const std::unique_ptr<stbi_us, void (*)(void*)> pixels(
        stbi_load_16_from_memory(data, size, &picture.width, &picture.height, &picture.channels, 0), stbi_image_free);
    if (!pixels)
        throw Error(
            ErrorCode::invalid_input,
            std::string("this picture is cut off, damaged or no PNG, JPEG, TGA or PGM (") + stbi_failure_reason() + ")",
            path);
    if (stbi_is_16_bit_from_memory(data, size) != 0) picture.bits = 16;
    if (bytes.starts_with("\x89PNG")) check_png(bytes, picture, path);
    const std::size_t count = static_cast<std::size_t>(picture.width) * static_cast<std::size_t>(picture.height) *
                              static_cast<std::size_t>(picture.channels);
    picture.samples.assign(pixels.get(), pixels.get() + count);
    // stb_image (2.27) hands out the 16-bit samples of PGM and PPM as they lie in the file, high byte first.
    if (bytes[0] == 'P' && picture.bits == 16)
        for (std::uint16_t& value : picture.samples)
            value = static_cast<std::uint16_t>(value >> 8 | (value & 0xFF) << 8);
    return picture;
}

HeightImage load_height_image(const std::filesystem::path& path) {
    const detail::Picture picture = detail::read_picture(path, {});
    const auto stride = static_cast<std::size_t>(picture.channels);
    HeightImage image{picture.width, picture.height, std::vector<float>(picture.samples.size() / stride)};
    const auto sample = [&](std::size_t i) { return picture.samples[i] / 65535.0f; };
    for (std::size_t i = 0; i < image.values.size(); ++i)
        image.values[i] = stride < 3 ? sample(stride * i)
                                     : std::min(1.0f, 0.299f * sample(stride * i) + 0.587f * sample(stride * i + 1) +
                                                          0.114f * sample(stride * i + 2));  // Rec. 601 luma
    return image;
}

}  // namespace tetrakis
