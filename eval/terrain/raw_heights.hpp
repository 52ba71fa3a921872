#pragma once

#include "height_source.hpp"

#include <cstdint>
#include <filesystem>
#include <memory>

namespace tetrakis::detail {

/// The format that the options say, or that the extension does.
HeightFormat format_of(const std::filesystem::path& path, const HeightReadOptions& options);

/// A grid without heights.
/// @throws Error  invalid_input: fewer than two columns or rows
HeightGrid empty_frame(std::uint64_t columns, std::uint64_t rows, const std::filesystem::path& path);

/// A height by what a format says, NaN where there is no data.
float height_of(double number, const HeightReadOptions& options);

/// @param format  raw16, raw_float or hgt
/// @throws Error  as load_height_grid()
std::unique_ptr<HeightSource> open_raw_heights(const std::filesystem::path& path, const HeightReadOptions& options,
                                               HeightFormat format);

}  // namespace tetrakis::detail
