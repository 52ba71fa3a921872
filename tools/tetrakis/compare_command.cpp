#include "commands.hpp"
#include "console.hpp"
#include "files.hpp"
#include "report.hpp"
#include "run_options.hpp"

#include "../../eval/distance/hausdorff.hpp"
#include "../../eval/io/mesh_reader.hpp"
#include "../../hier/base/vec.hpp"

#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <string>

namespace tetrakis::cli {
namespace {

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
    const auto read = [&](const std::filesystem::path& path) {
        return reading(path, [&] { return read_triangle_mesh(path, process.context()); });
    };
    const TriangleMesh a = read(options.a), b = read(options.b);
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

}  // namespace tetrakis::cli
