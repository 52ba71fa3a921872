#pragma once

#include "height_source.hpp"

#include <cstdint>
#include <filesystem>
#include <memory>
#include <numbers>

namespace tetrakis::detail {

/// Metres of a degree, on a sphere with Earth's mean radius.
inline constexpr double k_metres_a_degree = 6371008.8 * std::numbers::pi / 180;

/// The format by the options, or if automatic by the extension.
HeightFormat format_of(const std::filesystem::path& path, const HeightReadOptions& options);

/// A grid without heights.
/// @throws Error  invalid_input: fewer than two columns or rows; unsupported: more than 2^24
HeightGrid empty_frame(std::uint64_t columns, std::uint64_t rows, const std::filesystem::path& path);

/// The height for a number in a file, by scale and offset; NaN where there is no data.
float height_of(double number, const HeightReadOptions& options);

/// The first band of any raster that GDAL reads, converted to metres from the band's unit. Samples are in the middle of
/// pixels. Spacings in degrees become metres at the raster's middle, and the origin is then (0, 0).
/// @throws Error  unsupported: built without GDAL, or the raster's rows do not run from west to east; others as
///                load_height_grid()
std::unique_ptr<HeightSource> open_with_gdal(const std::filesystem::path& path, const HeightReadOptions& options);

/// @param format  raw16, raw_float or hgt
/// @throws Error  as load_height_grid()
std::unique_ptr<HeightSource> open_raw_heights(const std::filesystem::path& path, const HeightReadOptions& options,
                                               HeightFormat format);

}  // namespace tetrakis::detail
