#include "commands.hpp"
#include "console.hpp"
#include "files.hpp"
#include "report.hpp"
#include "run_options.hpp"

#include "../../eval/distance/hausdorff.hpp"
#include "../../eval/io/mesh_reader.hpp"
#include "../../eval/io/png.hpp"
#include "../../eval/render/render.hpp"
#include "../../hier/base/vec.hpp"

#include <fmt/format.h>

#include <filesystem>
#include <memory>

namespace tetrakis::cli {
namespace {

TriangleMesh read_mesh(const std::filesystem::path& path, const Run& process) {
    return reading(path, [&] { return read_triangle_mesh(path, process.context()); });
}

struct CompareOptions {
    std::filesystem::path a, b;
    std::uint64_t samples = SamplingOptions{}.samples;
    bool json = false;
    RunOptions run;
};

Json json_of_direction(const DirectedDistance& d) {
    return {{"max", d.max},
            {"mean", d.mean},
            {"rms", d.rms},
            {"samples", d.samples},
            {"worst_point", {d.worst_point.x, d.worst_point.y, d.worst_point.z}}};
}

ExitCode run(const CompareOptions& options) {
    Run process(options.run);
    const TriangleMesh a = read_mesh(options.a, process), b = read_mesh(options.b, process);
    const MeshComparison result = compare(a, b, {.samples = options.samples}, process.context());
    process.end_progress();
    const double diagonal = bounding_box(a.positions).diagonal();

    if (options.json) {
        Json json = {{"a", options.a.string()}, {"b", options.b.string()}};
        json.update(json_of(std::optional(result.error)));
        json["a_to_b"] = json_of_direction(result.forward);
        json["b_to_a"] = json_of_direction(result.backward);
        json["diagonal"] = diagonal;
        fmt::print("{}", dump(json));
        return ExitCode::done;
    }
    const auto length = [&](double value) {
        return diagonal > 0 ? fmt::format("{:<11} ({:.3g} of A's diagonal)", format_length(value), value / diagonal)
                            : format_length(value);
    };
    const auto direction = [&](const DirectedDistance& d) {
        return fmt::format("{:<11} mean {}, rms {}, {} samples", format_length(d.max), format_length(d.mean),
                           format_length(d.rms), format_count(d.samples));
    };
    Table table;
    table.row("A", fmt::format("{} ({} triangles)", options.a.string(), format_count(a.triangles.size())));
    table.row("B", fmt::format("{} ({} triangles)", options.b.string(), format_count(b.triangles.size())));
    table.row("Hausdorff", length(result.error.hausdorff));
    table.row("mean", length(result.error.mean));
    table.row("rms", length(result.error.rms));
    table.row("A to B", direction(result.forward));
    table.row("B to A", direction(result.backward));
    table.print();
    return ExitCode::done;
}

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
    const TriangleMesh mesh = read_mesh(options.input, process);
    RenderOptions render_options = options.render;
    render_options.wireframe = options.wireframe;
    render_options.shading = options.flat ? Shading::flat : Shading::smooth;
    DirectedDistance distance;
    if (!options.heat.empty()) {
        const TriangleMesh other = read_mesh(options.heat, process);
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

void add_compare_command(CommandLine program) {
    auto options = std::make_shared<CompareOptions>();
    CommandLine command =
        program.command("compare", "Measures how far two meshes are from each other",
                        "Distances are sampled, so each is a lower bound. Polygons are compared as fans of triangles.\n"
                        "Example:\n  tetrakis compare data/knot.obj data/knot_tri.obj");
    command.option("A", "", options->a, "Mesh (.obj, .ply, .glb, .gltf)").required();
    command.option("B", "", options->b, "Mesh to compare it with").required();
    command.flag("--json", options->json, "Print JSON");
    command.option("--samples", "N", options->samples, "Points to sample in each direction")
        .shows_default()
        .range(std::uint64_t{1}, k_most_samples, Option::InHelp::yes);
    options->run.add(command);
    command.runs([options] { return run(*options); });
}

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
