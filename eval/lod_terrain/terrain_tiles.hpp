#pragma once

#include "../../hier/base/run_context.hpp"
#include "../terrain/height_source.hpp"

#include <cstdint>
#include <filesystem>
#include <optional>

namespace tetrakis::lod {

struct TileOptions {
    std::uint32_t side = 256;               ///< steps of a tile: a power of two from 16 to 1024
    std::optional<float> missing_height{};  ///< where there is no data
    RunContext context{};
};

/// Writes the file that a TiledTerrain reads: the heights on every level of detail, with errors and lowest and highest
/// heights. The file appears complete or not at all. Several threads may write different files at once.
/// @throws Error  invalid_input: as check_surface() in height_grid.hpp, or a side out of range; unsupported: more than
///                2^24 columns or rows; io; cancelled; and what the source throws
/// Cost: O(samples) time, by all threads of the context; some 1 KiB of memory a column, and 10 MiB a thread. The file
/// has about 11.5 bytes a sample.
void write_tiles(HeightSource& source, const std::filesystem::path& path, const TileOptions& options = {});

}  // namespace tetrakis::lod
