#include "commands.hpp"
#include "console.hpp"
#include "files.hpp"
#include "run_options.hpp"

#include "../../eval/distance/hausdorff.hpp"
#include "../../eval/io/mesh_reader.hpp"
#include "../../eval/io/png.hpp"
#include "../../eval/render/render.hpp"

#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <vector>

namespace tetrakis::cli {
namespace {

struct RenderCommandOptions {
    std::filesystem::path input, output, heat;
    bool wireframe = false, flat = false;
    RenderOptions render;
    RunOptions run;
};

ExitCode run(const RenderCommandOptions& options) {
    OutputFiles outputs;
    outputs.add(OutputFiles::Kind::picture, "-o", options.output);
    outputs.check({options.input, options.heat});

    Run process(options.run);
    const auto read = [&](const std::filesystem::path& path) {
        return reading(path, [&] { return read_triangle_mesh(path, process.context()); });
    };
    const TriangleMesh mesh = read(options.input);
    RenderOptions render_options = options.render;
    render_options.wireframe = options.wireframe;
    render_options.shading = options.flat ? Shading::flat : Shading::smooth;
    DirectedDistance distance;
    if (!options.heat.empty()) {
        const TriangleMesh other = read(options.heat);
        distance =
            directed_distance(mesh, TriangleBvh(other, process.context()), {.per_triangle = true}, process.context());
        render_options.triangle_values = distance.triangle_max;
        render_options.legend_title = "distance";
    }
    const Stopwatch draw;
    const Image image = render(mesh, render_options, process.context());
    const double seconds = draw.seconds();
    write_png(options.output, image);
    process.end_progress();

    Table table;
    table.row("input", fmt::format("{} ({} triangles)", options.input.string(), format_count(mesh.triangles.size())));
    if (!options.heat.empty())
        table.row("heat",
                  fmt::format("distance to {}, at most {}", options.heat.string(), format_length(distance.max)));
    table.row("drawn", fmt::format("{} x {} pixels in {}", image.width, image.height, format_seconds(seconds)));
    table.row("written", options.output.string());
    table.print();
    return ExitCode::done;
}

}  // namespace

void add_render_command(CommandLine program) {
    auto options = std::make_shared<RenderCommandOptions>();
    CommandLine command = program.command(
        "render", "Draws a mesh", "Example:\n  tetrakis render data/rook.obj -o rook.png --wireframe --size 640x480");
    command.option("IN", "", options->input, "Mesh (.obj, .ply, .glb, .gltf)").required();
    command.option("-o,--output", "PNG", options->output, "Picture to write (.png)").required();
    command.flag("--wireframe", options->wireframe, "Draw the edges of the triangles, too");
    command.option("--heat", "MESH", options->heat, "Colour each triangle by its distance to this mesh");
    command.flag("--flat", options->flat, "Shade each triangle by its own normal");
    add_view_options(command, options->render);
    options->run.add(command);
    command.runs([options] { return run(*options); });
}

}  // namespace tetrakis::cli
