#pragma once

#include "../../hier/base/run_context.hpp"

#include <cstdint>
#include <filesystem>
#include <vector>

namespace tetrakis::detail {

/// The samples of a picture file, row by row from the top.
struct Picture {
    int width = 0, height = 0;
    int channels = 0;                    ///< 1: grey, 2: and alpha, 3: red, green, blue, 4: and alpha
    int bits = 8;                        ///< per sample in the file: 1, 2, 4, 8 or 16 in a grey PNG, else 8 or 16
    std::vector<std::uint16_t> samples;  ///< width * height * channels; 65535 is white, whatever the bits
};

/// Reads PNG, JPEG, TGA, BMP, PGM and the like.
/// @throws Error io: missing or unreadable; invalid_input: no picture that can be decoded, with the reason; unsupported
Picture read_picture(const std::filesystem::path& path, const RunContext& context);

}  // namespace tetrakis::detail
