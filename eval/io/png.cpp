#include "png.hpp"

#include "../../hier/base/error.hpp"
#include "../../hier/base/files.hpp"

#include <fmt/format.h>

#include <cstdint>
#include <limits>
#include <new>
#include <string>

#define STB_IMAGE_WRITE_STATIC
#define STB_IMAGE_WRITE_IMPLEMENTATION
#define STBI_WRITE_NO_STDIO
#include <stb/stb_image_write.h>

namespace tetrakis {

std::string encode_png(const Image& image) {
    if (image.width <= 0 || image.height <= 0 ||
        image.rgb.size() !=
            std::size_t{3} * static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height))
        throw Error(ErrorCode::invalid_input, "a picture without pixels cannot be written");
    // stb counts the bytes, with one more for each row, in an int.
    if ((3 * std::int64_t{image.width} + 1) * image.height > std::numeric_limits<int>::max())
        throw Error(
            ErrorCode::unsupported,
            fmt::format("a PNG of {} x {} pixels would be beyond 2 GiB; make it smaller", image.width, image.height));
    std::string bytes;
    const auto collect = [](void* out, void* data, int size) {
        static_cast<std::string*>(out)->append(static_cast<const char*>(data), static_cast<std::size_t>(size));
    };
    if (stbi_write_png_to_func(collect, &bytes, image.width, image.height, 3, image.rgb.data(), 3 * image.width) == 0)
        throw std::bad_alloc();
    return bytes;
}

void write_png(AtomicFile& file, const Image& image) { file.write(encode_png(image)); }

void write_png(const std::filesystem::path& path, const Image& image) {
    AtomicFile file(path);  // before the encoding, so that a missing directory is reported at once
    write_png(file, image);
    file.commit();
}

}  // namespace tetrakis
