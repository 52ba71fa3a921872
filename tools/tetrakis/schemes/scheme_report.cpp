#include "scheme_report.hpp"

#include "../console.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <map>
#include <string>
#include <string_view>
#include <utility>

namespace tetrakis::cli {
namespace {

// Largest lengths of printed lists. JSON has all entries.
constexpr std::size_t k_shown_eigenvalues = 12, k_shown_masks = 64;
constexpr double k_same_eigenvalue = 1e-6, k_same_weight = 1e-12;
// A multiple eigenvalue 0 can be computed with an error as large as a root of the rounding error.
constexpr double k_zero_eigenvalue = 1e-4;

/// The number as text, without the rounding noise of its last digits.
std::string number(double x) {
    if (std::abs(x) < 1e-14) return "0";
    return fmt::format("{:.10g}", x);
}

/// Whether the fan is around a vertex, with points on and between the edges that leave it.
bool has_edges(const FanLabels& labels) {
    return labels.lattice() == FanLattice::triangles || labels.lattice() == FanLattice::quads;
}

}  // namespace

std::string place_name(const FanLabels& labels, FanLabel label) {
    if (labels.lattice() != FanLattice::dual && label.a == 0 && label.b == 0) return "c";
    if (has_edges(labels) && label.a == 1 && label.b == 0) return fmt::format("e{}", label.sector);
    return fmt::format("({}; {}, {})", label.sector, label.a, label.b);
}

std::vector<int> shown_rows(const LocalMatrix& m) {
    std::vector<int> rows;
    const FanLabels& labels = m.labels;
    for (int i = 0; i < m.size(); ++i) {
        const FanLabel l = labels.all()[i];
        const bool near = labels.ring_of(l) <= 1 || (labels.lattice() == FanLattice::triangles && l.a == 1 && l.b == 1);
        // At a boundary, edges differ up to the middle one; otherwise sector 0 stands for all sectors.
        const bool first =
            l.sector == 0 || (labels.shape().boundary && has_edges(labels) && 2 * l.sector <= labels.shape().faces);
        if (near && first) rows.push_back(i);
    }
    return rows;
}

std::vector<double> row_of(const LocalMatrix& m, int i) {
    std::vector<double> row(static_cast<std::size_t>(m.size()), 0.0);
    for (const auto& [column, weight] : m.row(i).terms) row[static_cast<std::size_t>(column)] = weight;
    return row;
}

std::string title_of(const SchemeFindings& f) {
    std::string title(f.scheme.title);
    constexpr std::string_view k_steps = "m steps";
    if (const std::size_t at = title.find(k_steps); at != std::string::npos)
        title.replace(at, k_steps.size(),
                      fmt::format("{} step{}", f.rules.averaging_steps, f.rules.averaging_steps == 1 ? "" : "s"));
    return title;
}

std::string looked_at(const SchemeFindings& f, const FanLabels& labels) {
    const bool dual = labels.lattice() == FanLattice::dual;
    if (labels.lattice() == FanLattice::pentagons)
        return "a boundary vertex after two steps: its two faces along the boundary";
    if (labels.shape().corner && !dual) return fmt::format("a corner between sharp edges, with {} edges", f.valence);
    if (labels.shape().dart) return fmt::format("a vertex with {} edges, at which a crease ends (a dart)", f.valence);
    if (labels.shape().boundary)
        return dual ? "a boundary edge between quads" : fmt::format("a boundary vertex with {} edges", f.valence);
    return fmt::format("a {} with {} {}", dual ? "face" : "vertex", f.valence, dual ? "corners" : "edges");
}

namespace {

/// Text of weights and the points that have them: "WEIGHT of POINT POINT ..., WEIGHT of ...".
std::string weights_text(const std::vector<std::pair<double, std::string>>& terms) {
    // The map finds the group of a weight in masks with thousands of weights.
    std::vector<std::pair<double, std::string>> groups;
    std::map<double, std::size_t> group_of;
    for (const auto& [weight, place] : terms) {
        auto same = group_of.upper_bound(weight - k_same_weight);
        if (same == group_of.end() || same->first >= weight + k_same_weight)
            same = group_of.emplace(weight, groups.size()).first;
        if (same->second == groups.size())
            groups.emplace_back(weight, place);
        else
            groups[same->second].second += " " + place;
    }
    std::string text;
    for (const auto& [weight, places] : groups)
        text += fmt::format("{}{} of {}", text.empty() ? "" : ", ", number(weight), places);
    return text;
}

std::string mask_text(const FanLabels& labels, const std::vector<double>& weights) {
    if (weights.empty()) return "not determined: its eigenvalue is not simple";
    std::vector<std::pair<double, std::string>> terms;
    for (int i = 0; i < labels.size(); ++i)
        if (std::abs(weights[i]) >= 1e-13) terms.emplace_back(weights[i], place_name(labels, labels.all()[i]));
    return weights_text(terms);
}

Json label_json(FanLabel label) { return Json::array({label.sector, label.a, label.b}); }

std::string support_text(const SchemeFindings& f, FanLattice lattice) {
    if (f.scheme.family == MeshFamily::hexagons)
        return fmt::format("{} rings of faces around a vertex", number(f.support));
    if (lattice == FanLattice::dual) return fmt::format("{0} x {0} faces", number(2 * f.support));
    return fmt::format("{} rings", number(f.support));
}

/// The scheme table's properties. For averaging they depend on the number of steps.
std::string smoothness(const SchemeInfo& scheme, const RuleOptions& rules) {
    return scheme.has_chosen_steps() ? fmt::format("C{}", rules.averaging_steps) : std::string(scheme.smoothness);
}
std::string generation(const SchemeInfo& scheme, const RuleOptions& rules) {
    return scheme.has_chosen_steps() ? fmt::format("bi-{}", rules.averaging_steps + 1) : std::string(scheme.generation);
}

bool interpolating(const SchemeInfo& scheme, const RuleOptions& rules) {
    return scheme.interpolating || (scheme.has_chosen_steps() && rules.averaging_steps == 0);
}

/// An even number of averaging steps maps vertices to vertices.
std::string_view refinement(const SchemeInfo& scheme, const RuleOptions& rules) {
    const bool even = scheme.has_chosen_steps() && rules.averaging_steps % 2 == 0;
    return name(even ? Refinement::face_split : scheme.refinement);
}

/// Honeycomb refinement's rule for an old vertex, here one between the analysed face and two hexagons. The matrix of a
/// face does not contain this rule. A point is named by its face (0: the analysed face; 1 and 2: the hexagons across
/// the sides from and to the vertex) and its corner's number, counted from the vertex.
struct OldVertexRule {
    struct Term {
        int face, corner;
        double weight;
    };
    std::vector<Term> terms;
};

std::optional<OldVertexRule> old_vertex_rule(const SchemeFindings& f) {
    if (f.scheme.family != MeshFamily::hexagons || f.boundary()) return std::nullopt;
    const int k = f.valence, third = k;  // the vertex's neighbours are 1, k - 1 and `third`
    RuleMesh::Builder faces;
    for (int i = 0; i < k; ++i) faces.corner(i);
    faces.end_face();
    faces.face({0, third, k + 1, k + 2, k + 3, 1});
    faces.face({0, k - 1, k + 4, k + 5, k + 6, third});
    const RuleMesh mesh(k + 7, std::move(faces));
    const RuleStep step = f.scheme.step(mesh, f.rules);
    OldVertexRule rule;
    const auto points = step.stencils.points(0);
    const auto weights = step.stencils.weights(0);
    for (std::size_t t = 0; t < points.size(); ++t)
        for (int face = 0;; ++face) {
            const auto corners = mesh.corners(face);
            const auto at = std::find(corners.begin(), corners.end(), points[t]);
            if (at == corners.end()) continue;
            rule.terms.push_back({face, static_cast<int>(at - corners.begin()), weights[t]});
            break;
        }
    return rule;
}

std::string old_vertex_text(const OldVertexRule& rule) {
    std::vector<std::pair<double, std::string>> terms;
    for (const auto& [face, corner, weight] : rule.terms)
        terms.emplace_back(weight, corner == 0 ? "v" : fmt::format("{}.{}", face, corner));
    return weights_text(terms);
}

}  // namespace

void print_scheme(const SchemeFindings& f, bool with_matrix) {
    const SpectralAnalysis& a = f.analysis;
    const FanLabels& labels = a.matrix.labels;
    const bool dual = labels.lattice() == FanLattice::dual;
    Table table;
    table.row("scheme", fmt::format("{}: {}", f.scheme.name, title_of(f)));
    table.row("refinement", fmt::format("{}, {}, {}", refinement(f.scheme, f.rules), name(f.scheme.family),
                                        interpolating(f.scheme, f.rules) ? "interpolating" : "approximating"));
    table.row("takes", std::string(f.scheme.notes));
    table.row("smoothness", fmt::format("{} on regular meshes", smoothness(f.scheme, f.rules)));
    table.row("polynomials",
              fmt::format("reproduces degree {}, generates degree {}", f.reproduction, generation(f.scheme, f.rules)));
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
    std::size_t masks = 0;
    const std::vector<int> rows = shown_rows(a.matrix);
    for (const int i : rows) {
        // The masks left out are similar: they are farther from the boundary.
        if (masks++ == k_shown_masks) {
            table.row("", fmt::format("... ({} more)", rows.size() - k_shown_masks));
            break;
        }
        table.row(first ? "masks" : "", fmt::format("new {}: {}", place_name(labels, labels.all()[i]),
                                                    mask_text(labels, row_of(a.matrix, i))));
        first = false;
    }
    if (const auto rule = old_vertex_rule(f)) {
        table.row("", "old vertex v: the mean of the new corners around it, 1/m of each in m faces");
        table.row("", fmt::format("between this face and two hexagons: {}", old_vertex_text(*rule)));
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
        // Count equal eigenvalues. Others of the same magnitude can lie between them; then smaller ones follow.
        for (std::size_t k = i; k < a.eigenvalues.size(); ++k) {
            const auto value = a.eigenvalues[k].value;
            if (!zero && std::abs(value) < std::abs(e.value) - 2 * k_same_eigenvalue) break;
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
    table.row("subdominant",
              a.lambda1 == a.lambda2 ? number(a.lambda1)
              : f.boundary() ? fmt::format("{} along the boundary, {} across it", number(a.lambda1), number(a.lambda2))
              : f.valence == 2
                  ? fmt::format("{} along the two edges, {} across them", number(a.lambda1), number(a.lambda2))
                  : fmt::format("{} and {}", number(a.lambda1), number(a.lambda2)));
    table.row("third",
              fmt::format("{}; the subdominant ones' product is {}", number(a.third), number(a.lambda1 * a.lambda2)));
    const bool smaller = a.third < std::min(a.lambda1, a.lambda2) - k_same_eigenvalue;
    const bool pentagons = labels.lattice() == FanLattice::pentagons;
    table.row("tangent plane",
              f.valence == 2 && !f.boundary() && !a.proper
                  ? "none by the spectrum, as in general with two edges: others are as large as the tangents' "
                    "eigenvalues, and there is no characteristic map"
              : pentagons ? "not shown: the faces between the two, one more in each step, are not in the matrix"
              : !a.proper ? "not shown by the spectrum: another eigenvalue is not smaller than the tangents'"
              : smaller   ? "the spectrum allows it: 1, the tangents', all others smaller"
                          : "the spectrum allows it: what is not smaller than the tangents' varies along the boundary "
                            "alone");
    if (!f.boundary() && a.proper) table.row("curvature", std::string(name(a.curvature)));
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
    else if (dual && f.boundary())
        fmt::print(
            "\nPoints: (s; a, b) is a steps along the boundary from the edge's middle (s = 0 ahead, 1 behind), b steps "
            "inwards.\n");
    else if (labels.shape().hexagons)
        fmt::print(
            "\nPoints: (i; 0, 0) is corner i of the face, (i; 1, 1) lies beyond the edge that leaves it there, (i; 0, "
            "1) "
            "and (i; 1, 0) beside that in the hexagons beyond the sides after and before the corner.\nAround an old "
            "vertex v of this face: i.j is corner j, counter-clockwise from v, of face i; 0 is this face, 1 lies "
            "beyond its side from v, 2 beyond its side to v.\n");
    else if (dual)
        fmt::print(
            "\nPoints: (i; a, b) is a and b steps out of the face from its corner i, along the sides before and after "
            "it.\n");
    else
        fmt::print(
            "\nPoints: c the vertex, ei its edge neighbours counter-clockwise, (i; a, b) a steps along ei, then b "
            "along the next.\n");
    if (!with_matrix) return;
    fmt::print("\n");
    for (int i = 0; i < a.matrix.size(); ++i) {
        std::string line;
        for (const double weight : row_of(a.matrix, i))
            line += fmt::format("{}{}", line.empty() ? "" : " ", number(weight));
        fmt::print("{:<12} {}\n", place_name(labels, labels.all()[i]), line);
    }
}

Json scheme_json(const SchemeFindings& f, bool with_matrix) {
    const SpectralAnalysis& a = f.analysis;
    const FanLabels& labels = a.matrix.labels;
    Json json = {{"name", f.scheme.name},
                 {"title", title_of(f)},
                 {"refinement", refinement(f.scheme, f.rules)},
                 {"faces", name(f.scheme.family)},
                 {"interpolating", interpolating(f.scheme, f.rules)},
                 {"notes", f.scheme.notes},
                 {"smoothness", smoothness(f.scheme, f.rules)},
                 {"reproduction_degree", f.reproduction},
                 {"generation_degree", generation(f.scheme, f.rules)},
                 {"support", f.support},
                 {"mask_norm", f.mask_norm ? Json{{"sum", f.mask_norm->sum}, {"linear", f.mask_norm->linear}} : Json()},
                 {"dual", labels.lattice() == FanLattice::dual},
                 {"valence", f.valence},
                 {"boundary", f.boundary()},
                 {"corner", labels.shape().corner},
                 {"dart", labels.shape().dart}};
    Json points = Json::array(), masks = Json::array(), values = Json::array();
    for (const FanLabel label : labels.all()) points.push_back(label_json(label));
    for (const int i : shown_rows(a.matrix)) {
        Json terms = Json::array();
        for (const auto& [column, weight] : a.matrix.row(i).terms)
            terms.push_back({{"point", label_json(labels.all()[column])}, {"weight", weight}});
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
    if (const auto rule = old_vertex_rule(f)) {
        Json terms = Json::array();
        for (const auto& [face, corner, weight] : rule->terms)
            terms.push_back({{"face", face}, {"corner", corner}, {"weight", weight}});
        json["old_vertex"] = {{"of_new_corners", "mean"}, {"terms", terms}};
    }
    json["points"] = points;
    json["masks"] = masks;
    if (with_matrix) {
        Json rows = Json::array();
        for (int i = 0; i < a.matrix.size(); ++i) rows.push_back(row_of(a.matrix, i));
        json["matrix"] = rows;
    }
    json["eigenvalues"] = values;
    json["subdominant"] = Json::array({a.lambda1, a.lambda2});
    json["third"] = a.third;
    json["tangent_plane"] = a.proper;
    json["curvature"] = f.boundary() || !a.proper ? Json() : Json(name(a.curvature));
    json["limit"] = mask(f.masks.limit, f.masks.limit_is_formula);
    json["tangents"] = Json::array(
        {mask(f.masks.tangent1, f.masks.tangent1_is_formula), mask(f.masks.tangent2, f.masks.tangent2_is_formula)});
    return json;
}

}  // namespace tetrakis::cli
