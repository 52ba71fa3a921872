#include "commands.hpp"
#include "console.hpp"
#include "files.hpp"
#include "height_input.hpp"
#include "report.hpp"
#include "run_options.hpp"

#include "../../eval/io/mesh_writer.hpp"
#include "../../eval/lod/height_grid.hpp"
#include "../../eval/lod/terrain_mesh.hpp"
#include "../../hier/base/files.hpp"
#include "../../hier/base/memory.hpp"
#include "../../hier/base/version.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

namespace tetrakis::cli {
namespace {

struct Options {
    HeightInput heights;
    std::filesystem::path output, report;
    double max_error = 0;
    bool y_up = false;
    RunOptions run;
};

/// What writing adds to the errors: floats of a GLB are about a local origin, and what moves along the ground is off by
/// as much times the slope.
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

ExitCode run_checked(const Options& options) {
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
    const Stopwatch refining;
    const Terrain terrain = terrain_mesh(
        grid,
        {.max_error = std::max(0.0, options.max_error - rounding), .y_up = options.y_up, .context = process.context()});
    seconds.refine = refining.seconds();
    const double largest_error = terrain.largest_error + rounding;
    const auto [low, high] = std::minmax_element(grid.heights.begin(), grid.heights.end());

    const Stopwatch writing;
    FileSet files;
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
    table.row("error", fmt::format("{} at most, of every sample (asked: {})", format_length(largest_error),
                                   format_length(options.max_error)));
    Report report;
    report.seconds = seconds;
    finish_summary(table, report, {options.output, options.report});
    return ExitCode::done;
}

ExitCode run(const Options& options) {
    OutputFiles outputs;
    outputs.add(OutputFiles::Kind::mesh, "-o", options.output);
    outputs.add(OutputFiles::Kind::report, "--report", options.report);
    outputs.check({options.heights.path});
    return about(options.heights.path, [&] { return run_checked(options); });
}

}  // namespace

void add_terrain_command(CLI::App& app, Command& chosen) {
    auto options = std::make_shared<Options>();
    CLI::App* command = app.add_subcommand("terrain", "Makes a mesh of a height grid, every sample within a tolerance");
    options->heights.add(*command);
    command
        ->add_option("--max-error", options->max_error,
                     "Largest vertical distance of a sample from the mesh, in the heights' unit; 0: none")
        ->required()
        ->type_name("H")
        ->check(number_check("a height from 0 on", [](double value) { return value >= 0; }));
    command->add_flag("--y-up", options->y_up, "y is the height and z runs south, as in engines; else z is the height");
    options->run.add_threads(*command);
    options->run.add_max_memory(*command);
    command->add_option("-o,--output", options->output, "Mesh to write: .obj, .ply or .glb")
        ->required()
        ->type_name("OUT");
    command->add_option("--report", options->report, "Write figures as JSON")->type_name("R.json");
    command->footer(
        "x = column * spacing and y = -row * spacing, from the file's origin if it has one.\n"
        "Example:\n  tetrakis terrain data/island.png --scale 0.1 --spacing 10 --max-error 5 -o island.glb");
    command->callback([options, &chosen] { chosen = [options] { return run(*options); }; });
}

}  // namespace tetrakis::cli
