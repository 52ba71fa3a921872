#include "animated_png.hpp"

#include "../../hier/base/crc32.hpp"
#include "../../hier/base/error.hpp"
#include "../../hier/base/files.hpp"

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

namespace tetrakis {

namespace {

/// The bytes of numbers, the most significant first.
template <class... Numbers>
std::string big_endian(Numbers... numbers) {
    std::string bytes;
    const auto append = [&](auto number) {
        for (std::size_t i = sizeof(number); i-- > 0;) bytes += static_cast<char>(number >> 8 * i & 0xFF);
    };
    (append(numbers), ...);
    return bytes;
}

std::string chunk(std::string_view type, std::string_view data) {
    const std::string body = std::string(type).append(data);
    return big_endian(static_cast<std::uint32_t>(data.size())) + body +
           big_endian(detail::crc32(std::as_bytes(std::span(body))));
}

}  // namespace

void write_animated_png(AtomicFile& file, std::span<const Image> images, int frames_per_second) {
    if (images.empty() || frames_per_second < 1 || frames_per_second > 100)
        throw Error(ErrorCode::invalid_input, "an animation needs pictures, and 1 to 100 of them a second",
                    file.path());
    const auto width = static_cast<std::uint32_t>(images[0].width),
               height = static_cast<std::uint32_t>(images[0].height);
    // The encoder writes the signature, IHDR, one IDAT and IEND; a chunk has 12 bytes beside its data.
    constexpr std::size_t k_header = 8 + 12 + 13, k_end = 12;
    std::uint32_t sequence = 0;
    for (const Image& image : images) {
        if (image.width != images[0].width || image.height != images[0].height)
            throw Error(ErrorCode::invalid_input, "the pictures of an animation must have one size", file.path());
        const std::string png = encode_png(image);
        const std::string_view pixels = std::string_view(png).substr(k_header + 8, png.size() - k_header - 12 - k_end);
        if (sequence == 0) {
            constexpr std::uint32_t k_for_ever = 0;
            file.write(std::string_view(png).substr(0, k_header));
            file.write(chunk("acTL", big_endian(static_cast<std::uint32_t>(images.size()), k_for_ever)));
        }
        // Width, height, x, y; a frame lasts 1 / rate seconds, and the next one replaces it.
        file.write(chunk("fcTL", big_endian(sequence++, width, height, 0u, 0u, std::uint16_t{1},
                                            static_cast<std::uint16_t>(frames_per_second), std::uint16_t{0})));
        if (sequence == 1)
            file.write(chunk("IDAT", pixels));
        else
            file.write(chunk("fdAT", big_endian(sequence++).append(pixels)));
    }
    file.write(chunk("IEND", {}));
}

}  // namespace tetrakis
