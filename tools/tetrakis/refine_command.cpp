#include "commands.hpp"
#include "console.hpp"
#include "factored_refine.hpp"
#include "files.hpp"
#include "report.hpp"
#include "run_options.hpp"
#include "scheme_option.hpp"

#include "../../eval/io/mesh_writer.hpp"
#include "../../eval/io/stencil_writer.hpp"
#include "../../hier/base/files.hpp"
#include "../../refine/uniform/refine.hpp"

#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace tetrakis::cli {
namespace {

constexpr std::string_view k_averaging_steps_option = "--averaging-steps";

struct Options {
    std::filesystem::path input, output, report;
    std::filesystem::path stencils;
    std::string scheme{name(SchemeKind::catmull_clark)}, near, radius;
    RuleOptions rules;
    int levels = 0, smoothing = 0, steps = 0;
    ReadOptions read;
    bool limit = false, factored = false, active = false, adapts = false;
    RunOptions run;
};

/// What a refinement may take of the memory limit: the program itself is part of that, and allocators take more than
/// they are asked for.
class MemoryRest {
  public:
    explicit MemoryRest(const RunContext& whole)
        : context_(whole), limit_(whole.max_memory_bytes), used_(memory_bytes()) {
        constexpr std::uint64_t k_percent = 92;
        if (limit_ != 0) context_.max_memory_bytes = limit_ > used_ ? (limit_ - used_) / 100 * k_percent : 1;
    }
    const RunContext& context() const { return context_; }
    [[noreturn]] void rethrow(const Error& error) const {
        if (error.code() != ErrorCode::memory_limit) throw;
        // The caller names the file.
        std::string text = error.what();
        if (const std::string file = error.file().string() + ": "; text.starts_with(file)) text.erase(0, file.size());
        throw Error(error.code(), fmt::format("{} (all in all {} MiB, of which {} MiB were in use before)", text,
                                              limit_ >> 20, used_ >> 20));
    }

  private:
    RunContext context_;
    std::uint64_t limit_, used_;
};

/// By whole levels. The control vertices' weights come with it where they are asked for.
PolygonMesh refine_by_levels(const Options& options, const SchemeInfo& scheme, const ControlMesh& mesh,
                             const RunContext& context, StencilTable& stencils) {
    const MemoryRest rest(context);
    const RefineOptions refine_options{.rules = options.rules,
                                       .smoothing = options.smoothing,
                                       .limit = options.limit,
                                       .normals = options.limit,
                                       .context = rest.context()};
    try {
        if (options.stencils.empty()) return refine(mesh, scheme, options.levels, refine_options);
        RefinedStencils refined = refine_stencils(mesh, scheme, options.levels, refine_options);
        stencils = std::move(refined.stencils);
        return std::move(refined.mesh);
    } catch (const Error& error) {
        rest.rethrow(error);
    }
}

/// @param factored  the scheme, where half-steps are asked for
/// @param sphere    where they adapt
ExitCode run_checked(const Options& options, const SchemeInfo& scheme, std::optional<FactoredScheme> factored,
                     const std::optional<HalfStepSphere>& sphere) {
    Run process(options.run);
    LoadedModel model = load_model(options.input, options.read, process.context());
    const std::uint64_t faces = model.mesh.face_count();
    const Stopwatch build;
    prepare_for(scheme, model.mesh, process.context());
    model.build_seconds += build.seconds();
    Report report = Report::of(options.input, scheme.name, model, options.run);
    report.faces = faces;  // as read
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

ExitCode run(const Options& options) {
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

void add_refine_command(CLI::App& app, Command& chosen) {
    auto options = std::make_shared<Options>();
    CLI::App* command = app.add_subcommand("refine", "Refines a control mesh everywhere, by whole levels");
    command->add_option("IN", options->input, "Control mesh (.obj)")->required()->type_name("");
    command
        ->add_option("--scheme", options->scheme,
                     "Subdivision scheme, any that \"tetrakis schemes\" lists (catmull-clark)")
        ->type_name("S");
    constexpr int k_most_levels = 31, k_most_steps = 64;  // far beyond what 32-bit indices allow; the library says so
    CLI::Option* levels = command->add_option("--levels", options->levels, "Steps of the scheme")
                              ->type_name("N")
                              ->check(CLI::Range(0, k_most_levels));
    CLI::Option* limit =
        command->add_flag("--limit", options->limit, "Put the vertices on the limit surface, with its normals");
    CLI::Option* steps = command
                             ->add_option("--steps", options->steps,
                                          "With --factored: half-steps, two for a level (averaging: two more than its "
                                          "averaging steps). Else, for averaging: its number of averaging steps in a "
                                          "level, 0 to 64 (3)")
                             ->type_name("K")
                             ->check(CLI::Range(0, k_most_steps));
    CLI::Option* averaging_steps =
        command
            ->add_option(std::string(k_averaging_steps_option), options->rules.averaging_steps,
                         "With --factored, for averaging: what --steps is without it (3)")
            ->type_name("M")
            ->check(CLI::Range(0, k_most_steps).description(""));
    const std::vector<CLI::Option*> choices = add_rule_options(*command, options->rules);
    CLI::Option* smoothing = command
                                 ->add_option("--smoothing", options->smoothing,
                                              "Rounds of smoothing of the control points first, for interpolating "
                                              "schemes (0)")
                                 ->type_name("N")
                                 ->check(CLI::Range(0, 100).description(""));
    CLI::Option* factored = command->add_flag(
        "--factored", options->factored,
        "By half-steps on the 4-8 mesh, which is written as triangles (after none of Catmull-Clark's: "
        "the control mesh); --steps "
        "says how many. For " +
            factored_scheme_names());
    CLI::Option* active =
        command
            ->add_flag("--active", options->active,
                       "With --factored: write the scheme's own faces after the last whole level, not the 4-8 mesh")
            ->needs(factored);
    CLI::Option* near = command
                            ->add_option("--near", options->near,
                                         "With --factored: all half-steps only inside of a sphere about this point, "
                                         "and outside as few as the mesh allows. For catmull-clark and dual schemes")
                            ->type_name("X,Y,Z")
                            ->needs(factored)
                            ->excludes(active);
    CLI::Option* radius =
        command->add_option("--radius", options->radius, "Of that sphere")->type_name("R")->needs(near);
    near->needs(radius);
    options->run.add(*command);
    add_read_options(*command, options->read);
    command->add_option("-o,--output", options->output, "Mesh to write: .obj, .ply or .glb")
        ->required()
        ->type_name("OUT");
    CLI::Option* stencils =
        command
            ->add_option(
                "--stencils", options->stencils,
                "Write the vertices as weights of control vertices (by the rules, so in their order), in compressed "
                "rows (CSR): after \"tetrakis-stencils 2\" and the numbers of rows, control vertices and terms a line "
                "of where rows begin, one of control vertices and one of weights")
            ->type_name("T.txt");
    factored->needs(steps);
    averaging_steps->needs(factored);
    for (CLI::Option* other : {levels, limit, smoothing, stencils}) factored->excludes(other);
    for (CLI::Option* other : choices)
        if (!other->check_name(std::string(k_recede_option))) factored->excludes(other);
    command->add_option("--report", options->report, "Write figures as JSON")->type_name("R.json");
    command->footer("Example:\n  tetrakis refine data/pawn.obj --scheme catmull-clark --levels 3 --limit -o pawn.obj");
    command->callback([options, levels, steps, near, &chosen] {
        options->adapts = near->count() != 0;
        if (!options->factored) {
            if (levels->count() == 0) throw CLI::RequiredError("--levels, or --factored with --steps,");
            if (steps->count() != 0) options->rules.averaging_steps = options->steps;
        }
        chosen = [options] { return run(*options); };
    });
}

}  // namespace tetrakis::cli
