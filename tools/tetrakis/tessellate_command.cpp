#include "commands.hpp"
#include "console.hpp"
#include "files.hpp"
#include "report.hpp"
#include "run_options.hpp"

#include "../../eval/io/mesh_reader.hpp"
#include "../../eval/io/mesh_writer.hpp"
#include "../../eval/io/png.hpp"
#include "../../eval/render/render.hpp"
#include "../../eval/surface/height_image.hpp"
#include "../../eval/tessellate/tessellate.hpp"
#include "../../hier/base/files.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <memory>
#include <optional>
#include <string>

namespace tetrakis::cli {
namespace {

struct TessellateCommandOptions {
    std::filesystem::path input, target, displacement, output, report, image, heat_image;
    std::string scheme{name(SchemeKind::catmull_clark)};
    TessellateOptions tessellate;
    std::optional<double> amplitude;
    ReadOptions read;
    bool no_measure = false;
    RenderOptions render;
    bool scheme_given = false;
    std::string view_option;  ///< the first of --size, --camera and --up that is given, or empty
    RunOptions run;
};

/// Checks the options that need or exclude each other in ways that the option parser cannot see.
void check_combination(const TessellateCommandOptions& options) {
    const TessellateOptions& t = options.tessellate;
    if (!t.tolerance && t.max_triangles == 0)
        throw UsageError("how fine? Give --tolerance (such as 1e-3), --max-triangles or both");
    if (t.estimator == EstimatorKind::certified && (!options.target.empty() || !options.displacement.empty()))
        throw UsageError(
            "--estimator certified bounds the distance to the limit surface itself; with --target or --displacement "
            "use --estimator measured");
    if (!options.view_option.empty() && options.image.empty() && options.heat_image.empty())
        throw UsageError(options.view_option + " is about pictures: give --image or --image-heat too");
    if (t.min_level > t.max_level) throw UsageError("--min-level is above --max-level");
    const SchemeSupport support = scheme_support(t.scheme, t.rules);
    if (!support.patches && (!options.target.empty() || !options.displacement.empty()))
        throw UsageError(std::string(options.target.empty() ? "--displacement" : "--target") +
                         " needs exact points all over the surface: use --scheme catmull-clark or loop, without "
                         "options for their rules");
    if (!support.certified && t.estimator == EstimatorKind::certified)
        throw UsageError(
            fmt::format("there is no certified bound for {}, whose limit is known at points alone: use "
                        "--estimator measured, or one of these for --scheme: {}",
                        t.scheme.name(), certified_scheme_names()));
}

OutputFiles output_files(const TessellateCommandOptions& options) {
    OutputFiles outputs;
    outputs.add(OutputFiles::Kind::mesh, "-o", options.output);
    outputs.add(OutputFiles::Kind::report, "--report", options.report);
    outputs.add(OutputFiles::Kind::picture, "--image", options.image);
    outputs.add(OutputFiles::Kind::picture, "--image-heat", options.heat_image);
    return outputs;
}

/// Message that the tolerance was missed, with the limit that stopped the refinement.
std::string advice(const TessellateCommandOptions& options, const Tessellation& result) {
    const std::string what = "the tolerance was not reached; the best result is written all the same";
    // Room for one more split: it adds two triangles or more, for dual schemes six, and its closure adds others.
    const std::uint64_t budget = options.tessellate.max_triangles, room = budget / 50 + 8;
    if (budget != 0 && result.mesh.triangles.size() + room >= budget) return what + " (all of --max-triangles is used)";
    if (result.deepest_level >= options.tessellate.max_level) return what + " (--max-level stopped the refinement)";
    return what;
}

Report make_report(const TessellateCommandOptions& options, const LoadedModel& model, const Tessellation& result) {
    Report report = Report::of(options.input, options.tessellate.scheme.name(), model, options.run);
    report.vertices = result.mesh.positions.size();
    report.triangles = result.mesh.triangles.size();
    if (options.tessellate.tolerance) {
        const double diagonal = model.mesh.bounding_box().diagonal();
        report.tolerance_absolute = result.tolerance_absolute;
        report.tolerance = options.tessellate.tolerance_is_absolute ? result.tolerance_absolute / diagonal
                                                                    : *options.tessellate.tolerance;
    }
    report.certified_error = result.certified_error;
    report.measured_error = result.measured_error;
    report.levels = result.deepest_level;
    report.seconds = result.seconds;
    report.seconds.load = model.load_seconds;
    report.seconds.build += model.build_seconds;
    report.warnings.insert(report.warnings.end(), result.warnings.begin(), result.warnings.end());
    if (!options.scheme_given && model.mesh.all_triangles())
        report.warnings.push_back(
            "all faces are triangles, which --scheme loop is made for: its surface is smoother there, and it is faster "
            "(--scheme catmull-clark, the default, says that you mean it)");
    for (std::string& warning : unused_rule_options(options.tessellate.rules, options.tessellate.scheme.info()))
        report.warnings.push_back(std::move(warning));
    constexpr double k_large_share = 0.1;
    if (report.tolerance && !options.tessellate.tolerance_is_absolute && *report.tolerance > k_large_share)
        report.warnings.push_back(fmt::format(
            "the tolerance is {:g} times the diagonal of the model; for a length in its unit add --absolute",
            *report.tolerance));
    report.more["estimator"] = options.tessellate.estimator == EstimatorKind::certified ? "certified" : "measured";
    report.more["tolerance_reached"] = options.tessellate.tolerance ? Json(result.tolerance_reached) : Json(nullptr);
    report.more["samples"] = result.measured_error ? Json{{"forward", result.measured_error->forward_samples},
                                                          {"backward", result.measured_error->backward_samples}}
                                                   : Json(nullptr);
    report.more["peak_memory_before_measure_bytes"] = result.peak_memory_before_measure_bytes;
    return report;
}

/// @param mesh  the control mesh that was tessellated
void print_summary(const TessellateCommandOptions& options, const ControlMesh& mesh, const Tessellation& result,
                   const Report& report) {
    const TessellateOptions& t = options.tessellate;
    const double tolerance = report.tolerance_absolute.value_or(0);
    const auto share = [&](double error) {
        return tolerance > 0 ? fmt::format("{}, {:.3f} of the tolerance", format_length(error), error / tolerance)
                             : format_length(error);
    };
    Table table;
    table.row("input",
              fmt::format("{} ({} faces, {})", options.input.string(), format_count(report.faces), report.scheme));
    table.row("result", fmt::format("{} triangles, {} vertices, deepest level {}", format_count(*report.triangles),
                                    format_count(report.vertices), report.levels));
    // A relative tolerance means nothing for a model without extent.
    if (report.tolerance && std::isfinite(*report.tolerance))
        table.row("tolerance",
                  fmt::format("{:<10} {:.3g} of the diagonal", format_length(tolerance), *report.tolerance));
    else if (report.tolerance_absolute)
        table.row("tolerance", format_length(tolerance));
    if (const auto& error = report.measured_error) {
        std::string text = share(error->hausdorff);
        if (tolerance > 0 && error->hausdorff > tolerance)
            text += result.tolerance_reached ? " (too large; the proven bound holds)" : " (missed)";
        else if (tolerance > 0 && result.tolerance_reached)
            text += " (kept)";
        table.row("measured error", text);
        table.row("",
                  fmt::format("{0} to mesh {1}, mesh to {0} {2}, mean {3}, rms {4}",
                              options.target.empty() ? "surface" : "target", format_length(error->forward),
                              format_length(error->backward), format_length(error->mean), format_length(error->rms)));
        table.row("", fmt::format("in {} samples", format_count(error->forward_samples + error->backward_samples)));
    } else if (tolerance > 0 && result.tolerance_reached && t.estimator == EstimatorKind::measured) {
        table.row("measured error", "left out (--no-measure); within the tolerance where refinement took samples");
    }
    if (report.certified_error) {
        const bool proves_less = tolerance > 0 && *report.certified_error > tolerance;
        const bool can_prove = t.estimator == EstimatorKind::measured && t.max_triangles == 0 &&
                               result.tolerance_reached && scheme_support(mesh, t.scheme, t.rules).certified;
        table.row("proven error", "at most " + share(*report.certified_error) +
                                      (proves_less && can_prove ? "; --estimator certified proves 1.0" : ""));
    }
    finish_summary(table, report, {options.output, options.report, options.image, options.heat_image});
}

Image draw(const Tessellation& result, const TessellateCommandOptions& options, bool heat, const RunContext& context) {
    RenderOptions render_options = options.render;
    render_options.wireframe = !heat;
    if (heat) {
        render_options.triangle_values = result.triangle_error;
        render_options.legend_title = "error";
        // The colour scale ends at the tolerance, so that colours show parts of it.
        if (std::isfinite(result.tolerance_absolute)) render_options.highest_value = result.tolerance_absolute;
    }
    return render(result.mesh, render_options, context);
}

TriangleMesh read_target(const std::filesystem::path& path, const RunContext& context) {
    TriangleMesh target = read_triangle_mesh(path, context);
    const bool has_area = std::any_of(target.triangles.begin(), target.triangles.end(), [&](const auto& t) {
        const Vec3d a = target.positions[t[0]], ab = target.positions[t[1]] - a, ac = target.positions[t[2]] - a;
        return glm::length(glm::cross(ab, ac)) > 0;
    });
    if (!has_area) throw Error(ErrorCode::invalid_input, "no triangle of the target has any area", path);
    return target;
}

ExitCode run_checked(TessellateCommandOptions& options) {
    Run process(options.run);
    const RunContext& context = process.context();
    LoadedModel model = load_model(options.input, options.read, context, &options.tessellate.scheme.info());

    const Stopwatch load_others;
    TriangleMesh target;
    if (!options.target.empty()) {
        target = reading(options.target, [&] { return read_target(options.target, context); });
        options.tessellate.target = &target;
    }
    HeightImage heights;
    if (!options.displacement.empty()) {
        if (!model.mesh.has_uvs())
            throw InputError(options.input.string() +
                             ": --displacement needs texture coordinates, and the control mesh has none");
        heights = reading(options.displacement, [&] { return load_height_image(options.displacement); });
        options.tessellate.displacement = &heights;
        options.tessellate.amplitude = *options.amplitude;
    }
    model.load_seconds += load_others.seconds();
    options.tessellate.measure = !options.no_measure;
    options.tessellate.floats_written = mesh_format(options.output) == MeshFormat::glb;

    const Tessellation result = tessellate(model.mesh, options.tessellate, context);
    std::optional<Image> image, heat_image;
    if (!options.image.empty()) image = draw(result, options, false, context);
    if (!options.heat_image.empty()) heat_image = draw(result, options, true, context);

    Report report = make_report(options, model, result);
    const bool missed = options.tessellate.tolerance && !result.tolerance_reached;
    write_results(process, report, options.report, [&](FileSet& files) {
        write_mesh(files.add(options.output), result.mesh, context);
        if (image) write_png(files.add(options.image), *image);
        if (heat_image) write_png(files.add(options.heat_image), *heat_image);
    });
    if (missed) print_warning(advice(options, result));
    print_summary(options, model.mesh, result, report);
    return missed ? ExitCode::tolerance_not_reached : ExitCode::done;
}

ExitCode run(TessellateCommandOptions options) {
    options.tessellate.scheme = chosen_scheme(options.scheme);
    check_combination(options);
    output_files(options).check({options.input, options.target, options.displacement});
    return about(options.input, [&] { return run_checked(options); });
}

void add_refinement_options(CommandLine command, TessellateOptions& t) {
    command
        .option("--tolerance", "T", t.tolerance,
                "Largest distance allowed between mesh and limit surface (or target), in both directions, as a\n"
                "share of the diagonal of the box of all vertices that faces of the control mesh use")
        .number("a positive number (a share of the diagonal such as 1e-3, or with --absolute a length)",
                [](double x) { return x > 0; });
    command.flag("--absolute", t.tolerance_is_absolute, "The tolerance is a length in the unit of the model")
        .needs("--tolerance");
    const auto take_triangles = [&t](const std::string& text) {
        const std::uint64_t count = parse_size(text, k_thousand).value_or(0);
        t.max_triangles = count;
        return count < 1 || count > std::numeric_limits<std::uint32_t>::max()
                   ? text + " is no number such as 5000 or 10k"
                   : "";
    };
    command.option_function(
        "--max-triangles", "N", take_triangles,
        "Make the best mesh of at most so many triangles (5000, 10k). Where even the coarsest mesh, which\n"
        "keeps the control mesh's corners, has more, nothing is written, and the error says how many it has");
    const auto take_estimator = [&t](const std::string& name) {
        t.estimator = name == "certified" ? EstimatorKind::certified : EstimatorKind::measured;
        return name == "certified" || name == "measured" ? "" : name + " not in {measured,certified}";
    };
    command.option_function(
        "--estimator", "E", take_estimator,
        "What is to be within the tolerance: measured (default; the distances of closest points; fewest triangles) "
        "or\n"
        "certified (a proven bound on them)");
    command.option("--min-level", "N", t.min_level, "Cut every face at least so often")
        .range(0, TessellateOptions{}.max_level, Option::InHelp::yes);
    command.option("--max-level", "N", t.max_level, "Cut no face more often")
        .range(0, TessellateOptions{}.max_level, Option::InHelp::yes);
}

}  // namespace

void add_tessellate_command(CommandLine program) {
    auto options = std::make_shared<TessellateCommandOptions>();
    CommandLine command = program.command(
        "tessellate", "Makes a watertight triangle mesh of the limit surface, as fine as a tolerance asks",
        "Exit code 4: the tolerance was not reached, the best result is written all the same.\n"
        "Example:\n  tetrakis tessellate data/rook.obj --tolerance 1e-3 -o rook.glb --report rook.json");
    command.option("IN", "", options->input, "Control mesh (.obj)").required();
    command.option("-o,--output", "OUT", options->output, "Mesh to write: .obj, .ply or .glb").required();
    command.option("--scheme", "S", options->scheme,
                   "Subdivision scheme, any that \"tetrakis schemes\" lists (catmull-clark). Honeycomb is refined by\n"
                   "whole levels, the others where that is needed.\n"
                   "Catmull-clark and loop are exact everywhere; the others are known by their limit points: errors\n"
                   "are measured against a denser mesh of these, and there is no --target or --displacement.\n"
                   "These have certified errors, for the others certified_error is null:\n" +
                       certified_scheme_names());
    add_rule_options(command, options->tessellate.rules);
    add_refinement_options(command, options->tessellate);
    command.option("--target", "MESH", options->target,
                   "Project the vertices onto this mesh (a scan, a sculpt). The tolerance holds both ways: a target\n"
                   "that reaches beyond what the control mesh covers makes exit code 4, with a warning. With\n"
                   "--displacement too, vertices are raised first and then projected");
    const Option displacement = command.option("--displacement", "IMG", options->displacement,
                                               "Raise the surface by this picture's heights, by UV");
    command.option("--amplitude", "A", options->amplitude, "How far white is raised, in the unit of the model")
        .number("a finite number", [](double) { return true; })
        .needs("--displacement");
    displacement.needs("--amplitude");
    command
        .option("--crease-angle", "DEG", options->tessellate.crease_degrees,
                "Give a vertex several normals where its limit normal is farther than this off a triangle, in\n"
                "degrees: on roundings tighter than the tolerance. Infinitely sharp edges always are hard")
        .shows_default()
        .number("an angle from 0 to 180 degrees", [](double x) { return x >= 0 && x <= 180; });
    command.flag("--no-measure", options->no_measure, "Do not measure the result at the end");
    command
        .option("--samples", "N", options->tessellate.measure_samples,
                "Points to sample in each direction when the result is measured, about; at most some 300 a triangle")
        .shows_default()
        .range(std::uint64_t{1}, k_most_samples, Option::InHelp::yes)
        .excludes("--no-measure");
    add_read_options(command, options->read);
    command.option("--report", "R.json", options->report, "Write figures as JSON");
    command.option("--image", "I.png", options->image, "Draw the result with its wireframe");
    command.option("--image-heat", "H.png", options->heat_image, "Draw the result coloured by its error");
    add_view_options(command, options->render);
    options->run.add(command);
    command.runs([options, command] {
        options->scheme_given = command.given("--scheme");
        options->view_option = given_view_option(command);
        return run(*options);
    });
}

}  // namespace tetrakis::cli
