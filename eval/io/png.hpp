#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace tetrakis {

class AtomicFile;  // hier/base/files.hpp

/// An 8-bit RGB picture, row by row from the top.
struct Image {
    int width = 0, height = 0;
    std::vector<std::uint8_t> rgb;  ///< 3 * width * height
};

/// Writes a PNG; it appears whole or not at all. @throws Error io; as encode_png()
void write_png(const std::filesystem::path& path, const Image& image);
/// The same into a file that the caller commits.
void write_png(AtomicFile& file, const Image& image);

/// The bytes of a PNG. @throws Error invalid_input: a picture without pixels; unsupported: pixels of more than 2 GiB
std::string encode_png(const Image& image);

}  // namespace tetrakis
