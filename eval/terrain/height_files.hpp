#pragma once

#include "height_source.hpp"

#include <cstdint>
#include <filesystem>
#include <memory>
#include <numbers>

namespace tetrakis::detail {

/// Metres of a degree, on a sphere with Earth's mean radius.
inline constexpr double k_metres_a_degree = 6371008.8 * std::numbers::pi / 180;

/// The format that the options say, or that the extension does.
HeightFormat format_of(const std::filesystem::path& path, const HeightReadOptions& options);

/// A grid without heights.
/// @throws Error  invalid_input: fewer than two columns or rows
HeightGrid empty_frame(std::uint64_t columns, std::uint64_t rows, const std::filesystem::path& path);

/// A height by what a format says, NaN where there is no data.
float height_of(double number, const HeightReadOptions& options);

/// The first band of any raster that GDAL reads, in metres where its unit is feet. Samples are in the middle of pixels.
/// Places in degrees become metres about the raster's middle, with the origin at (0, 0).
/// @throws Error  unsupported: built without GDAL, or the raster's rows do not run from west to east; others as
///                load_height_grid()
std::unique_ptr<HeightSource> open_with_gdal(const std::filesystem::path& path, const HeightReadOptions& options);

/// @param format  raw16, raw_float or hgt
/// @throws Error  as load_height_grid()
std::unique_ptr<HeightSource> open_raw_heights(const std::filesystem::path& path, const HeightReadOptions& options,
                                               HeightFormat format);

}  // namespace tetrakis::detail
