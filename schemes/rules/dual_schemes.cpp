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

namespace detail {

namespace {

/// A scheme by its corner weights, a function of the number of a face's corners.
template <auto weights>
constexpr SchemeInfo dual_scheme(const char* name, const char* title, const char* generation, SurfacePieces pieces,
                                 const char* notes) {
    return {.name = name,
            .title = title,
            .refinement = Refinement::vertex_split,
            .family = MeshFamily::quads,
            .smoothness = "C1",
            .generation = generation,
            .lattice = FanLattice::dual,
            .rings = 1,
            .sees_rings = true,
            .step = [](const RuleMesh& mesh,
                       const RuleOptions& options) { return corner_weights_step(mesh, options, weights); },
            .closed_masks = corner_weights_closed_masks,
            .notes = notes,
            .pieces = pieces};
}

}  // namespace

extern constinit const SchemeInfo doo_sabin_scheme = dual_scheme<DooSabin::weights>(
    "doo-sabin", "Doo, Sabin 1978", "bi-2", SurfacePieces::biquadratic,
    "any polygons; boundary as quadratic B-spline; a crease is a boundary on each side, corners stay");
extern constinit const SchemeInfo doo_sabin_catmull_clark_scheme = dual_scheme<DooSabin::weights_catmull_clark>(
    "doo-sabin-cc", "Doo-Sabin with the weights of Catmull, Clark 1978", "bi-2", SurfacePieces::biquadratic,
    "as doo-sabin; one averaging step");
extern constinit const SchemeInfo midedge_scheme =
    dual_scheme<Midedge::weights>("midedge", "Midedge, Habib, Warren 1995", "2", SurfacePieces::quadratic_box,
                                  "any polygons; boundary and creases as doo-sabin; subdominant 1/2 for every face");
extern constinit const SchemeInfo midedge_simplest_scheme = dual_scheme<Midedge::weights_simplest>(
    "midedge-simplest", "Midedge, Peters, Reif 1997", "2", SurfacePieces::quadratic_box,
    "any polygons; two rounds of joining midpoints");

}  // namespace detail

namespace {

/// @param eigenvalue  of mode m, 0 < m < k / 2; mode k / 2 vanishes in the midpoints, so its eigenvalue is `corner`
template <class Eigenvalue>
FactoredCornerMask from_modes(int k, double corner, Eigenvalue&& eigenvalue) {
    FactoredCornerMask mask{.corner = corner, .centre = 0, .midpoint = std::vector<double>(k, (1 - corner) / k)};
    for (int m = 1; 2 * m < k; ++m) {
        const double mode = (eigenvalue(m) - corner) / std::cos(pi * m / k);
        if (mode == 0) continue;
        for (int i = 0; i < k; ++i) {
            // Whole turns are removed first, as the cosine of m (2 i + 1) pi / k would lose digits.
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
