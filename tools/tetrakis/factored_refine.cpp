#include "factored_refine.hpp"

#include "console.hpp"
#include "files.hpp"
#include "report.hpp"

#include "../../eval/io/mesh_writer.hpp"
#include "../../hier/base/atomic_file.hpp"
#include "../../refine/factored/factored_mesh.hpp"
#include "../../refine/uniform/refine.hpp"
#include "../../refine/uniform/uniform.hpp"

#include <fmt/format.h>

#include <utility>
#include <vector>

namespace tetrakis::cli {

namespace {

FactoredScheme chosen_factored_scheme(const std::string& text) {
    if (const auto scheme = factored_scheme_from_name(text)) return *scheme;
    throw UsageError(fmt::format("\"{}\" has no factored form; these have one: {}", text, factored_scheme_names()));
}

struct FactoredResult {
    PolygonMesh mesh;
    int levels = 0;
    std::uint64_t active = 0;
    std::vector<std::size_t> inactive{};  ///< of the mesh's vertices
};

FactoredResult by_half_steps(const FactoredRefine& options, FactoredScheme scheme, const ControlMesh& mesh,
                             const RunContext& context) {
    FactoredMesh factored(mesh, scheme, context.max_memory_bytes, options.rules.rules());
    factored.check_half_steps(options.half_steps);
    FactoredResult result{.mesh = {}, .levels = options.half_steps / factored.half_steps_per_level()};
    for (int i = 0; i < options.half_steps; ++i) {
        context.report("refine", static_cast<double>(i) / options.half_steps);
        factored.half_step();
    }
    std::vector<std::uint32_t> numbers;
    result.mesh = options.active ? factored.active_mesh() : factored.mesh(&numbers);
    for (std::uint32_t v = 0; v < factored.positions().size(); ++v)
        result.active += factored.state(v) == FactoredVertex::active;
    // The scheme's own mesh has active vertices alone: of that the list is empty.
    for (std::size_t v = 0; v < numbers.size(); ++v)
        if (factored.state(numbers[v]) == FactoredVertex::inactive) result.inactive.push_back(v);
    return result;
}

/// Whether nothing is asked for that is between two levels: those go root by root, several times faster.
bool whole_levels(const FactoredRefine& options, FactoredScheme scheme, const ControlMesh& mesh) {
    return scheme == FactoredScheme::catmull_clark && options.active && options.half_steps > 0 &&
           options.half_steps % 2 == 0 && !mesh.has_corner_angles();
}
FactoredResult by_levels(const FactoredRefine& options, const ControlMesh& mesh, const RunContext& context) {
    FactoredResult result{.mesh = {}, .levels = options.half_steps / 2};
    result.mesh =
        refine_uniform(mesh, SchemeKind::catmull_clark, result.levels, {.factored = true, .context = context});
    result.active = result.mesh.positions.size();
    return result;
}

ExitCode run_checked(const FactoredRefine& options, FactoredScheme scheme) {
    Run process(options.run);
    LoadedModel model = load_model(options.input, options.read, process.context());
    Report report = Report::of(options.input, name(scheme), model, options.run);
    for (std::string& warning : options.rules.unused(scheme_named(name(scheme))))
        report.warnings.push_back(std::move(warning));

    const Stopwatch refining;
    const FactoredResult result = whole_levels(options, scheme, model.mesh)
                                      ? by_levels(options, model.mesh, process.context())
                                      : by_half_steps(options, scheme, model.mesh, process.context());
    const PolygonMesh& mesh = result.mesh;
    const std::uint64_t active = result.active;
    report.levels = result.levels;
    report.warnings.insert(report.warnings.end(), mesh.warnings.begin(), mesh.warnings.end());
    report.seconds.refine = refining.seconds();
    report.vertices = mesh.positions.size();
    if (mesh.face_vertices.size() == std::uint64_t{3} * mesh.face_count()) report.triangles = mesh.face_count();
    report.more = {{"output_faces", mesh.face_count()}, {"half_steps", options.half_steps}, {"active", active}};
    report.more["inactive_vertices"] = result.inactive;

    const Stopwatch write;
    FileSet files;
    write_mesh(files.add(options.output), mesh, process.context());
    files.finish();
    report.seconds.write = write.seconds();
    if (!options.report.empty()) report.write(files.add(options.report));
    files.commit();
    process.end_progress();

    print_warnings(report.warnings);
    Table table;
    table.row("input", fmt::format("{} ({} faces)", options.input.string(), format_count(report.faces)));
    table.row("refined", fmt::format("{}, {} half-steps on the 4-8 mesh, {} active vertices", name(scheme),
                                     options.half_steps, format_count(active)));
    table.row("result",
              fmt::format("{} faces, {} vertices", format_count(mesh.face_count()), format_count(report.vertices)));
    table.row("time", fmt::format("load {}, build {}, refine {}, write {}", format_seconds(report.seconds.load),
                                  format_seconds(report.seconds.build), format_seconds(report.seconds.refine),
                                  format_seconds(report.seconds.write)));
    table.row("written", options.output.string());
    if (!options.report.empty()) table.row("", options.report.string());
    table.print();
    return ExitCode::done;
}

}  // namespace

std::string factored_scheme_names() {
    std::string names;
    for (const FactoredScheme scheme : factored_schemes())
        names += fmt::format("{}{}", names.empty() ? "" : ", ", name(scheme));
    return names;
}

ExitCode run_factored_refine(const FactoredRefine& options) {
    const FactoredScheme scheme = chosen_factored_scheme(options.scheme);
    OutputFiles outputs;
    outputs.add(OutputFiles::Kind::mesh, "-o", options.output);
    outputs.add(OutputFiles::Kind::report, "--report", options.report);
    outputs.check({options.input});
    return about(options.input, [&] { return run_checked(options, scheme); });
}

}  // namespace tetrakis::cli
