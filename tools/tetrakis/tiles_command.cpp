#include "commands.hpp"
#include "console.hpp"
#include "files.hpp"
#include "height_input.hpp"
#include "report.hpp"
#include "run_options.hpp"

#include "../../eval/lod_surfaces/terrain_tiles.hpp"
#include "../../eval/terrain/height_source.hpp"
#include "../../hier/base/memory.hpp"

#include <fmt/format.h>

#include <filesystem>
#include <memory>

namespace tetrakis::cli {
namespace {

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

void add_tiles_command(CLI::App& app, Command& chosen) {
    auto options = std::make_shared<TilesCommandOptions>();
    CLI::App* command =
        app.add_subcommand("tiles", "Cuts a height grid of any size into tiles of all levels for `lod`");
    options->heights.add(*command);
    command->add_option("--missing", options->tiles.missing_height, "The height where there is no data")
        ->type_name("H")
        ->check(number_check("a number", [](double) { return true; }));
    options->run.add(*command);
    command->add_option("-o,--output", options->output, "File to write: .tiles")->required()->type_name("OUT");
    command->footer(
        "Raw files, HGT and what GDAL reads are not in memory at once; pictures are. `tetrakis lod OUT` flies over "
        "it.\n"
        "Example:\n  tetrakis tiles data/island.png --scale 0.1 --spacing 40 -o island.tiles");
    command->callback([options, &chosen] { chosen = [options] { return run(*options); }; });
}

}  // namespace tetrakis::cli
