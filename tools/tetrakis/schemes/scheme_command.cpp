#include "../commands.hpp"
#include "../console.hpp"
#include "../files.hpp"
#include "../report.hpp"
#include "../run_options.hpp"
#include "scheme_picture.hpp"
#include "scheme_report.hpp"

#include "../../../eval/estimate/mask_norm_bound.hpp"
#include "../../../schemes/analysis/spectrum.hpp"
#include "../../../schemes/core/rule_step.hpp"
#include "../../../schemes/core/scheme_table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace tetrakis::cli {
namespace {

struct SchemeOptions {
    std::string scheme;
    std::optional<int> valence;
    bool boundary = false, corner = false, dart = false, matrix = false, json = false;
    RuleOptions rules;
    std::filesystem::path image;
};

// Least memory of an analysis by any scheme: the fan's points and rules for each edge, and, for rules with the whole
// ring as support, the terms of their rows (measured from 1000 to 4096 edges).
constexpr std::uint64_t k_bytes_per_edge = 12 * 1024, k_bytes_per_pair = 16;
// Of each number of a matrix printed as JSON: the number and its text.
constexpr std::uint64_t k_bytes_per_number = 48;
// Of a picture, for each edge: the mesh, refined twice.
constexpr std::uint64_t k_bytes_drawn_per_edge = 300 * 1024;

/// @throws UsageError  less memory is free
void check_memory(const std::string& what, std::uint64_t bytes) {
    const std::uint64_t there = free_memory_bytes();
    if (there == 0 || bytes <= there) return;
    throw UsageError(fmt::format("{} takes about {:.3g} GB of memory, and {:.3g} are free; ask for a lower --valence",
                                 what, 1e-9 * static_cast<double>(bytes), 1e-9 * static_cast<double>(there)));
}

void check_memory(const SchemeInfo& scheme, const SchemeOptions& options, const FanShape& shape, int valence) {
    const auto n = static_cast<std::uint64_t>(valence);
    const bool pairs = scheme.sees_rings && !options.boundary;
    check_memory(fmt::format("--valence {}", valence), n * k_bytes_per_edge + (pairs ? n * n * k_bytes_per_pair : 0));
    if (options.matrix && options.json) {
        const FanLabels labels(fan_lattice(scheme, shape, options.rules), shape,
                               fan_rings(scheme, shape, options.rules));
        const auto size = static_cast<std::uint64_t>(labels.size());
        check_memory(fmt::format("--matrix, {0} x {0} numbers as JSON,", size), size * size * k_bytes_per_number);
    }
    if (!options.image.empty()) check_memory(fmt::format("--image at valence {}", valence), n * k_bytes_drawn_per_edge);
}

/// Factor of the certified estimator's bound on the distance between a mesh and its limit, over a cell at the vertex.
std::optional<tetrakis::detail::CellNormTable::Total> mask_norm(const SchemeInfo& scheme, const FanShape& shape,
                                                                const RuleOptions& rules) {
    if (!has_mask_norms(scheme, rules)) return std::nullopt;
    return tetrakis::detail::CellNormTable(scheme, rules).total(shape);
}

void draw(const SchemeFindings& f, const SchemeOptions& options) {
    const SpectralAnalysis& a = f.analysis;
    const FanLabels& labels = a.matrix.labels;
    if (labels.lattice() == FanLattice::pentagons)
        throw std::invalid_argument(fmt::format(
            "there is no picture of the boundary of {}, whose vertices have one face more in each step; leave "
            "out --image, or --boundary",
            f.scheme.name));
    SchemePicture picture{
        .title = fmt::format("{}: {} at {}", f.scheme.name, title_of(f), looked_at(f, labels)),
        .subtitle = fmt::format(
            "{}, third {:.6g}, {}; red: where the new point lies",
            f.boundary() ? fmt::format("eigenvalue along the boundary {:.6g}, across it {:.6g}", a.lambda1, a.lambda2)
            : f.valence == 2
                ? fmt::format("eigenvalue along the two edges {:.6g}, across them {:.6g}", a.lambda1, a.lambda2)
                : fmt::format("subdominant eigenvalue {:.6g}", a.lambda1),
            a.third,
            f.boundary()     ? a.proper ? "tangent plane" : "no tangent plane by the spectrum"
            : a.proper       ? fmt::format("curvature {}", name(a.curvature))
            : f.valence == 2 ? "no tangent plane by the spectrum"
                             : "curvature not classified"),
        .scheme = f.scheme,
        .analysis = a,
        .rules = options.rules,
        .masks = {}};
    // Of many masks at a boundary only the first are drawn; farther inside they are similar.
    constexpr std::size_t k_most_masks = 48;
    constexpr int k_sectors_drawn = 6;
    const std::vector<int> rows = shown_rows(f.analysis.matrix);
    for (const int i : rows) {
        const FanLabel label = labels.all()[i];
        if (rows.size() > k_most_masks && label.sector >= k_sectors_drawn) continue;
        // With hexagons, the points across the edges that leave the middle face are the old face's corners.
        const bool old = labels.shape().hexagons && label.a == 1 && label.b == 1;
        picture.masks.push_back({fmt::format("new {}{}", place_name(labels, label), old ? ", an old vertex" : ""),
                                 row_of(f.analysis.matrix, i), i});
    }
    const auto add = [&](const char* title, const std::vector<double>& weights) {
        if (!weights.empty()) picture.masks.push_back({title, weights, {}});
    };
    add("limit position", f.masks.limit);
    add("tangent 1", f.masks.tangent1);
    add("tangent 2", f.masks.tangent2);
    const auto image = draw_scheme(picture, {});
    catch_interrupts();
    write_png(options.image, image);
    let_interrupts_end();
}

/// @throws UsageError  the scheme has no vertex or face of that valence
void check_valence(const SchemeInfo& scheme, const SchemeOptions& options, bool dual) {
    if (!options.valence || (options.boundary && dual)) return;
    const int least = dual ? 3 : 2;
    if (*options.valence >= least) return;
    throw UsageError(fmt::format(
        "--valence {}: {} {}{}", *options.valence,
        dual ? fmt::format("{} is looked at around a face, which has at least", scheme.name) : "a vertex has at least",
        dual ? "3 corners" : "2 edges",
        !dual || *options.valence != 2          ? ""
        : scheme.family == MeshFamily::hexagons ? "; its old vertices have one rule for any number of edges"
                                                : "; a vertex inside with two edges becomes no face in a dual scheme: "
                                                  "its two new points are joined by an edge"));
}

/// Warnings for options that the scheme uses, but not at this point: the matrix is the same without them.
std::vector<std::string> idle_options(const SchemeFindings& f) {
    const LocalMatrix& matrix = f.analysis.matrix;
    std::vector<std::string> warnings;
    for (const RuleOption& choice : rule_options()) {
        if (choice.flag == k_steps_option) continue;  // other numbers of steps have other points: no comparison
        RuleOptions without = f.rules;
        choice.reset(without);
        if (rule_choices(without) != rule_choices(f.rules) &&
            local_matrix(f.scheme, matrix.labels.shape(), without).rows == matrix.rows)
            warnings.push_back(
                fmt::format("{} has no effect on {} at {}", choice.flag, f.scheme.name, looked_at(f, matrix.labels)));
    }
    return warnings;
}

ExitCode run(SchemeOptions options) {
    const SchemeInfo& scheme = chosen_scheme(options.scheme);
    OutputFiles outputs;
    outputs.add(OutputFiles::Kind::picture, "--image", options.image);
    outputs.check({});
    std::vector<std::string> warnings = unused_rule_options(options.rules, scheme);
    const bool idle_angle = options.rules.measure_corner_angles || (options.rules.corner_angle != 0 && !options.corner);
    if (idle_angle && warnings.empty())
        warnings.push_back(options.corner ? "--corner-angle measured has no effect here: there is no control mesh"
                                          : "--corner-angle has no effect here: at no vertex but a --corner");
    print_warnings(warnings);
    // At a corner of a dual scheme there is one face after a step.
    const bool dual_corner = options.corner && fan_lattice(scheme, options.rules) == FanLattice::dual;
    const int valence = options.valence.value_or(dual_corner ? 2 : regular_valence(scheme, options.boundary));
    FanShape shape{.faces = valence, .boundary = options.boundary, .corner = options.corner, .dart = options.dart};
    const FanLattice lattice = fan_lattice(scheme, shape, options.rules);
    const bool dual = lattice == FanLattice::dual;
    check_valence(scheme, options, dual);
    // A boundary vertex has one face less than edges; a dual scheme's boundary has no valence.
    if (options.boundary && !dual) shape.faces = valence - 1;
    if (options.boundary && dual && options.valence)
        throw UsageError(
            fmt::format("{} is a dual scheme: its boundary is regular after a step and has no --valence", scheme.name));
    if (lattice == FanLattice::pentagons && options.valence)
        throw UsageError(
            fmt::format("a boundary vertex of {} has one edge more in each step and so no --valence", scheme.name));
    if (options.valence) check_memory(scheme, options, shape, valence);
    let_interrupts_end();
    try {
        SpectralAnalysis analysis = analyse(scheme, shape, options.rules);
        SchemeMasks masks = scheme_masks(scheme, analysis, options.rules);
        const SchemeFindings findings{scheme,
                                      options.rules,
                                      std::move(analysis),
                                      std::move(masks),
                                      valence,
                                      reproduction_degree(scheme, options.rules),
                                      support_radius(scheme, options.rules),
                                      mask_norm(scheme, shape, options.rules)};
        // Options without any use for the scheme have been reported above.
        if (warnings.empty()) print_warnings(idle_options(findings));
        if (!options.image.empty()) draw(findings, options);
        if (options.json)
            fmt::print("{}", dump(scheme_json(findings, options.matrix)));
        else
            print_scheme(findings, options.matrix);
    } catch (const std::invalid_argument& e) {
        throw UsageError(e.what());
    }
    return ExitCode::done;
}

ExitCode print_list_as_json() {
    Json list = Json::array();
    for (const SchemeInfo& s : scheme_table())
        list.push_back({{"name", s.name},
                        {"title", s.title},
                        {"refinement", name(s.refinement)},
                        {"faces", name(s.family)},
                        {"interpolating", s.interpolating},
                        {"smoothness", s.smoothness},
                        {"reproduction_degree", s.reproduction},
                        {"generation_degree", s.generation},
                        {"notes", s.notes}});
    fmt::print("{}", dump(list));
    return ExitCode::done;
}

ExitCode print_list() {
    std::size_t width = 0;
    for (const SchemeInfo& s : scheme_table()) width = std::max(width, s.name.size());
    fmt::print("{:<{}}  {:<12}  {:<8}  {:<13}  {:<10}  what it takes\n", "name", width, "refinement", "faces", "",
               "smoothness");
    for (const SchemeInfo& s : scheme_table())
        fmt::print("{:<{}}  {:<12}  {:<8}  {:<13}  {:<10}  {}\n", s.name, width, name(s.refinement), name(s.family),
                   s.interpolating ? "interpolating" : "approximating", s.smoothness.substr(0, s.smoothness.find(' ')),
                   s.notes);
    fmt::print("\nSmoothness: on regular meshes. \"tetrakis scheme NAME\" explains one.\n");
    return ExitCode::done;
}

}  // namespace

void add_scheme_command(CommandLine program) {
    auto options = std::make_shared<SchemeOptions>();
    CommandLine command = program.command("scheme", "Explains a subdivision scheme: masks, eigenvalues, limits",
                                          "Example:\n  tetrakis scheme loop --valence 5 --image loop5.png");
    command.option("NAME", "", options->scheme, "Scheme; \"tetrakis schemes\" lists them").required();
    command.option("--valence", "N", options->valence,
                   "Edges at the vertex, or corners of the face of a dual scheme (the regular number)");
    command.flag("--boundary", options->boundary, "Look at a boundary vertex, or a dual scheme's boundary edge");
    command.flag("--corner", options->corner,
                 "Look at a corner: between two sharp edges, at a boundary or not; see --corner-angle");
    command.flag("--dart", options->dart, "Look at a dart: a vertex inside where a crease ends")
        .excludes("--corner")
        .excludes("--boundary");
    command.flag("--matrix", options->matrix, "The local subdivision matrix as well");
    command.flag("--json", options->json, "Print JSON");
    command.option("--image", "PNG", options->image, "Draw masks, characteristic map and basis function (.png)");
    add_rule_options(command, options->rules);
    command.runs([options] {
        options->boundary = options->boundary || options->corner;
        return run(*options);
    });
}

void add_schemes_command(CommandLine program) {
    auto json = std::make_shared<bool>(false);
    CommandLine command = program.command("schemes", "Lists the subdivision schemes", "Example:\n  tetrakis schemes");
    command.flag("--json", *json, "Print JSON");
    command.runs([json] { return *json ? print_list_as_json() : print_list(); });
}

}  // namespace tetrakis::cli
