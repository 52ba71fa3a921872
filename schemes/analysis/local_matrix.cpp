#include "../core/masks.hpp"
#include "../parts/sector_fan.hpp"
#include "spectrum.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

namespace tetrakis {

namespace {

/// Rings around those of the matrix, so that the rules of its rows do not reach the rim of the fan.
int margin(const SchemeInfo& scheme, const RuleOptions& options) {
    constexpr int k_margin = 3;  // many averaging steps need more: two of them reach one ring of the finer mesh further
    return k_margin + averaging_steps(scheme, options) / 4;
}

void check_shape(const SchemeInfo& scheme, const FanShape& shape, FanLattice lattice) {
    const bool dual = lattice == FanLattice::dual;
    if (scheme.family == MeshFamily::hexagons && (shape.corner || shape.dart))
        throw std::invalid_argument(std::string(scheme.name) +
                                    " is analysed at faces inside the mesh and at its boundary; corners stay");
    if (dual && shape.dart)
        throw std::invalid_argument(std::string(scheme.name) + " is a dual scheme: darts have no limit mask of a ring");
    if (dual && shape.corner && !(shape.boundary && shape.faces == 1))
        throw std::invalid_argument(
            std::string(scheme.name) +
            " is a dual scheme: its corners are on the boundary and have one face after a step");
    if (shape.dart && shape.boundary) throw std::invalid_argument("a dart is inside the mesh");
    if (dual && !shape.boundary && shape.faces < 3)
        throw std::invalid_argument(std::string(scheme.name) +
                                    " is looked at around a face, which has at least 3 corners");
    if (shape.faces < (shape.boundary ? 1 : 2)) throw std::invalid_argument("a vertex has at least two edges");
}

/// The regular mesh; its rim is far outside the support of the rules around the middle.
SectorFan regular_fan(const SchemeInfo& scheme, const RuleOptions& options) {
    const FanLattice lattice = fan_lattice(scheme, options);
    const int rings = fan_rings(scheme, {.faces = 4}, options) + margin(scheme, options);
    return {lattice, {.faces = lattice == FanLattice::triangles ? 6 : 4}, 2 * rings};
}

double scale(const SchemeInfo& scheme) { return scheme.refinement == Refinement::sqrt3 ? 3 : 2; }

}  // namespace

LocalMatrix local_matrix(const SchemeInfo& scheme, const FanShape& of, const RuleOptions& options) {
    check_shape(scheme, of, fan_lattice(scheme, options));
    FanShape shape = of;
    shape.hexagons = scheme.family == MeshFamily::hexagons && !shape.boundary;
    const FanLattice lattice = fan_lattice(scheme, shape, options);
    if (shape.boundary && boundary_recedes(scheme, options))
        throw std::invalid_argument(std::string(scheme.name) +
                                    " uses up the boundary in each step, so that nothing there maps to itself; leave "
                                    "out the boundary, or replicate it");
    const int rings = fan_rings(scheme, shape, options);
    // The rules in a ring of hexagons do not depend on its rim.
    const SectorFan fan(lattice, shape, shape.hexagons ? rings : rings + margin(scheme, options));
    const RuleStep step = scheme.step(fan.mesh, options);
    LocalMatrix matrix{FanLabels(lattice, shape, rings), {}};
    const std::vector<int> rows = find_fan(step.mesh, child_start(fan, step), matrix.labels);
    for (int i = 0; i < matrix.size(); ++i) {
        const auto points = step.stencils.points(rows[i]);
        const auto weights = step.stencils.weights(rows[i]);
        StencilRow row;
        for (std::size_t t = 0; t < points.size(); ++t) {
            const int column = matrix.labels.find(fan.labels.all()[points[t]]);
            if (column >= 0)
                row.add(column, weights[t]);
            else if (std::abs(weights[t]) > 1e-14)
                throw std::logic_error(std::string(scheme.name) + ": the rings of its matrix do not map to themselves");
        }
        matrix.rows.push(std::move(row));
    }
    return matrix;
}

double LocalMatrix::at(int row, int column) const {
    const auto points = rows.points(row);
    const auto found = std::lower_bound(points.begin(), points.end(), column);
    return found != points.end() && *found == column ? rows.weights(row)[found - points.begin()] : 0;
}

int reproduction_degree(const SchemeInfo& scheme, const RuleOptions& options) {
    if (scheme.family == MeshFamily::hexagons) return scheme.reproduction;
    const SectorFan fan = regular_fan(scheme, options);
    const RuleStep step = scheme.step(fan.mesh, options);
    // Only rings whose new points do not depend on the rim.
    const FanLabels near(fan.labels.lattice(), fan.labels.shape(), 2);
    const std::vector<int> rows = find_fan(step.mesh, child_start(fan, step), near);
    constexpr int k_most = 6;
    for (int degree = 0; degree <= k_most; ++degree)
        for (int i = 0; i <= degree; ++i)
            for (int k = 0; k < near.size(); ++k) {
                const glm::dvec2 fine = fan_place(near, near.all()[k]);
                const auto points = step.stencils.points(rows[k]);
                double sum = 0;
                for (std::size_t t = 0; t < points.size(); ++t) {
                    const glm::dvec2 p = fan_place(fan.labels, fan.labels.all()[points[t]]);
                    sum += step.stencils.weights(rows[k])[t] * std::pow(p.x, i) * std::pow(p.y, degree - i);
                }
                const double exact = std::pow(fine.x / scale(scheme), i) * std::pow(fine.y / scale(scheme), degree - i);
                if (std::abs(sum - exact) > 1e-9) return degree - 1;
            }
    return k_most;
}

double support_radius(const SchemeInfo& scheme, const RuleOptions& options) {
    const bool hexagons = scheme.family == MeshFamily::hexagons;
    const bool dual = !hexagons && fan_lattice(scheme, options) == FanLattice::dual;
    // Two steps make enough hexagons around a corner of the middle one.
    RuleMesh mesh = hexagons ? SectorFan(FanLattice::dual, {.faces = 6, .hexagons = true}, 1).mesh
                             : regular_fan(scheme, options).mesh;
    for (int i = 0; i < 2 && hexagons; ++i) mesh = scheme.step(mesh, options).mesh;
    constexpr int middle = 0;
    const RuleStep step = scheme.step(mesh, options);
    // How far that step spreads the middle point, in rings of faces of the finer mesh. Ring 0 is the vertex, which
    // keeps its number, or for dual schemes the corners of the face that it becomes, half a ring away from the face's
    // middle.
    std::vector<int> ring(static_cast<std::size_t>(step.mesh.vertex_count()), -1), now;
    if (dual)
        for (const int h : mesh.ring(middle).halfedge) now.push_back(step.mesh.origin(step.child_halfedge[h]));
    else
        now.push_back(middle);
    for (const int v : now) ring[static_cast<std::size_t>(v)] = 0;
    for (int r = 1; !now.empty(); ++r) {
        std::vector<int> next;
        for (const int v : now)
            for (const int h : step.mesh.ring(v).halfedge)
                for (const int w : step.mesh.corners(step.mesh.face(h)))
                    if (ring[static_cast<std::size_t>(w)] < 0) {
                        ring[static_cast<std::size_t>(w)] = r;
                        next.push_back(w);
                    }
        now = std::move(next);
    }
    int most = 0;
    for (int v = 0; v < step.mesh.vertex_count(); ++v) {
        const auto points = step.stencils.points(v);
        if (std::binary_search(points.begin(), points.end(), middle))
            most = std::max(most, ring[static_cast<std::size_t>(v)]);
    }
    // Each step adds its own reach r, in rings of its finer mesh: r / scale + r / scale^2 + ... = r / (scale - 1).
    return (most + (dual ? 0.5 : 0.0)) / (scale(scheme) - 1);
}

SchemeMasks scheme_masks(const SchemeInfo& scheme, const SpectralAnalysis& analysis, const RuleOptions& options) {
    const FanLabels& labels = analysis.matrix.labels;
    const ClosedMasks closed = scheme.closed_masks(labels.shape(), options);
    SchemeMasks masks{analysis.limit, analysis.tangent1, analysis.tangent2};
    const auto take = [&](const ClosedMasks::Mask& formula, std::vector<double>& weights, bool& is_formula) {
        if (formula.empty()) return;
        is_formula = true;
        weights.assign(labels.size(), 0.0);
        for (const auto& [label, weight] : formula) {
            const int i = labels.find(label);
            if (i < 0)
                throw std::logic_error(std::string(scheme.name) + ": a mask reaches beyond the rings of its matrix");
            weights[i] += weight;
        }
    };
    take(closed.limit, masks.limit, masks.limit_is_formula);
    take(closed.tangent1, masks.tangent1, masks.tangent1_is_formula);
    take(closed.tangent2, masks.tangent2, masks.tangent2_is_formula);
    return masks;
}

}  // namespace tetrakis
