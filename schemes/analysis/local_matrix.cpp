#include "../core/masks.hpp"
#include "../parts/sector_fan.hpp"
#include "spectrum.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>

namespace tetrakis {

namespace {

/// How many more rings than those of the matrix keep the rim of the fan out of reach.
int margin(const SchemeInfo& scheme, const RuleOptions& options) {
    constexpr int k_margin = 3;  // for all but many averaging steps, each two of which reach one ring further
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

struct Point {
    double x, y;
};

/// Where the vertices of a regular fan are in the plane; the middle is the origin.
Point place(const FanLabels& labels, FanLabel label) {
    if (labels.lattice() == FanLattice::dual) {
        const double x = label.a + 0.5, y = label.b + 0.5;
        const Point turned[] = {{x, y}, {-y, x}, {-x, -y}, {y, -x}};
        return turned[label.sector];
    }
    const double step = labels.lattice() == FanLattice::triangles ? std::numbers::pi / 3 : std::numbers::pi / 2;
    const double p = label.sector * step, q = p + step;
    return {label.a * std::cos(p) + label.b * std::cos(q), label.a * std::sin(p) + label.b * std::sin(q)};
}

struct RegularStep {
    SectorFan fan;
    FanLabels inner;
    RuleStep step;
    std::vector<int> found;
};

RegularStep regular_step(const SchemeInfo& scheme, const RuleOptions& options, int rings) {
    const FanLattice lattice = fan_lattice(scheme, options);
    const FanShape shape{.faces = lattice == FanLattice::triangles ? 6 : 4};
    SectorFan fan(lattice, shape, 2 * rings);
    RuleStep step = scheme.step(fan.mesh, options);
    FanLabels inner(lattice, shape, rings);
    std::vector<int> found = find_fan(step.mesh, child_start(fan, step), inner);
    return {std::move(fan), std::move(inner), std::move(step), std::move(found)};
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
    // The lattice beside a dual boundary edge is the same whatever the valence.
    const int rings = fan_rings(scheme, shape, options);
    // A ring of hexagons does not feel its rim.
    const SectorFan fan(lattice, shape, shape.hexagons ? rings : rings + margin(scheme, options));
    const RuleStep step = scheme.step(fan.mesh, options);
    LocalMatrix matrix{FanLabels(lattice, shape, rings), {}};
    const std::vector<int> rows = find_fan(step.mesh, child_start(fan, step), matrix.labels);
    for (int i = 0; i < matrix.size(); ++i) {
        if (matrix.turns() && matrix.labels.all()[i].sector != 0) continue;
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

namespace {

/// Where a label is among those that a fan turns into: each place has one of every sector, after the centre.
struct Turned {
    int place, sector;

    Turned(const FanLabels& labels, int i) {
        const int n = labels.shape().faces, centre = labels.lattice() == FanLattice::dual ? 0 : 1;
        place = i < centre ? 0 : centre + (i - centre) / n;
        sector = i < centre ? 0 : (i - centre) % n;
    }
};

/// The label that this one becomes by a turn of so many sectors.
int turned(const FanLabels& labels, int i, int sectors) {
    const int n = labels.shape().faces, centre = labels.lattice() == FanLattice::dual ? 0 : 1;
    if (i < centre) return i;
    const int s = (i - centre) % n;
    return i - s + (s + sectors) % n;
}

}  // namespace

StencilRow LocalMatrix::row(int i) const {
    if (!turns()) return rows.row(i);
    const Turned of(labels, i);
    StencilRow result;
    rows.add_row(of.place, 1, result);
    if (of.sector == 0) return result;
    for (auto& [column, weight] : result.terms) column = turned(labels, column, of.sector);
    result.gather();
    return result;
}

double LocalMatrix::at(int row, int column) const {
    if (turns()) {
        const Turned of(labels, row);
        column = turned(labels, column, labels.shape().faces - of.sector);
        row = of.place;
    }
    const auto points = rows.points(row);
    const auto found = std::lower_bound(points.begin(), points.end(), column);
    return found != points.end() && *found == column ? rows.weights(row)[found - points.begin()] : 0;
}

std::size_t LocalMatrix::weight_count() const {
    if (!turns()) return rows.points().size();
    const std::size_t centre = labels.lattice() == FanLattice::dual ? 0 : rows.points(0).size();
    return centre + (rows.points().size() - centre) * static_cast<std::size_t>(labels.shape().faces);
}

int reproduction_degree(const SchemeInfo& scheme, const RuleOptions& options) {
    if (scheme.family == MeshFamily::hexagons) return scheme.reproduction;
    const RegularStep s =
        regular_step(scheme, options, fan_rings(scheme, {.faces = 4}, options) + margin(scheme, options));
    // Only as far out as the rim is not felt.
    const FanLabels near(s.inner.lattice(), s.inner.shape(), 2);
    constexpr int k_most = 6;
    for (int degree = 0; degree <= k_most; ++degree)
        for (int i = 0; i <= degree; ++i)
            for (const FanLabel label : near.all()) {
                const Point fine = place(s.inner, label);
                const int row = s.found[s.inner.find(label)];
                double sum = 0;
                for (std::size_t t = 0; t < s.step.stencils.points(row).size(); ++t) {
                    const Point p = place(s.fan.labels, s.fan.labels.all()[s.step.stencils.points(row)[t]]);
                    sum += s.step.stencils.weights(row)[t] * std::pow(p.x, i) * std::pow(p.y, degree - i);
                }
                const double exact = std::pow(fine.x / scale(scheme), i) * std::pow(fine.y / scale(scheme), degree - i);
                if (std::abs(sum - exact) > 1e-9) return degree - 1;
            }
    return k_most;
}

namespace {

/// Hexagons laid like bricks, each row shifted by half of one; vertex (x, y) is number 2 * size * y + x.
RuleMesh bricks(int size) {
    const int across = 2 * size;
    RuleMesh::Builder faces;
    for (int y = 0; y + 1 < size; ++y)
        for (int x = y % 2; x + 2 < across; x += 2) {
            const int v = across * y + x, up = v + across;
            faces.face({v, v + 1, v + 2, up + 2, up + 1, up});
        }
    return RuleMesh(across * size, std::move(faces));
}

/// How far one step carries a point of a regular mesh of hexagons, in the finer mesh's rings of faces around it.
int hexagon_rings(const SchemeInfo& scheme, const RuleOptions& options) {
    constexpr int k_size = 12;
    const int middle = k_size / 2 * 2 * k_size + k_size;
    const RuleStep step = scheme.step(bricks(k_size), options);  // old vertices keep their numbers
    std::vector<int> ring(static_cast<std::size_t>(step.mesh.vertex_count()), -1), now{middle};
    ring[static_cast<std::size_t>(middle)] = 0;
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
        if (std::find(points.begin(), points.end(), middle) != points.end())
            most = std::max(most, ring[static_cast<std::size_t>(v)]);
    }
    return most;
}

}  // namespace

double support_radius(const SchemeInfo& scheme, const RuleOptions& options) {
    if (scheme.family == MeshFamily::hexagons) return hexagon_rings(scheme, options) / (scale(scheme) - 1);
    const RegularStep s =
        regular_step(scheme, options, fan_rings(scheme, {.faces = 4}, options) + margin(scheme, options));
    const FanLabels& inner = s.inner;
    const bool dual = inner.lattice() == FanLattice::dual;
    // One point of the middle: how far its fine children are from it, in fine rings (dual: along one axis, from its own
    // place at (1/2, 1/2), i.e. (1, 1) among the fine points).
    const int middle = s.fan.labels.find({});
    double most = 0;
    for (const FanLabel label : inner.all()) {
        const auto points = s.step.stencils.points(s.found[inner.find(label)]);
        if (!std::binary_search(points.begin(), points.end(), middle)) continue;
        const Point p = place(inner, label);
        most = std::max(most, dual ? std::max(std::abs(p.x - 1), std::abs(p.y - 1)) : double(inner.ring_of(label)));
    }
    // r, then r / scale, and so on, in fine rings of the first step.
    return most / (scale(scheme) - 1);
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
