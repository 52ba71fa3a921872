#pragma once

#include "../../hier/base/run_context.hpp"
#include "../../hier/base/vec.hpp"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <vector>

namespace tetrakis {

/// Heights of a terrain at the points of a grid, row by row from the north, each from the west.
struct HeightGrid {
    std::uint32_t columns = 0, rows = 0;
    std::vector<float> heights;  ///< columns * rows; NaN: no data
    Vec2d spacing{1, 1};         ///< ground units between columns, between rows; positive
    Vec2d origin{0, 0};          ///< ground coordinates of sample (0, 0): x to the east, y to the north

    float at(std::uint32_t column, std::uint32_t row) const { return heights[std::size_t{row} * columns + column]; }
};

enum class HeightFormat {
    automatic,    ///< by the extension: .png, .hgt, .r16 and .raw (raw16), .r32 and .f32 (raw_float); others: gdal
    png,          ///< grey pixels, 1 to 16 bits (or colours that are all grey): their values; else: terrain_rgb
    terrain_rgb,  ///< colours of 8 bits: -10000 + 0.1 * (65536 red + 256 green + blue), metres (Mapbox's encoding)
    raw16,        ///< unsigned 16-bit numbers without a header
    raw_float,    ///< 32-bit IEEE floats without a header; values that are not finite mean no data
    hgt,          ///< SRTM: signed, 16 bits, high byte first, square; -32768 is no data
    gdal,         ///< the first band of any raster that GDAL reads, in metres, with no-data value and geotransform
};

struct HeightReadOptions {
    HeightFormat format = HeightFormat::automatic;
    std::uint32_t columns = 0, rows = 0;  ///< of raw files; 0: by the file's size, and square if both are 0
    bool big_endian = false;              ///< of raw files: high byte first
    double scale = 1, offset = 0;         ///< a height is offset + scale * the file's number
    std::optional<double> no_data{};      ///< number that means no data in the file
    std::optional<Vec2d> spacing{};  ///< instead of the file's own: an HGT's is by its name; raw files and PNGs have 1
    RunContext context{};
};

/// Reads a height grid; any number of threads may do so at once. An HGT of the name N35E138.hgt gets its spacing in
/// metres, at the middle of its rows.
/// @throws Error  io: missing or unreadable; invalid_input: no grid of that format, sizes that contradict each other,
///                fewer than two columns or rows, all samples without data; unsupported: a raster that needs GDAL
///                where the build has none, an unknown unit of height, rows that do not run from west to east;
///                memory_limit; cancelled
HeightGrid load_height_grid(const std::filesystem::path& path, const HeightReadOptions& options = {});

/// Fills samples without data smoothly with heights from their surroundings: with means over squares that are as large
/// as necessary. O(samples).
/// @return  number of samples that had no data
/// @throws Error  invalid_input: none has data
std::uint64_t fill_missing_heights(HeightGrid& grid);

namespace detail {
/// Units of grid coordinates in one sample interval.
inline constexpr std::int32_t k_grid_unit = 64;
constexpr double in_samples(std::int32_t place) { return static_cast<double>(place) / k_grid_unit; }

/// Checks that a grid's sizes, spacing and origin allow a surface.
/// @throws Error  as check_surface(), but for heights
void check_frame(const HeightGrid& grid);
/// Checks that heights, of rows from `first_row` of a grid on, are finite.
/// @param missing  the message's words for a NaN
/// @throws Error  invalid_input
void check_heights(const HeightGrid& grid, std::uint32_t first_row, const char* missing);
/// Checks that triangles can be made of a grid.
/// @throws Error  invalid_input: fewer than two columns or rows, sizes that do not match, a height that is missing or
///                infinite; unsupported: more than 2^24 columns or rows
void check_surface(const HeightGrid& grid);
}  // namespace detail

}  // namespace tetrakis
