#pragma once

#include <cstdint>
#include <string>

// What PNG files are made of.
namespace tetrakis::test {

inline std::string big_endian(std::uint32_t number) {
    std::string bytes;
    for (int shift = 24; shift >= 0; shift -= 8) bytes += static_cast<char>(number >> shift & 0xFF);
    return bytes;
}

/// The remainder of the bits, least significant first, by the polynomial of PNG's checksums; bit by bit.
inline std::uint32_t png_checksum(const std::string& bytes) {
    std::uint32_t remainder = ~0u;
    for (const char c : bytes)
        for (int bit = 0; bit < 8; ++bit) {
            const bool odd = ((remainder ^ static_cast<std::uint8_t>(c) >> bit) & 1) != 0;
            remainder = remainder >> 1 ^ (odd ? 0xEDB88320u : 0u);
        }
    return ~remainder;
}

/// @param text  the chunk's type, and what it holds
inline std::string png_chunk(const std::string& text) {
    return big_endian(static_cast<std::uint32_t>(text.size() - 4)) + text + big_endian(png_checksum(text));
}

}  // namespace tetrakis::test
