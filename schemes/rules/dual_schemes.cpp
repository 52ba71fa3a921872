#include "dual_schemes.hpp"

#include "../core/scheme_table.hpp"
#include "../parts/corner_weights.hpp"

#include <cmath>
#include <numbers>

namespace tetrakis {

using std::numbers::pi;

std::vector<double> DooSabin::weights(int k) {
    std::vector<double> w(k);
    for (int i = 0; i < k; ++i) w[i] = (3 + 2 * std::cos(2 * pi * i / k)) / (4 * k);
    w[0] = 0.25 + 5.0 / (4 * k);
    return w;
}

std::vector<double> DooSabin::weights_catmull_clark(int k) {
    std::vector<double> w(k, 1.0 / (4 * k));
    w[0] += 0.5;
    w[1] += 0.125;
    w[k - 1] += 0.125;
    return w;
}

RuleStep doo_sabin_step(const RuleMesh& mesh, const RuleOptions& options) {
    return detail::corner_weights_step(mesh, options, DooSabin::weights);
}
RuleStep doo_sabin_catmull_clark_step(const RuleMesh& mesh, const RuleOptions& options) {
    return detail::corner_weights_step(mesh, options, DooSabin::weights_catmull_clark);
}

ClosedMasks doo_sabin_closed_masks(const FanShape& shape, const RuleOptions&) {
    return detail::corner_weights_closed_masks(shape, 0.5);
}
ClosedMasks doo_sabin_catmull_clark_closed_masks(const FanShape& shape, const RuleOptions&) {
    return detail::corner_weights_closed_masks(shape, 0.5 + std::cos(2 * pi / shape.faces) / 4);
}

namespace detail {

extern constinit const SchemeInfo doo_sabin_scheme{
    .name = "doo-sabin",
    .title = "Doo, Sabin 1978",
    .refinement = Refinement::vertex_split,
    .family = MeshFamily::quads,
    .interpolating = false,
    .smoothness = "C1",
    .reproduction = 1,
    .generation = "bi-2",
    .lattice = FanLattice::dual,
    .rings = 1,
    .rule_rings = 1,
    .sees_rings = true,
    .step = doo_sabin_step,
    .closed_masks = doo_sabin_closed_masks,
    .notes = "any polygons; boundary as quadratic B-spline; a crease is a boundary on each side, corners stay",
    .pieces = SurfacePieces::biquadratic,
};

extern constinit const SchemeInfo doo_sabin_catmull_clark_scheme{
    .name = "doo-sabin-cc",
    .title = "Doo-Sabin with the weights of Catmull, Clark 1978",
    .refinement = Refinement::vertex_split,
    .family = MeshFamily::quads,
    .interpolating = false,
    .smoothness = "C1",
    .reproduction = 1,
    .generation = "bi-2",
    .lattice = FanLattice::dual,
    .rings = 1,
    .rule_rings = 1,
    .sees_rings = true,
    .step = doo_sabin_catmull_clark_step,
    .closed_masks = doo_sabin_catmull_clark_closed_masks,
    .notes = "as doo-sabin; one averaging step",
    .pieces = SurfacePieces::biquadratic,
};

}  // namespace detail

std::vector<double> Midedge::weights(int k) {
    std::vector<double> w(k, 1.0 / k);
    for (int i = 0; i < k; ++i)
        for (int j = 1; 2 * j < k; ++j) w[i] += 2 * std::ldexp(std::cos(2 * pi * i * j / k), -j) / k;
    return w;
}

std::vector<double> Midedge::weights_simplest(int k) {
    std::vector<double> w(k, 0.0);
    w[0] += 0.5;
    w[1] += 0.25;
    w[k - 1] += 0.25;
    return w;
}

RuleStep midedge_step(const RuleMesh& mesh, const RuleOptions& options) {
    return detail::corner_weights_step(mesh, options, Midedge::weights);
}
RuleStep midedge_simplest_step(const RuleMesh& mesh, const RuleOptions& options) {
    return detail::corner_weights_step(mesh, options, Midedge::weights_simplest);
}

ClosedMasks midedge_closed_masks(const FanShape& shape, const RuleOptions&) {
    return detail::corner_weights_closed_masks(shape, 0.5);
}
ClosedMasks midedge_simplest_closed_masks(const FanShape& shape, const RuleOptions&) {
    return detail::corner_weights_closed_masks(shape, (1 + std::cos(2 * pi / shape.faces)) / 2);
}

namespace detail {

extern constinit const SchemeInfo midedge_scheme{
    .name = "midedge",
    .title = "Midedge, Habib, Warren 1995",
    .refinement = Refinement::vertex_split,
    .family = MeshFamily::quads,
    .interpolating = false,
    .smoothness = "C1",
    .reproduction = 1,
    .generation = "2",
    .lattice = FanLattice::dual,
    .rings = 1,
    .rule_rings = 1,
    .sees_rings = true,
    .step = midedge_step,
    .closed_masks = midedge_closed_masks,
    .notes = "any polygons; boundary and creases as doo-sabin; subdominant 1/2 for every face",
    .pieces = SurfacePieces::quadratic_box,
};

extern constinit const SchemeInfo midedge_simplest_scheme{
    .name = "midedge-simplest",
    .title = "Midedge, Peters, Reif 1997",
    .refinement = Refinement::vertex_split,
    .family = MeshFamily::quads,
    .interpolating = false,
    .smoothness = "C1",
    .reproduction = 1,
    .generation = "2",
    .lattice = FanLattice::dual,
    .rings = 1,
    .rule_rings = 1,
    .sees_rings = true,
    .step = midedge_simplest_step,
    .closed_masks = midedge_simplest_closed_masks,
    .notes = "any polygons; two rounds of joining midpoints",
    .pieces = SurfacePieces::quadratic_box,
};

}  // namespace detail

namespace {

/// @param eigenvalue  of mode m, 0 <= m < k / 2; that of mode k / 2 is the corner's weight, since midpoints lose it
template <class Eigenvalue>
FactoredCornerMask from_modes(int k, double corner, Eigenvalue&& eigenvalue) {
    FactoredCornerMask mask{.corner = corner, .centre = 0, .midpoint = std::vector<double>(k, (1 - corner) / k)};
    for (int m = 1; 2 * m < k; ++m) {
        const double mode = (eigenvalue(m) - corner) / std::cos(pi * m / k);
        if (mode == 0) continue;
        for (int i = 0; i < k; ++i) {
            // Whole turns are taken out first: m (2 i + 1) pi / k would lose digits.
            const int turn = static_cast<int>(static_cast<long long>(m) * (2 * i + 1) % (2 * k));
            mask.midpoint[i] += 2 * mode * std::cos(pi * turn / k) / k;
        }
    }
    return mask;
}

FactoredCornerMask beside(int k, double corner, double centre, double midpoint) {
    FactoredCornerMask mask{.corner = corner, .centre = centre, .midpoint = std::vector<double>(k, 0.0)};
    mask.midpoint[0] = mask.midpoint[k - 1] = midpoint;
    return mask;
}

}  // namespace

FactoredCornerMask factored_doo_sabin(int k) {
    return from_modes(k, 0.25, [](int m) { return m == 1 ? 0.5 : 0.25; });
}

FactoredCornerMask factored_doo_sabin_catmull_clark(int k) { return beside(k, 0.25, 0.25, 0.25); }

FactoredCornerMask factored_midedge(int k) {
    return from_modes(k, 0, [](int m) { return std::ldexp(1.0, -m); });
}

FactoredCornerMask factored_midedge_simplest(int k) { return beside(k, 0, 0, 0.5); }

}  // namespace tetrakis
