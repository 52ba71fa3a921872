#include "commands.hpp"
#include "console.hpp"
#include "files.hpp"
#include "report.hpp"
#include "scheme_option.hpp"
#include "scheme_picture.hpp"

#include "tetrakis/eval/mask_norm_bound.hpp"
#include "tetrakis/schemes/spectrum.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
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
    bool boundary = false, matrix = false, json = false;
    RuleOptionFlags flags;
    RuleOptions rules;
    std::filesystem::path image;
};

// Of long lists, people see this much; JSON has all.
constexpr std::size_t k_shown_eigenvalues = 12;
constexpr double k_same_eigenvalue = 1e-6;
// A multiple eigenvalue 0 comes out as large as a root of the rounding error.
constexpr double k_zero_eigenvalue = 1e-4;
// The largest matrix is computed with in a few seconds and some hundred megabytes.
constexpr int k_most_valence = 256;

/// The number, without the noise of its last digits.
std::string number(double x) {
    if (std::abs(x) < 1e-14) return "0";
    return fmt::format("{:.10g}", x);
}

/// Whether the points lie on and between edges that leave a vertex.
bool has_edges(const FanLabels& labels) {
    return labels.lattice() == FanLattice::triangles || labels.lattice() == FanLattice::quads;
}

std::string place_name(const FanLabels& labels, FanLabel label) {
    if (labels.lattice() != FanLattice::dual && label.a == 0 && label.b == 0) return "c";
    if (has_edges(labels) && label.a == 1 && label.b == 0) return fmt::format("e{}", label.sector);
    return fmt::format("({}; {}, {})", label.sector, label.a, label.b);
}

std::string mask_text(const FanLabels& labels, const std::vector<double>& weights) {
    if (weights.empty()) return "not determined: its eigenvalue is not simple";
    // Points of one weight side by side.
    std::vector<std::pair<double, std::string>> groups;
    for (int i = 0; i < labels.size(); ++i) {
        if (std::abs(weights[i]) < 1e-13) continue;
        const std::string place = place_name(labels, labels.all()[i]);
        bool found = false;
        for (auto& [weight, places] : groups)
            if (std::abs(weight - weights[i]) < 1e-12) {
                places += " " + place;
                found = true;
                break;
            }
        if (!found) groups.emplace_back(weights[i], place);
    }
    std::string text;
    for (const auto& [weight, places] : groups)
        text += fmt::format("{}{} of {}", text.empty() ? "" : ", ", number(weight), places);
    return text;
}

Json label_json(FanLabel label) { return Json::array({label.sector, label.a, label.b}); }

/// The new points in the middle: one of each kind, with its row of the matrix.
std::vector<int> shown_rows(const LocalMatrix& m) {
    std::vector<int> rows;
    const FanLabels& labels = m.labels;
    for (int i = 0; i < m.size(); ++i) {
        const FanLabel l = labels.all()[i];
        const bool near = labels.ring_of(l) <= 1 || (labels.lattice() == FanLattice::triangles && l.a == 1 && l.b == 1);
        // All edges of a boundary differ; of the rest sector 0 stands for the others.
        const bool first =
            l.sector == 0 || (labels.shape().boundary && has_edges(labels) && 2 * l.sector <= labels.shape().faces);
        if (near && first) rows.push_back(i);
    }
    return rows;
}

std::vector<double> row_of(const LocalMatrix& m, int i) {
    std::vector<double> row(m.size());
    for (int j = 0; j < m.size(); ++j) row[j] = m.at(i, j);
    return row;
}

struct Findings {
    const SchemeInfo& scheme;
    SpectralAnalysis analysis;
    SchemeMasks masks;
    int valence, reproduction;
    double support;
    std::optional<tetrakis::detail::CellRemainder::Total> mask_norm;
};

/// How far a mesh is from its limit over a cell at the vertex: the sum of weights that the certified estimator has.
std::optional<tetrakis::detail::CellRemainder::Total> mask_norm(const SchemeInfo& scheme, const FanShape& shape,
                                                                const RuleOptions& rules) {
    if (!has_mask_norms(scheme, rules)) return std::nullopt;
    return tetrakis::detail::CellRemainder(scheme, rules).total(shape);
}

std::string support_text(const Findings& f, FanLattice lattice) {
    if (f.scheme.family == MeshFamily::hexagons)
        return fmt::format("{} rings of faces around a vertex", number(f.support));
    if (lattice == FanLattice::dual) return fmt::format("{0} x {0} faces", number(2 * f.support));
    return fmt::format("{} rings", number(f.support));
}

/// What the table says of averaging depends on the number of steps.
std::string smoothness(const SchemeInfo& scheme, const RuleOptions& rules) {
    return scheme.name == "averaging" ? fmt::format("C{}", rules.averaging_steps) : std::string(scheme.smoothness);
}
std::string generation(const SchemeInfo& scheme, const RuleOptions& rules) {
    return scheme.name == "averaging" ? fmt::format("bi-{}", rules.averaging_steps + 1)
                                      : std::string(scheme.generation);
}

std::string looked_at(const Findings& f, const FanLabels& labels) {
    const bool dual = labels.lattice() == FanLattice::dual;
    if (labels.lattice() == FanLattice::pentagons)
        return "a boundary vertex after two steps: its two faces along the boundary";
    if (labels.shape().boundary)
        return dual ? "a boundary edge between quads" : fmt::format("a boundary vertex with {} edges", f.valence);
    return fmt::format("a {} with {} {}", dual ? "face" : "vertex", f.valence, dual ? "corners" : "edges");
}

void print_text(const Findings& f, const SchemeOptions& options) {
    const SpectralAnalysis& a = f.analysis;
    const FanLabels& labels = a.matrix.labels;
    const bool dual = labels.lattice() == FanLattice::dual;
    Table table;
    table.row("scheme", fmt::format("{}: {}", f.scheme.name, f.scheme.title));
    table.row("refinement", fmt::format("{}, {}, {}", name(f.scheme.refinement), name(f.scheme.family),
                                        f.scheme.interpolating ? "interpolating" : "approximating"));
    table.row("takes", std::string(f.scheme.notes));
    table.row("smoothness", fmt::format("{} on regular meshes", smoothness(f.scheme, options.rules)));
    table.row("polynomials", fmt::format("reproduces degree {}, generates degree {}", f.reproduction,
                                         generation(f.scheme, options.rules)));
    table.row("support", support_text(f, labels.lattice()));
    table.row("looked at", looked_at(f, labels));
    if (f.mask_norm)
        table.row("to the limit",
                  fmt::format("over a face here at most {} times how far the points around it are from {}",
                              number(f.mask_norm->sum),
                              !f.mask_norm->linear                       ? "one another"
                              : f.scheme.family == MeshFamily::triangles ? "its plane"
                                                                         : "its bilinear patch"));
    bool first = true;
    for (const int i : shown_rows(a.matrix)) {
        table.row(first ? "masks" : "", fmt::format("new {}: {}", place_name(labels, labels.all()[i]),
                                                    mask_text(labels, row_of(a.matrix, i))));
        first = false;
    }
    std::string values;
    std::size_t shown = 0, groups = 0;
    std::vector<bool> counted(a.eigenvalues.size(), false);
    for (std::size_t i = 0; i < a.eigenvalues.size(); ++i) {
        if (counted[i]) continue;
        Eigenvalue e = a.eigenvalues[i];
        int count = 0;
        const bool zero = std::abs(e.value) < k_zero_eigenvalue;
        if (zero) e.value = 0;
        // Others of the same size may lie between.
        for (std::size_t k = i; k < a.eigenvalues.size(); ++k) {
            const auto value = a.eigenvalues[k].value;
            if (counted[k] ||
                (zero ? std::abs(value) >= k_zero_eigenvalue : std::abs(value - e.value) >= k_same_eigenvalue))
                continue;
            counted[k] = true;
            count += a.eigenvalues[k].multiplicity;
        }
        ++groups;
        if (groups > k_shown_eigenvalues) continue;
        ++shown;
        std::string value = fmt::format("{:.6g}", std::abs(e.value.real()) < k_same_eigenvalue ? 0.0 : e.value.real());
        if (std::abs(e.value.imag()) > k_same_eigenvalue) value += fmt::format("{:+.6g}i", e.value.imag());
        values +=
            fmt::format("{}{}{}", values.empty() ? "" : ", ", value, count > 1 ? fmt::format(" ({})", count) : "");
    }
    if (groups > shown) values += fmt::format(", ... ({} smaller)", groups - shown);
    table.row("matrix", fmt::format("{0} x {0}, rows sum to one", a.matrix.size()));
    table.row("eigenvalues", values);
    table.row("subdominant", a.lambda1 == a.lambda2 ? number(a.lambda1)
                             : options.boundary ? fmt::format("{} along the boundary, {} across it", number(a.lambda1),
                                                              number(a.lambda2))
                                                : fmt::format("{} and {}", number(a.lambda1), number(a.lambda2)));
    table.row("third",
              fmt::format("{}; the subdominant ones' product is {}", number(a.third), number(a.lambda1 * a.lambda2)));
    const bool smaller = a.third < std::min(a.lambda1, a.lambda2) - k_same_eigenvalue;
    const bool pentagons = labels.lattice() == FanLattice::pentagons;
    table.row("tangent plane",
              pentagons   ? "not shown: the faces between the two, one more in each step, are not in the matrix"
              : !a.proper ? "not shown by the spectrum: another eigenvalue is not smaller than the tangents'"
              : smaller   ? "the spectrum allows it: 1, the tangents', all others smaller"
                          : "the spectrum allows it: what is not smaller than the tangents' varies along the boundary "
                            "alone");
    if (!options.boundary && a.proper) table.row("curvature", std::string(name(a.curvature)));
    const auto kind = [](bool formula) { return formula ? "" : " (numeric)"; };
    table.row("limit", mask_text(labels, f.masks.limit) + kind(f.masks.limit_is_formula));
    table.row("tangents",
              mask_text(labels, f.masks.tangent1) + kind(f.masks.tangent1_is_formula || f.masks.tangent1.empty()));
    table.row("", mask_text(labels, f.masks.tangent2) + kind(f.masks.tangent2_is_formula || f.masks.tangent2.empty()));
    table.print();
    if (pentagons)
        fmt::print(
            "\nPoints: c the vertex, (s; a, 0) a steps along the boundary (s = 0 ahead, 1 behind), (s; a, 1) across "
            "the "
            "face from there.\nThe second tangent is that of the two faces, which get narrow faster than the boundary "
            "bends: they end in its osculating plane.\n");
    else if (dual && options.boundary)
        fmt::print(
            "\nPoints: (s; a, b) is a steps along the boundary from the edge's middle (s = 0 ahead, 1 behind), b steps "
            "inwards.\n");
    else if (dual)
        fmt::print(
            "\nPoints: (i; a, b) is a and b steps out of the face from its corner i, along the sides before and after "
            "it.\n");
    else
        fmt::print(
            "\nPoints: c the vertex, ei its edge neighbours counter-clockwise, (i; a, b) a steps along ei, then b "
            "along the next.\n");
    if (!options.matrix) return;
    fmt::print("\n");
    for (int i = 0; i < a.matrix.size(); ++i) {
        std::string line;
        for (int j = 0; j < a.matrix.size(); ++j)
            line += fmt::format("{}{}", j == 0 ? "" : " ", number(a.matrix.at(i, j)));
        fmt::print("{:<12} {}\n", place_name(labels, labels.all()[i]), line);
    }
}

Json json_of(const Findings& f, const SchemeOptions& options) {
    const SpectralAnalysis& a = f.analysis;
    const FanLabels& labels = a.matrix.labels;
    Json json = {{"name", f.scheme.name},
                 {"title", f.scheme.title},
                 {"refinement", name(f.scheme.refinement)},
                 {"faces", name(f.scheme.family)},
                 {"interpolating", f.scheme.interpolating},
                 {"notes", f.scheme.notes},
                 {"smoothness", smoothness(f.scheme, options.rules)},
                 {"reproduction_degree", f.reproduction},
                 {"generation_degree", generation(f.scheme, options.rules)},
                 {"support", f.support},
                 {"mask_norm", f.mask_norm ? Json{{"sum", f.mask_norm->sum}, {"linear", f.mask_norm->linear}} : Json()},
                 {"dual", labels.lattice() == FanLattice::dual},
                 {"valence", f.valence},
                 {"boundary", options.boundary}};
    Json points = Json::array(), masks = Json::array(), values = Json::array();
    for (const FanLabel label : labels.all()) points.push_back(label_json(label));
    for (const int i : shown_rows(a.matrix)) {
        Json terms = Json::array();
        for (int j = 0; j < a.matrix.size(); ++j)
            if (a.matrix.at(i, j) != 0)
                terms.push_back({{"point", label_json(labels.all()[j])}, {"weight", a.matrix.at(i, j)}});
        masks.push_back({{"new_point", label_json(labels.all()[i])}, {"terms", terms}});
    }
    for (const Eigenvalue& e : a.eigenvalues)
        values.push_back({{"real", e.value.real()},
                          {"imaginary", e.value.imag()},
                          {"mode", e.frequency},
                          {"multiplicity", e.multiplicity}});
    const auto mask = [](const std::vector<double>& weights, bool formula) {
        return weights.empty() ? Json() : Json{{"formula", formula}, {"weights", weights}};
    };
    json["points"] = points;
    json["masks"] = masks;
    if (options.matrix) {
        Json rows = Json::array();
        for (int i = 0; i < a.matrix.size(); ++i) rows.push_back(row_of(a.matrix, i));
        json["matrix"] = rows;
    }
    json["eigenvalues"] = values;
    json["subdominant"] = Json::array({a.lambda1, a.lambda2});
    json["third"] = a.third;
    json["tangent_plane"] = a.proper;
    json["curvature"] = options.boundary || !a.proper ? Json() : Json(name(a.curvature));
    json["limit"] = mask(f.masks.limit, f.masks.limit_is_formula);
    json["tangents"] = Json::array(
        {mask(f.masks.tangent1, f.masks.tangent1_is_formula), mask(f.masks.tangent2, f.masks.tangent2_is_formula)});
    return json;
}

void draw(const Findings& f, const SchemeOptions& options) {
    const SpectralAnalysis& a = f.analysis;
    const FanLabels& labels = a.matrix.labels;
    if (labels.lattice() == FanLattice::pentagons)
        throw std::invalid_argument(fmt::format(
            "there is no picture of the boundary of {}, whose vertices have one face more in each step; leave "
            "out --image, or --boundary",
            f.scheme.name));
    SchemePicture picture{
        .title = fmt::format("{}: {} at {}", f.scheme.name, f.scheme.title, looked_at(f, labels)),
        .subtitle = fmt::format("{}, third {:.6g}, {}; red: where the new point lies",
                                options.boundary ? fmt::format("eigenvalue along the boundary {:.6g}, across it {:.6g}",
                                                               a.lambda1, a.lambda2)
                                                 : fmt::format("subdominant eigenvalue {:.6g}", a.lambda1),
                                a.third,
                                options.boundary ? a.proper ? "tangent plane" : "no tangent plane by the spectrum"
                                : a.proper       ? fmt::format("curvature {}", name(a.curvature))
                                                 : "curvature not classified"),
        .scheme = f.scheme,
        .analysis = a,
        .rules = options.rules,
        .masks = {}};
    for (const int i : shown_rows(f.analysis.matrix))
        picture.masks.push_back(
            {fmt::format("new {}", place_name(labels, labels.all()[i])), row_of(f.analysis.matrix, i), i});
    const auto add = [&](const char* title, const std::vector<double>& weights) {
        if (!weights.empty()) picture.masks.push_back({title, weights, {}});
    };
    add("limit position", f.masks.limit);
    add("tangent 1", f.masks.tangent1);
    add("tangent 2", f.masks.tangent2);
    write_png(options.image, draw_scheme(picture, {}));
}

ExitCode run(SchemeOptions options) {
    const SchemeInfo& scheme = chosen_scheme(options.scheme);
    OutputFiles outputs;
    outputs.add(OutputFiles::Kind::picture, "--image", options.image);
    outputs.check({});
    options.rules = options.flags.rules();
    std::vector<std::string> warnings = options.flags.unused(scheme);
    if ((options.rules.corner_angle != 0 || options.rules.measure_corner_angles) && warnings.empty())
        warnings.push_back(
            "--corner-angle has no effect here: at no vertex but a tagged corner, which stays where it is");
    print_warnings(warnings);
    const int valence = options.valence.value_or(regular_valence(scheme, options.boundary));
    FanShape shape{.faces = valence, .boundary = options.boundary};
    const FanLattice lattice = fan_lattice(scheme, shape, options.rules);
    const bool dual = lattice == FanLattice::dual;
    // Beside a boundary vertex there is one face less than edges; a dual scheme's boundary has no valence.
    if (options.boundary && !dual) shape.faces = valence - 1;
    if (options.boundary && dual && options.valence)
        throw UsageError(
            fmt::format("{} is a dual scheme: its boundary is regular after a step and has no --valence", scheme.name));
    if (lattice == FanLattice::pentagons && options.valence)
        throw UsageError(
            fmt::format("a boundary vertex of {} has one edge more in each step and so no --valence", scheme.name));
    try {
        SpectralAnalysis analysis = analyse(scheme, shape, options.rules);
        SchemeMasks masks = scheme_masks(scheme, analysis, options.rules);
        const Findings findings{scheme,
                                std::move(analysis),
                                std::move(masks),
                                valence,
                                reproduction_degree(scheme, options.rules),
                                support_radius(scheme, options.rules),
                                mask_norm(scheme, shape, options.rules)};
        if (!options.image.empty()) draw(findings, options);
        if (options.json)
            fmt::print("{}", dump(json_of(findings, options)));
        else
            print_text(findings, options);
    } catch (const std::invalid_argument& e) {
        throw UsageError(e.what());
    }
    return ExitCode::done;
}

}  // namespace

void add_scheme_command(CLI::App& app, Command& chosen) {
    auto options = std::make_shared<SchemeOptions>();
    CLI::App* command = app.add_subcommand("scheme", "Explains a subdivision scheme: masks, eigenvalues, limits");
    command->add_option("NAME", options->scheme, "Scheme; \"tetrakis schemes\" lists them")->required()->type_name("");
    command
        ->add_option("--valence", options->valence,
                     "Edges at the vertex, or corners of the face of a dual scheme (the regular number)")
        ->type_name("N")
        ->check(CLI::Range(2, k_most_valence).description(""));
    command->add_flag("--boundary", options->boundary, "Look at a boundary vertex, or a dual scheme's boundary edge");
    command->add_flag("--matrix", options->matrix, "The local subdivision matrix as well");
    command->add_flag("--json", options->json, "Print JSON");
    command->add_option("--image", options->image, "Draw masks, characteristic map and basis function (.png)")
        ->type_name("PNG");
    options->flags.add_averaging_steps(*command);
    options->flags.add(*command);
    command->footer("Example:\n  tetrakis scheme loop --valence 5 --image loop5.png");
    command->callback([options, &chosen] { chosen = [options] { return run(*options); }; });
}

}  // namespace tetrakis::cli
