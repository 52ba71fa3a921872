#pragma once

#include "height_grid.hpp"

#include <cstdint>
#include <filesystem>

namespace tetrakis::detail {

/// A grid without heights yet.
/// @throws Error  invalid_input: fewer than two columns or rows; memory_limit
HeightGrid empty_grid(std::uint64_t columns, std::uint64_t rows, const std::filesystem::path& path,
                      const RunContext& context);

/// The first band of any raster that GDAL reads, in metres where its unit is feet. Samples are in the middle of pixels.
/// Places in degrees become metres about the raster's middle, with the origin at (0, 0).
/// @throws Error  unsupported: built without GDAL, or the raster's rows do not run from west to east; others as
///                load_height_grid()
HeightGrid read_with_gdal(const std::filesystem::path& path, const HeightReadOptions& options);

}  // namespace tetrakis::detail
