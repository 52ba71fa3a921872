#include "commands.hpp"
#include "console.hpp"
#include "files.hpp"
#include "report.hpp"
#include "run_options.hpp"

#include "../../eval/io/mesh_writer.hpp"
#include "../../eval/lod_terrain/terrain_tiles.hpp"
#include "../../eval/terrain/height_grid.hpp"
#include "../../eval/terrain/height_source.hpp"
#include "../../eval/terrain/terrain_mesh.hpp"
#include "../../hier/base/files.hpp"
#include "../../hier/base/memory.hpp"
#include "../../hier/base/version.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace tetrakis::cli {
namespace {

struct TerrainCommandOptions {
    HeightInput heights;
    std::filesystem::path output, report;
    double max_error = 0;
    bool y_up = false, normals = false;
    std::optional<std::array<int, 2>> tiles;  ///< across, down
    RunOptions run;

    /// The file of a tile: the output with _ROW_COLUMN before its extension.
    std::filesystem::path tile_path(const std::string& row, const std::string& column) const {
        std::filesystem::path path = output;
        return path.replace_filename(
            fmt::format("{}_{}_{}{}", output.stem().string(), row, column, output.extension().string()));
    }
};

/// Bound on the vertical error that writing adds. The floats of a GLB are relative to a local origin; a horizontal
/// error of a vertex counts times the slope.
double rounding_of(const std::filesystem::path& output, const HeightGrid& grid, bool y_up) {
    if (mesh_format(output) != MeshFormat::glb) return 0;
    double slope = 0;
    const auto step = [&](std::size_t from, std::size_t to, double apart) {
        slope = std::max(slope, std::abs(double{grid.heights[to]} - double{grid.heights[from]}) / apart);
    };
    Box3d box;
    for (std::uint32_t r = 0, i = 0; r < grid.rows; ++r)
        for (std::uint32_t c = 0; c < grid.columns; ++c, ++i) {
            if (c > 0) step(i - 1, i, grid.spacing.x);
            if (r > 0) step(i - grid.columns, i, grid.spacing.y);
            const double x = grid.origin.x + grid.spacing.x * c, y = grid.origin.y - grid.spacing.y * r;
            box.add(y_up ? Vec3d(x, grid.heights[i], -y) : Vec3d(x, y, grid.heights[i]));
        }
    return glb_rounding_bound(box) * (1 + 2 * slope);
}

/// Warns if scaled or offset heights, kept as floats, are too coarse for the tolerance.
void warn_of_coarse_heights(const HeightReadOptions& read, const HeightGrid& grid, double max_error,
                            std::vector<std::string>& warnings) {
    if (read.scale == 1 && read.offset == 0) return;
    double largest = 0;
    for (const float height : grid.heights) largest = std::max(largest, std::abs(double{height}));
    const double rounding = 0x1p-24 * largest;
    if (rounding * 4 < max_error || max_error <= 0) return;
    warnings.push_back(
        fmt::format("heights of up to {} are kept as floats, which are up to {} off the file's: the error "
                    "is that from the floats; use a smaller --offset or a larger --max-error",
                    format_length(largest), format_length(rounding)));
}

/// Writes each tile to its own file.
/// @return  the report's entry about the tiles
Json write_tiles(FileSet& files, const Terrain& terrain, const TerrainCommandOptions& options,
                 const RunContext& context) {
    const Box3d whole = bounding_box(terrain.mesh.positions);
    Json list = Json::array();
    const auto [across, down] = *options.tiles;
    for (int row = 0; row < down; ++row)
        for (int column = 0; column < across; ++column) {
            const TriangleMesh tile = terrain_tile(terrain, list.size());
            AtomicFile& file = files.add(options.tile_path(std::to_string(row), std::to_string(column)));
            write_mesh_part(file, tile, whole, context);
            file.finish();  // so that only one of many files is open
            list.push_back({{"file", file.path().string()},
                            {"row", row},
                            {"column", column},
                            {"vertices", tile.positions.size()},
                            {"triangles", tile.triangles.size()}});
        }
    return list;
}

ExitCode run_checked(const TerrainCommandOptions& options) {
    Run process(options.run);
    std::vector<std::string> warnings;
    StageSeconds seconds;
    const Stopwatch loading;
    const HeightGrid grid = options.heights.load(process, warnings);
    seconds.load = loading.seconds();
    const double rounding = rounding_of(options.output, grid, options.y_up);
    if (rounding >= options.max_error && options.max_error > 0)
        throw UsageError(
            fmt::format("--max-error {} is less than what the floats of a GLB round off here, {}; write "
                        ".obj or .ply, or use a larger one",
                        format_length(options.max_error), format_length(rounding)));
    warn_of_coarse_heights(options.heights.read, grid, options.max_error, warnings);
    const Stopwatch refining;
    TerrainOptions terrain_options{.max_error = std::max(0.0, options.max_error - rounding),
                                   .y_up = options.y_up,
                                   .normals = options.normals,
                                   .context = process.context()};
    if (options.tiles)
        for (std::size_t axis = 0; axis < 2; ++axis)
            terrain_options.tiles[axis] = static_cast<std::uint32_t>((*options.tiles)[axis]);
    const Terrain terrain = terrain_mesh(grid, terrain_options);
    seconds.refine = refining.seconds();
    const double largest_error = terrain.largest_error + rounding;
    const auto [low, high] = std::minmax_element(grid.heights.begin(), grid.heights.end());

    const Stopwatch writing;
    FileSet files;
    Json tiles;
    if (options.tiles)
        tiles = write_tiles(files, terrain, options, process.context());
    else
        write_mesh(files.add(options.output), terrain.mesh, process.context());
    files.finish();
    seconds.write = writing.seconds();
    if (!options.report.empty())
        files.add(options.report)
            .write(dump({{"input", options.heights.path.string()},
                         {"columns", grid.columns},
                         {"rows", grid.rows},
                         {"spacing", {grid.spacing.x, grid.spacing.y}},
                         {"origin", {grid.origin.x, grid.origin.y}},
                         {"heights", {*low, *high}},
                         {"max_error", options.max_error},
                         {"largest_error", largest_error},
                         {"vertices", terrain.mesh.positions.size()},
                         {"triangles", terrain.mesh.triangles.size()},
                         {"tiles", tiles},
                         {"seconds", {{"load", seconds.load}, {"refine", seconds.refine}, {"write", seconds.write}}},
                         {"peak_memory_bytes", peak_memory_bytes()},
                         {"threads", options.run.thread_count()},
                         {"version", std::string(k_version)},
                         {"warnings", warnings}}));
    files.commit();
    process.end_progress();
    print_warnings(warnings);
    Table table;
    table.row("input", fmt::format("{} ({} x {} samples, {} apart, heights {} to {})", options.heights.path.string(),
                                   grid.columns, grid.rows, format_length(grid.spacing.x), format_length(*low),
                                   format_length(*high)));
    table.row("result", fmt::format("{} triangles, {} vertices", format_count(terrain.mesh.triangles.size()),
                                    format_count(terrain.mesh.positions.size())));
    if (options.tiles) table.row("tiles", fmt::format("{} across, {} down", (*options.tiles)[0], (*options.tiles)[1]));
    table.row("error", fmt::format("{} at most, of every sample (asked: {})", format_length(largest_error),
                                   format_length(options.max_error)));
    Report report;
    report.seconds = seconds;
    finish_summary(table, report,
                   {options.tiles ? options.tile_path("ROW", "COLUMN") : options.output, options.report});
    return largest_error <= options.max_error ? ExitCode::done : ExitCode::tolerance_not_reached;
}

ExitCode run(const TerrainCommandOptions& options) {
    OutputFiles outputs;
    outputs.add(OutputFiles::Kind::mesh, "-o", options.output);
    outputs.add(OutputFiles::Kind::report, "--report", options.report);
    outputs.check({options.heights.path});
    return about(options.heights.path, [&] { return run_checked(options); });
}

struct TilesCommandOptions {
    HeightInput heights;
    std::filesystem::path output;
    lod::TileOptions tiles;
    RunOptions run;
};

ExitCode run_checked(const TilesCommandOptions& options) {
    Run process(options.run);
    const Stopwatch watch;
    const auto source = options.heights.open(process);
    lod::TileOptions tiles = options.tiles;
    tiles.context = process.context();
    lod::write_tiles(*source, options.output, tiles);
    process.end_progress();
    const HeightGrid& grid = source->frame();
    Table table;
    table.row("input", fmt::format("{} ({} x {} samples, {} apart)", options.heights.path.string(), grid.columns,
                                   grid.rows, format_length(grid.spacing.x)));
    table.row("written", fmt::format("{} ({})", options.output.string(),
                                     format_bytes(std::filesystem::file_size(options.output))));
    table.row("time", fmt::format("{:.1f} s", watch.seconds()));
    table.row("memory", format_bytes(peak_memory_bytes()) + " at the peak");
    table.print();
    return ExitCode::done;
}

ExitCode run(const TilesCommandOptions& options) {
    OutputFiles outputs;
    outputs.add(OutputFiles::Kind::tiles, "-o", options.output);
    outputs.check({options.heights.path});
    return about(options.heights.path, [&] { return run_checked(options); });
}

}  // namespace

void add_terrain_command(CommandLine program) {
    auto options = std::make_shared<TerrainCommandOptions>();
    CommandLine command = program.command(
        "terrain", "Makes a mesh of a height grid, every sample within a tolerance",
        "x = column * spacing and y = -row * spacing, from the file's origin if it has one.\n"
        "Example:\n  tetrakis terrain data/island.png --scale 0.1 --spacing 10 --max-error 5 -o island.glb\n"
        "  tetrakis terrain data/island.png --scale 0.1 --spacing 10 --max-error 5 --tiles 4x4 --normals -o tile.glb");
    options->heights.add(command);
    command
        .option("--max-error", "H", options->max_error,
                "Largest vertical distance of a sample from the mesh, in the heights' unit; 0: none")
        .required()
        .number("a height from 0 on", [](double value) { return value >= 0; });
    command.flag("--y-up", options->y_up, "y is the height and z runs south, as in engines; else z is the height");
    command.flag("--normals", options->normals, "Write vertex normals: the means of the triangles around");
    const auto take_tiles = [options](const std::string& text) {
        constexpr int k_most = 4096;  // tiles along a side
        options->tiles = parse_counts(text, k_most);
        return options->tiles ? "" : text + " is no pair of counts such as 4x3 (1 to 4096 each)";
    };
    command.option_function(
        "--tiles", "CxR", take_tiles,
        "Cut into so many tiles across and down: files OUT_ROW_COLUMN without gaps between them, 0_0 in the "
        "north-west");
    options->run.add(command);
    command.option("-o,--output", "OUT", options->output, "Mesh to write: .obj, .ply or .glb").required();
    command.option("--report", "R.json", options->report, "Write figures as JSON");
    command.runs([options] { return run(*options); });
}

void add_tiles_command(CommandLine program) {
    auto options = std::make_shared<TilesCommandOptions>();
    CommandLine command = program.command(
        "tiles", "Cuts a height grid of any size into tiles of all levels for `lod`",
        "Raw files, HGT and what GDAL reads are not in memory at once; pictures are. `tetrakis lod OUT` flies over "
        "it.\n"
        "Example:\n  tetrakis tiles data/island.png --scale 0.1 --spacing 40 -o island.tiles");
    options->heights.add(command);
    command.option("--missing", "H", options->tiles.missing_height, "The height where there is no data")
        .number("a number", [](double) { return true; });
    options->run.add(command);
    command.option("-o,--output", "OUT", options->output, "File to write: .tiles").required();
    command.runs([options] { return run(*options); });
}

}  // namespace tetrakis::cli
