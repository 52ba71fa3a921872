#include "tetrakis/schemes/scheme_table.hpp"

#include "tetrakis/schemes/averaging.hpp"
#include "tetrakis/schemes/catmull_clark_rules.hpp"
#include "tetrakis/schemes/doo_sabin.hpp"
#include "tetrakis/schemes/four_eight.hpp"
#include "tetrakis/schemes/honeycomb.hpp"
#include "tetrakis/schemes/kobbelt.hpp"
#include "tetrakis/schemes/linear.hpp"
#include "tetrakis/schemes/loop_rules.hpp"
#include "tetrakis/schemes/midedge.hpp"
#include "tetrakis/schemes/modified_butterfly.hpp"
#include "tetrakis/schemes/sqrt3.hpp"
#include "tetrakis/schemes/tuned_loop.hpp"

#include <algorithm>
#include <numeric>
#include <vector>

namespace tetrakis {

namespace {

using enum Refinement;
using enum MeshFamily;
constexpr auto k_primal3 = FanLattice::triangles, k_primal4 = FanLattice::quads, k_dual = FanLattice::dual;

// clang-format off
constexpr SchemeInfo k_table[] = {
    {"loop", "Loop 1987", face_split, triangles, false, "C2", 1, "3", k_primal3, 2, loop_step, loop_closed_masks,
     "triangles; boundary, crease, corner, dart, semi-sharp; Warren's weights, C1 edge rule, Hoppe's crease rule"},
    {"tuned-loop", "Loop with prescribed eigenvalues", face_split, triangles, false, "C2", 1, "3", k_primal3, 2, tuned_loop_step,
     tuned_loop_closed_masks, "triangles; boundary and creases as loop; tuning 0 (loop) to 1 (even triangles, no crease at high valence, larger ripples beside the vertex)"},
    {"butterfly", "Butterfly, Dyn, Levin, Gregory 1990", face_split, triangles, true, "C1", 3, "3", k_primal3, 4, butterfly_step,
     butterfly_closed_masks, "triangles; boundary by four-point and reflection; not smooth at valence 3"},
    {"modified-butterfly", "Modified Butterfly, Zorin, Schroeder, Sweldens 1996", face_split, triangles, true, "C1", 3, "3",
     k_primal3, 4, modified_butterfly_step, modified_butterfly_closed_masks,
     "triangles; boundary, crease, corner; reflection at boundaries as an option"},
    {"midpoint", "Midpoints of triangles", face_split, triangles, true, "C0", 1, "1", k_primal3, 1, midpoint_step, linear_closed_masks,
     "triangles; the control mesh itself"},
    {"sqrt3", "sqrt(3), Kobbelt 2000", Refinement::sqrt3, triangles, false, "C2", 1, "1 or more", k_primal3, 2, sqrt3_step, sqrt3_closed_masks,
     "triangles; two steps at once; boundary and crease as ternary cubic B-spline, corner"},
    {"catmull-clark", "Catmull, Clark 1978", face_split, quads, false, "C2", 1, "bi-3", k_primal4, 2, catmull_clark_step,
     catmull_clark_closed_masks, "any polygons; boundary, crease, corner, dart, semi-sharp; C1 edge rule, other weights beta, gamma"},
    {"kobbelt", "Kobbelt 1996", face_split, quads, true, "C1", 3, "3", k_primal4, 4, kobbelt_step, kobbelt_closed_masks,
     "quads (others after one bilinear step); boundary and crease by four-point", 2},
    {"bilinear", "Bilinear", face_split, quads, true, "C0", 1, "bi-1", k_primal4, 1, bilinear_step, linear_closed_masks,
     "any polygons; quads become bilinear patches"},
    {"4-8", "4-8, Velho, Zorin 2001", bisection, quads, false, "C4", 1, "5", k_primal4, 2, four_eight_step, four_eight_closed_masks,
     "quads as blocks, two bisections at once; other polygons through their tetrakis mesh; boundary, crease, corner"},
    {"doo-sabin", "Doo, Sabin 1978", vertex_split, quads, false, "C1", 1, "bi-2", k_dual, 1, doo_sabin_step, doo_sabin_closed_masks,
     "any polygons; boundary as quadratic B-spline; a crease is a boundary on each side, corners stay"},
    {"doo-sabin-cc", "Doo-Sabin with the weights of Catmull, Clark 1978", vertex_split, quads, false, "C1", 1, "bi-2", k_dual, 1,
     doo_sabin_catmull_clark_step, doo_sabin_catmull_clark_closed_masks, "as doo-sabin; one averaging step"},
    {"midedge", "Midedge, Habib, Warren 1995", vertex_split, quads, false, "C1", 1, "2", k_dual, 1, midedge_step, midedge_closed_masks,
     "any polygons; boundary and creases as doo-sabin; subdominant 1/2 for every face"},
    {"midedge-simplest", "Midedge, Peters, Reif 1997", vertex_split, quads, false, "C1", 1, "2", k_dual, 1, midedge_simplest_step,
     midedge_simplest_closed_masks, "any polygons; two rounds of joining midpoints"},
    {"biquartic", "Biquartic, Zorin, Schroeder 2001", vertex_split, quads, false, "C3", 1, "bi-4", k_dual, 2, biquartic_step,
     biquartic_closed_masks, "any polygons; boundary by copies of its vertices, or the outer ring is used up; no creases"},
    {"averaging", "Repeated averaging, m steps", vertex_split, quads, false, "Cm", 1, "bi-(m + 1)", k_dual, 2, averaging_step,
     averaging_closed_masks, "any polygons; m = 0 bilinear, 1 doo-sabin-cc, 2 nearly catmull-clark (with its creases), 3 biquartic; even m: face split"},
    {"honeycomb", "Honeycomb refinement with Doo-Sabin weights", honeycomb, hexagons, false, "C0 (more is not proven)", 1, "1", k_dual, 1,
     honeycomb_step, honeycomb_closed_masks, "any polygons; boundary and crease as cubic B-spline"},
};
// clang-format on

int edit_distance(std::string_view a, std::string_view b) {
    std::vector<int> row(b.size() + 1);
    std::iota(row.begin(), row.end(), 0);
    for (std::size_t i = 1; i <= a.size(); ++i) {
        int diagonal = row[0];
        row[0] = static_cast<int>(i);
        for (std::size_t j = 1; j <= b.size(); ++j) {
            const int replaced = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
            diagonal = row[j];
            row[j] = std::min({row[j] + 1, row[j - 1] + 1, replaced});
        }
    }
    return row.back();
}

}  // namespace

std::span<const SchemeInfo> scheme_table() { return k_table; }

const SchemeInfo* find_scheme(std::string_view name) {
    for (const SchemeInfo& scheme : k_table)
        if (scheme.name == name) return &scheme;
    return nullptr;
}

std::string_view nearest_scheme_name(std::string_view text) {
    // The start or another part of a name is that name.
    constexpr std::size_t k_telling = 3;
    const auto distance = [&](const SchemeInfo& scheme) {
        const bool part = text.size() >= k_telling && scheme.name.find(text) != std::string_view::npos;
        return std::pair(part ? 0 : 1, edit_distance(text, scheme.name));
    };
    return std::min_element(std::begin(k_table), std::end(k_table),
                            [&](const SchemeInfo& a, const SchemeInfo& b) { return distance(a) < distance(b); })
        ->name;
}

std::string_view name(Refinement refinement) {
    switch (refinement) {
        case face_split:
            return "face split";
        case vertex_split:
            return "vertex split";
        case Refinement::sqrt3:
            return "sqrt3";
        case bisection:
            return "bisection";
        case honeycomb:
            break;
    }
    return "honeycomb";
}

std::string_view name(MeshFamily family) {
    return family == triangles ? "triangle" : family == quads ? "quad" : "hexagon";
}

int regular_valence(const SchemeInfo& scheme, bool boundary) {
    switch (scheme.family) {
        case triangles:
            return boundary ? 4 : 6;
        case quads:
            return boundary ? 3 : 4;
        case hexagons:
            break;
    }
    return 6;
}

FanLattice fan_lattice(const SchemeInfo& scheme, const RuleOptions& options) {
    if (scheme.step == averaging_step && options.averaging_steps % 2 == 0) return FanLattice::quads;
    return scheme.lattice;
}

int averaging_steps(const SchemeInfo& scheme, const RuleOptions& options) {
    return scheme.step == biquartic_step ? 3 : scheme.step == averaging_step ? options.averaging_steps : 0;
}

bool boundary_recedes(const SchemeInfo& scheme, const RuleOptions& options) {
    return averaging_steps(scheme, options) > 0 && options.averaging_boundary == AveragingBoundary::recede;
}

bool ignores_creases(const SchemeInfo& scheme, const RuleOptions& options) {
    const int steps = averaging_steps(scheme, options);
    return steps != 0 && (steps != 2 || boundary_recedes(scheme, options));
}

FanLattice fan_lattice(const SchemeInfo& scheme, const FanShape& shape, const RuleOptions& options) {
    const FanLattice lattice = fan_lattice(scheme, options);
    if (scheme.family == hexagons && shape.boundary) return FanLattice::pentagons;
    return lattice == FanLattice::dual && shape.corner ? FanLattice::quads : lattice;
}

int fan_rings(const SchemeInfo& scheme, const FanShape& shape, const RuleOptions& options) {
    if (fan_lattice(scheme, shape, options) == FanLattice::pentagons) return 1;
    const bool averaging = scheme.step == averaging_step;
    const int m = options.averaging_steps;
    const int rings = !averaging ? scheme.rings : m % 2 == 1 ? (m + 1) / 2 : m / 2 + 1;
    // Beside a boundary edge of a dual scheme a ring is two rows deep.
    return fan_lattice(scheme, shape, options) == FanLattice::dual && shape.boundary ? rings - 1 : rings;
}

}  // namespace tetrakis
