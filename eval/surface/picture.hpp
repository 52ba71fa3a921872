#pragma once

#include "../../hier/base/run_context.hpp"

#include <cstdint>
#include <filesystem>
#include <vector>

namespace tetrakis::detail {

/// A picture as its file has it, row by row from the top.
struct Picture {
    int width = 0, height = 0;
    int channels = 0;                    ///< 1: grey, 2: and alpha, 3: red, green, blue, 4: and alpha
    bool has_16_bits = false;            ///< else all samples are v * 257
    std::vector<std::uint16_t> samples;  ///< width * height * channels
};

/// Reads PNG, JPEG, TGA, BMP, PGM and the like.
/// @throws Error io: missing or unreadable; invalid_input: no picture that can be decoded, with the reason; unsupported
Picture read_picture(const std::filesystem::path& path, const RunContext& context);

}  // namespace tetrakis::detail
