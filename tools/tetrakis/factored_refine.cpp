#include "factored_refine.hpp"

#include "console.hpp"
#include "files.hpp"
#include "report.hpp"

#include "../../eval/io/mesh_writer.hpp"
#include "../../hier/base/atomic_file.hpp"
#include "../../refine/factored/adaptive_factored_mesh.hpp"
#include "../../refine/factored/factored_mesh.hpp"
#include "../../refine/uniform/refine.hpp"
#include "../../refine/uniform/uniform.hpp"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <string_view>
#include <utility>
#include <vector>

namespace tetrakis::cli {

namespace {

template <class Has>
std::string names(Has&& has) {
    std::string result;
    for (const FactoredScheme scheme : factored_schemes())
        if (has(scheme)) result += fmt::format("{}{}", result.empty() ? "" : ", ", name(scheme));
    return result;
}

FactoredScheme chosen_factored_scheme(const FactoredRefine& options) {
    const auto scheme = factored_scheme_from_name(options.scheme);
    if (!scheme)
        throw UsageError(
            fmt::format("\"{}\" has no factored form; these have one: {}", options.scheme, factored_scheme_names()));
    if (options.sphere && !half_steps_adapt(*scheme))
        throw UsageError(fmt::format("--near: half-steps of {} do not adapt; those of these do: {}", options.scheme,
                                     names(half_steps_adapt)));
    return *scheme;
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

FactoredResult by_adaptive_half_steps(const FactoredRefine& options, FactoredScheme scheme, const ControlMesh& mesh,
                                      const RunContext& context) {
    AdaptiveFactoredMesh adaptive(mesh, scheme, context);
    adaptive.refine_near(options.sphere->centre, options.sphere->radius, options.half_steps);
    AdaptiveFactoredMesh::Output output = adaptive.mesh();
    FactoredResult result{.mesh = std::move(output.mesh), .levels = options.half_steps / 2};
    for (std::size_t v = 0; v < output.states.size(); ++v)
        if (output.states[v] == FactoredVertex::inactive) result.inactive.push_back(v);
    result.active = output.states.size() - result.inactive.size();
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

FactoredResult refined(const FactoredRefine& options, FactoredScheme scheme, const ControlMesh& mesh,
                       const RunContext& context) {
    // The coarsest leaves have two half-steps (Catmull-Clark: one); fewer are the same everywhere.
    if (options.sphere && options.half_steps >= 2) return by_adaptive_half_steps(options, scheme, mesh, context);
    return whole_levels(options, scheme, mesh) ? by_levels(options, mesh, context)
                                               : by_half_steps(options, scheme, mesh, context);
}

ExitCode run_checked(const FactoredRefine& options, FactoredScheme scheme) {
    Run process(options.run);
    LoadedModel model = load_model(options.input, options.read, process.context());
    Report report = Report::of(options.input, name(scheme), model, options.run);
    for (std::string& warning : options.rules.unused(scheme_named(name(scheme))))
        report.warnings.push_back(std::move(warning));

    const Stopwatch refining;
    const FactoredResult result = refined(options, scheme, model.mesh, process.context());
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
    table.row("refined",
              fmt::format("{}, {} half-steps on the 4-8 mesh{}, {} active vertices", name(scheme), options.half_steps,
                          options.sphere ? " inside the sphere, fewer outside" : "", format_count(active)));
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

HalfStepSphere half_step_sphere(const std::string& near, const std::string& radius) {
    const auto number = [](std::string_view& text, double& value) {
        const auto [rest, error] = std::from_chars(text.data(), text.data() + text.size(), value);
        text.remove_prefix(static_cast<std::size_t>(rest - text.data()));
        return error == std::errc{} && std::isfinite(value);
    };
    HalfStepSphere sphere;
    std::string_view text = near;
    bool good = true;
    for (int i = 0; i < 3 && good; ++i) {
        good = (i == 0 || text.starts_with(','));
        if (i > 0 && good) text.remove_prefix(1);
        good = good && number(text, sphere.centre[i]);
    }
    if (!good || !text.empty())
        throw UsageError(fmt::format("--near: \"{}\" is no point such as 0.5,1,-2 (three numbers)", near));
    text = radius;
    if (!number(text, sphere.radius) || !text.empty() || sphere.radius <= 0)
        throw UsageError(fmt::format("--radius: \"{}\" is no length above 0", radius));
    return sphere;
}

std::string factored_scheme_names() {
    return names([](FactoredScheme) { return true; });
}

ExitCode run_factored_refine(const FactoredRefine& options) {
    const FactoredScheme scheme = chosen_factored_scheme(options);
    OutputFiles outputs;
    outputs.add(OutputFiles::Kind::mesh, "-o", options.output);
    outputs.add(OutputFiles::Kind::report, "--report", options.report);
    outputs.check({options.input});
    return about(options.input, [&] { return run_checked(options, scheme); });
}

}  // namespace tetrakis::cli
