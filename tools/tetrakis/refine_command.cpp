#include "commands.hpp"
#include "console.hpp"
#include "files.hpp"
#include "report.hpp"
#include "run_options.hpp"

#include "../../eval/io/mesh_writer.hpp"
#include "../../hier/base/files.hpp"
#include "../../hier/base/vec.hpp"
#include "../../refine/factored/adaptive_factored_mesh.hpp"
#include "../../refine/factored/factored_mesh.hpp"
#include "../../refine/uniform/refine.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace tetrakis::cli {
namespace {

/// One line of numbers.
template <class T>
void write_array(AtomicFile& file, std::span<const T> numbers) {
    constexpr std::size_t k_block = std::size_t{1} << 16;
    for (std::size_t i = 0; i < numbers.size(); i += k_block)
        file.write(fmt::format("{}{}", i == 0 ? "" : " ",
                               fmt::join(numbers.subspan(i, std::min(k_block, numbers.size() - i)), " ")));
    file.write("\n");
}

/// Writes a stencil table as text, for programs that refine with their own kernels:
///
///     tetrakis-stencils 2
///     <rows> <control vertices> <terms>
///     <where each row begins, and the number of terms: rows + 1 numbers>
///     <control vertex of each term>
///     <weight of each term>
///
/// These are compressed rows (CSR), one line for each array. Row r has the terms from begin r to before begin r + 1.
/// Vertices and terms count from 0; vertices increase along a row; weights are the shortest decimals that read back the
/// same. Row r, applied to control values term by term from the left, gives the value of refined vertex r.
void write_stencils(AtomicFile& file, const StencilTable& table, int control_vertices) {
    file.write(
        fmt::format("tetrakis-stencils 2\n{} {} {}\n", table.row_count(), control_vertices, table.points().size()));
    write_array(file, table.begins());
    write_array(file, table.points());
    write_array(file, table.weights());
}

constexpr std::string_view k_averaging_steps_option = "--averaging-steps";

struct RefineCommandOptions {
    std::filesystem::path input, output, report;
    std::filesystem::path stencils;
    std::string scheme{name(SchemeKind::catmull_clark)}, near, radius;
    RuleOptions rules;
    int levels = 0, smoothing = 0, steps = 0;
    ReadOptions read;
    bool limit = false, factored = false, active = false, adapts = false;
    RunOptions run;
};

/// Sphere of adaptive half-steps: all half-steps are done inside, fewer outside.
struct HalfStepSphere {
    Vec3d centre{0};
    double radius = 0;
};
/// A mesh refined by half-steps of the 4-8 mesh.
struct FactoredResult {
    PolygonMesh mesh;
    int levels = 0;      ///< complete levels
    int half_steps = 0;  ///< of the finest triangles
    std::uint64_t active = 0;
    std::vector<std::size_t> inactive{};  ///< inactive vertices of `mesh`
};

template <class Has>
std::string names(Has&& has) {
    std::string result;
    for (const FactoredScheme scheme : factored_schemes())
        if (has(scheme)) result += fmt::format("{}{}", result.empty() ? "" : ", ", name(scheme));
    return result;
}

/// Parses the sphere of --near X,Y,Z and --radius R.
HalfStepSphere half_step_sphere(const std::string& near, const std::string& radius) {
    const auto centre = finite_numbers(near, 3), length = finite_numbers(radius, 1);
    if (!centre) throw UsageError(fmt::format("--near: \"{}\" is no point such as 0.5,1,-2 (three numbers)", near));
    if (!length || (*length)[0] <= 0) throw UsageError(fmt::format("--radius: \"{}\" is no length above 0", radius));
    return {{(*centre)[0], (*centre)[1], (*centre)[2]}, (*length)[0]};
}

/// Names of the schemes that `refine --factored` accepts.
std::string factored_scheme_names() {
    return names([](FactoredScheme) { return true; });
}

/// @param adaptive  whether the half-steps must adapt
FactoredScheme chosen_factored_scheme(const SchemeInfo& scheme, bool adaptive) {
    const auto factored = factored_scheme_from_name(scheme.name);
    if (!factored)
        throw UsageError(
            fmt::format("{} has no factored form; these have one: {}", scheme.name, factored_scheme_names()));
    if (adaptive && !half_steps_adapt(*factored))
        throw UsageError(fmt::format("--near: half-steps of {} do not adapt; those of these do: {}", scheme.name,
                                     names(half_steps_adapt)));
    return *factored;
}

/// @param active  output the scheme's own faces instead of the triangles of the 4-8 mesh
FactoredResult refine_by_half_steps(const ControlMesh& mesh, FactoredScheme scheme, int half_steps, bool active,
                                    const RuleOptions& rules, const RunContext& context) {
    FactoredMesh factored(mesh, scheme, context.max_memory_bytes, rules);
    factored.check_half_steps(half_steps);
    FactoredResult result{.mesh = {}, .levels = half_steps / factored.half_steps_per_level(), .half_steps = half_steps};
    for (int i = 0; i < half_steps; ++i) {
        context.report("refine", static_cast<double>(i) / half_steps);
        factored.half_step();
    }
    std::vector<std::uint32_t> numbers;
    result.mesh = active ? factored.active_mesh() : factored.mesh(&numbers);
    for (std::uint32_t v = 0; v < factored.positions().size(); ++v)
        result.active += factored.state(v) == FactoredVertex::active;
    // All vertices of the scheme's own mesh are active: then `numbers` is empty.
    for (std::size_t v = 0; v < numbers.size(); ++v)
        if (factored.state(numbers[v]) == FactoredVertex::inactive) result.inactive.push_back(v);
    return result;
}

/// Refines by all half-steps inside the sphere, and by as few as conformity allows outside.
FactoredResult refine_by_adaptive_half_steps(const ControlMesh& mesh, FactoredScheme scheme, int half_steps,
                                             const HalfStepSphere& sphere, const RunContext& context) {
    // The coarsest leaves have two half-steps (Catmull-Clark: one), so fewer cannot adapt.
    if (half_steps < 2) return refine_by_half_steps(mesh, scheme, half_steps, false, {}, context);
    AdaptiveFactoredMesh adaptive(mesh, scheme, context);
    adaptive.refine_near(sphere.centre, sphere.radius, half_steps);
    AdaptiveFactoredMesh::Output output = adaptive.mesh();
    FactoredResult result{.mesh = std::move(output.mesh)};
    for (const AdaptiveFactoredMesh::Leaf& leaf : output.leaves)
        result.half_steps = std::max<int>(result.half_steps, leaf.half_steps);
    result.levels = result.half_steps / 2;
    for (std::size_t v = 0; v < output.states.size(); ++v)
        if (output.states[v] == FactoredVertex::inactive) result.inactive.push_back(v);
    result.active = output.states.size() - result.inactive.size();
    return result;
}

/// Refines by whole levels. @param stencils  receives the control vertices' weights, if the options ask for them
PolygonMesh refine_by_levels(const RefineCommandOptions& options, const SchemeInfo& scheme, const ControlMesh& mesh,
                             const RunContext& context, StencilTable& stencils) {
    RefineOptions refine_options{.rules = options.rules,
                                 .smoothing = options.smoothing,
                                 .limit = options.limit,
                                 .normals = options.limit,
                                 .context = context};
    // The limit includes the program itself, and allocators use more than is requested of them.
    constexpr std::uint64_t k_percent = 92;
    const std::uint64_t limit = context.max_memory_bytes, used = memory_bytes();
    if (limit != 0) refine_options.context.max_memory_bytes = limit > used ? (limit - used) / 100 * k_percent : 1;
    try {
        if (options.stencils.empty()) return refine(mesh, scheme, options.levels, refine_options);
        RefinedStencils refined = refine_stencils(mesh, scheme, options.levels, refine_options);
        stencils = std::move(refined.stencils);
        return std::move(refined.mesh);
    } catch (const Error& error) {
        if (error.code() != ErrorCode::memory_limit) throw;
        // The caller adds the name of the file.
        std::string text = error.what();
        if (const std::string file = error.file().string() + ": "; text.starts_with(file)) text.erase(0, file.size());
        throw Error(error.code(),
                    fmt::format("{} (of {} MiB in all, {} MiB were in use before)", text, limit >> 20, used >> 20));
    }
}

/// @param factored  the scheme, if half-steps are requested
/// @param sphere    where half-steps adapt
ExitCode run_checked(const RefineCommandOptions& options, const SchemeInfo& scheme,
                     std::optional<FactoredScheme> factored, const std::optional<HalfStepSphere>& sphere) {
    Run process(options.run);
    const LoadedModel model = load_model(options.input, options.read, process.context(), &scheme);
    Report report = Report::of(options.input, scheme.name, model, options.run);
    report.levels = options.levels;
    report.more = {{"limit", options.limit}};
    std::string refined = fmt::format("{}, {} levels{}", scheme.name, options.levels,
                                      options.limit ? ", vertices on the limit surface" : "");

    const Stopwatch refining;
    StencilTable stencils;
    PolygonMesh mesh;
    if (factored) {
        FactoredResult result =
            sphere ? refine_by_adaptive_half_steps(model.mesh, *factored, options.steps, *sphere, process.context())
                   : refine_by_half_steps(model.mesh, *factored, options.steps, options.active, options.rules,
                                          process.context());
        mesh = std::move(result.mesh);
        const ControlMeshData& data = model.mesh.data();
        if (!data.uvs.empty() && mesh.uvs.empty())
            report.warnings.push_back("the texture coordinates were dropped: half-steps have none");
        if ((!data.face_material.empty() && mesh.face_material.empty()) ||
            (!data.face_group.empty() && mesh.face_group.empty()))
            report.warnings.push_back(
                fmt::format("the groups and materials were dropped: half-steps of {} have none", scheme.name));
        if (!data.holes.empty() && *factored != FactoredScheme::catmull_clark &&
            *factored != FactoredScheme::four_eight)
            report.warnings.push_back(
                fmt::format("the holes were refined as faces: half-steps of {} have no holes", scheme.name));
        report.levels = result.levels;
        report.more = {{"half_steps", result.half_steps}, {"active", result.active}};
        report.more["inactive_vertices"] = result.inactive;
        refined = fmt::format("{}, {} half-steps on the 4-8 mesh{}, {} active vertices", scheme.name, result.half_steps,
                              sphere ? " inside the sphere, fewer outside" : "", format_count(result.active));
        if (result.half_steps < options.steps)
            report.warnings.push_back(
                fmt::format("the sphere of --near and --radius meets no triangle of more than {} half-steps: it is "
                            "about the refined "
                            "surface, which may lie away from the control mesh",
                            result.half_steps));
    } else {
        mesh = refine_by_levels(options, scheme, model.mesh, process.context(), stencils);
    }
    report.seconds.refine = refining.seconds();
    report.warnings.insert(report.warnings.end(), mesh.warnings.begin(), mesh.warnings.end());
    for (std::string& warning :
         unused_rule_options(options.rules, scheme, factored ? k_averaging_steps_option : k_steps_option))
        report.warnings.push_back(std::move(warning));
    if (options.smoothing > 0 && !scheme.interpolating)
        report.warnings.push_back(
            fmt::format("--smoothing is for interpolating schemes; {} smooths by itself", scheme.name));
    report.vertices = mesh.positions.size();
    if (mesh.face_vertices.size() == std::uint64_t{3} * mesh.face_count()) report.triangles = mesh.face_count();
    report.more["output_faces"] = mesh.face_count();

    write_results(process, report, options.report, [&](FileSet& files) {
        if (!options.stencils.empty())
            write_stencils(files.add(options.stencils), stencils, static_cast<int>(model.mesh.vertex_count()));
        write_mesh(files.add(options.output), mesh, process.context());
    });
    Table table;
    table.row("input", fmt::format("{} ({} faces)", options.input.string(), format_count(report.faces)));
    table.row("refined", refined);
    table.row("result",
              fmt::format("{} faces, {} vertices", format_count(mesh.face_count()), format_count(report.vertices)));
    finish_summary(table, report, {options.output, options.stencils, options.report});
    return ExitCode::done;
}

ExitCode run(const RefineCommandOptions& options) {
    const SchemeInfo& scheme = chosen_scheme(options.scheme);
    std::optional<FactoredScheme> factored;
    if (options.factored) factored = chosen_factored_scheme(scheme, options.adapts);
    std::optional<HalfStepSphere> sphere;
    if (options.adapts) sphere = half_step_sphere(options.near, options.radius);
    OutputFiles outputs;
    outputs.add(OutputFiles::Kind::mesh, "-o", options.output);
    outputs.add(OutputFiles::Kind::report, "--report", options.report);
    outputs.add(OutputFiles::Kind::table, "--stencils", options.stencils);
    outputs.check({options.input});
    return about(options.input, [&] { return run_checked(options, scheme, factored, sphere); });
}

}  // namespace

void add_refine_command(CommandLine program) {
    auto options = std::make_shared<RefineCommandOptions>();
    CommandLine command = program.command(
        "refine", "Refines a control mesh everywhere, by whole levels",
        "Example:\n  tetrakis refine data/pawn.obj --scheme catmull-clark --levels 3 --limit -o pawn.obj");
    command.option("IN", "", options->input, "Control mesh (.obj)").required();
    command.option("--scheme", "S", options->scheme,
                   "Subdivision scheme, any that \"tetrakis schemes\" lists (catmull-clark)");
    constexpr int k_most_levels = 31, k_most_steps = 64;  // beyond 32-bit indices, which the library checks
    command.option("--levels", "N", options->levels, "Steps of the scheme")
        .range(0, k_most_levels, Option::InHelp::yes);
    command.flag("--limit", options->limit, "Put the vertices on the limit surface, with its normals");
    command
        .option("--steps", "K", options->steps,
                "With --factored: half-steps, two for a level (biquartic: five; averaging: two more than its "
                "averaging steps). Else, for averaging: its number of averaging steps in a "
                "level, 0 to 64 (3)")
        .range(0, k_most_steps, Option::InHelp::yes);
    const Option averaging_steps =
        command
            .option(std::string(k_averaging_steps_option), "M", options->rules.averaging_steps,
                    "With --factored, for averaging: what --steps is without it (3)")
            .range(0, k_most_steps);
    add_rule_options(command, options->rules, StepsOption::leave_out);
    command
        .option("--smoothing", "N", options->smoothing,
                "Rounds of smoothing of the control points first, for interpolating schemes (0)")
        .range(0, 100);
    const Option factored =
        command.flag("--factored", options->factored,
                     "By half-steps on the 4-8 mesh, which is written as triangles (after none of Catmull-Clark's: "
                     "the control mesh); --steps says how many. For " +
                         factored_scheme_names());
    averaging_steps.needs("--factored");
    command
        .flag("--active", options->active,
              "With --factored: write the scheme's own faces after the last whole level, not the 4-8 mesh")
        .needs("--factored");
    const Option near = command
                            .option("--near", "X,Y,Z", options->near,
                                    "With --factored: all half-steps only inside of a sphere about this point, "
                                    "and outside as few as the mesh allows. For catmull-clark, doo-sabin and midedge")
                            .needs("--factored")
                            .excludes("--active");
    command.option("--radius", "R", options->radius, "Of that sphere").needs("--near");
    near.needs("--radius");
    options->run.add(command);
    add_read_options(command, options->read);
    command.option("-o,--output", "OUT", options->output, "Mesh to write: .obj, .ply or .glb").required();
    command.option(
        "--stencils", "T.txt", options->stencils,
        "Write the vertices as weights of control vertices (by the rules, so in their order), in compressed "
        "rows (CSR): after \"tetrakis-stencils 2\" and the numbers of rows, control vertices and terms a line "
        "of where rows begin, one of control vertices and one of weights");
    factored.needs("--steps");
    for (const char* other : {"--levels", "--limit", "--smoothing", "--stencils"}) factored.excludes(other);
    for (const RuleOption& choice : rule_options())
        if (choice.flag != k_steps_option && choice.flag != k_recede_option)
            factored.excludes(std::string(choice.flag));
    command.option("--report", "R.json", options->report, "Write figures as JSON");
    command.runs([options, command] {
        options->adapts = command.given("--near");
        if (!options->factored) {
            if (!command.given("--levels"))
                throw UsageError(
                    "--levels, or --factored with --steps, is required; tetrakis refine --help says what there is");
            if (command.given("--steps")) options->rules.averaging_steps = options->steps;
        }
        return run(*options);
    });
}

}  // namespace tetrakis::cli
