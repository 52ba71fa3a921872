#pragma once

#include "height_source.hpp"

#include <filesystem>
#include <memory>

namespace tetrakis::detail {

/// The first band of any raster that GDAL reads, in metres where its unit is feet. Samples are in the middle of pixels.
/// Places in degrees become metres about the raster's middle, with the origin at (0, 0).
/// @throws Error  unsupported: built without GDAL, or the raster's rows do not run from west to east; others as
///                load_height_grid()
std::unique_ptr<HeightSource> open_with_gdal(const std::filesystem::path& path, const HeightReadOptions& options);

}  // namespace tetrakis::detail
