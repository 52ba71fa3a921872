#pragma once

#include "height_grid.hpp"

#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>

namespace tetrakis {

/// A height grid that need not be in memory: its rows are read a few at a time. A source is for one thread at a time.
class HeightSource {
  public:
    virtual ~HeightSource() = default;

    /// The grid, without its heights.
    virtual const HeightGrid& frame() const = 0;
    /// @param heights  receives count * columns of them; NaN: no data
    /// @throws Error  io, invalid_input
    virtual void read(std::uint32_t first_row, std::uint32_t count, std::span<float> heights) = 0;
};

/// Source of a grid in memory, which must outlive the result.
std::unique_ptr<HeightSource> make_height_source(const HeightGrid& grid);

/// Source of a file: raw numbers, HGT and GDAL's rasters are read row by row on demand, PNGs at once.
/// @throws Error  as load_height_grid()
std::unique_ptr<HeightSource> open_height_source(const std::filesystem::path& path,
                                                 const HeightReadOptions& options = {});

}  // namespace tetrakis
