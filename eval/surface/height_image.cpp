#include "height_image.hpp"

#include "../../hier/base/error.hpp"
#include "../../hier/base/files.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>

#if defined(__GNUC__)
#    pragma GCC diagnostic push
#    pragma GCC diagnostic ignored "-Wunused-function"
#    pragma GCC diagnostic ignored "-Wmissing-field-initializers"
#endif
#define STB_IMAGE_STATIC
#define STB_IMAGE_IMPLEMENTATION
#define STBI_NO_STDIO
#define STBI_NO_HDR
#define STBI_NO_GIF
#include <stb/stb_image.h>
#if defined(__GNUC__)
#    pragma GCC diagnostic pop
#endif

namespace tetrakis {

namespace {

// The number of the pixel `i` when the image goes on beyond its edge.
int wrapped(long long i, int size, ImageWrap wrap) {
    if (wrap == ImageWrap::clamp) return static_cast<int>(std::clamp<long long>(i, 0, size - 1));
    const long long rest = i % size;
    return static_cast<int>(rest < 0 ? rest + size : rest);
}

}  // namespace

double HeightImage::sample(Vec2d uv, ImageWrap wrap) const {
    if (values.empty() || !std::isfinite(uv.x) || !std::isfinite(uv.y)) return 0;
    // Whole turns are taken off first: pixel numbers of any finite UV then fit an integer.
    const auto reduce = [&](double x) {
        return wrap == ImageWrap::repeat ? x - std::floor(x) : std::clamp(x, 0.0, 1.0);
    };
    const double x = reduce(uv.x) * width - 0.5, y = (1 - reduce(uv.y)) * height - 0.5;
    const auto column = static_cast<long long>(std::floor(x)), row = static_cast<long long>(std::floor(y));
    const double s = x - static_cast<double>(column), t = y - static_cast<double>(row);
    const auto at = [&](long long c, long long r) {
        return static_cast<double>(
            values[static_cast<std::size_t>(wrapped(r, height, wrap)) * width + wrapped(c, width, wrap)]);
    };
    const double upper = at(column, row) * (1 - s) + at(column + 1, row) * s;
    const double lower = at(column, row + 1) * (1 - s) + at(column + 1, row + 1) * s;
    return upper * (1 - t) + lower * t;
}

HeightImage load_height_image(const std::filesystem::path& path) {
    const std::string bytes = detail::read_file(path);
    if (bytes.empty()) throw Error(ErrorCode::invalid_input, "the file is empty", path);
    if (bytes.size() > static_cast<std::size_t>(std::numeric_limits<int>::max()))
        throw Error(ErrorCode::unsupported, "pictures of more than 2 GiB cannot be read", path);
    HeightImage image;
    int channels = 0;
    // 8-bit pictures come out as v * 257, so v / 255 and v / 65535 are the same scale.
    const std::unique_ptr<stbi_us, void (*)(void*)> pixels(
        stbi_load_16_from_memory(reinterpret_cast<const stbi_uc*>(bytes.data()), static_cast<int>(bytes.size()),
                                 &image.width, &image.height, &channels, 0),
        stbi_image_free);
    if (!pixels)
        throw Error(
            ErrorCode::invalid_input,
            std::string("cannot decode this picture (") + stbi_failure_reason() + "); use PNG, JPEG, TGA or PGM", path);
    const std::size_t count = static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height);
    image.values.resize(count);
    // stb_image (2.27) hands out the 16-bit samples of PGM and PPM as they lie in the file, high byte first.
    const auto* data = reinterpret_cast<const stbi_uc*>(bytes.data());
    const bool swapped = bytes[0] == 'P' && stbi_is_16_bit_from_memory(data, static_cast<int>(bytes.size())) != 0;
    const auto sample = [&](std::size_t i) {
        const unsigned value = pixels.get()[i];
        return (swapped ? (value >> 8 | (value & 0xFF) << 8) : value) / 65535.0f;
    };
    const auto stride = static_cast<std::size_t>(channels);
    for (std::size_t i = 0; i < count; ++i)
        image.values[i] = channels < 3 ? sample(stride * i)
                                       : std::min(1.0f, 0.299f * sample(stride * i) + 0.587f * sample(stride * i + 1) +
                                                            0.114f * sample(stride * i + 2));  // Rec. 601 luma
    return image;
}

}  // namespace tetrakis
