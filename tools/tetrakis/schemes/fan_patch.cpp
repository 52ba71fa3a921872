#include "fan_patch.hpp"

#include "../../../refine/rules/rule_limit.hpp"
#include "../../../schemes/parts/sector_fan.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstdint>
#include <map>
#include <numbers>
#include <utility>

namespace tetrakis::cli {
namespace {

using Complex = std::complex<double>;
// Masks reach up to three rings around a new point, and rules of the rim must not change the inner k_patch_rings.
constexpr int k_control_rings = 2 * k_patch_rings + 1;
// The power iteration converges by the ratio of the mode's next eigenvalue to its subdominant one: rarely above 0.8.
constexpr int k_iterations = 120;

/// Position of a label if all sectors are equal and straight: the start of the iteration.
Complex rough_place(const FanLabels& labels, FanLabel l) {
    const int n = labels.shape().faces;
    const double step = 2 * std::numbers::pi / n;
    if (labels.lattice() != FanLattice::dual)
        return double(l.a) * std::polar(1.0, l.sector * step) + double(l.b) * std::polar(1.0, (l.sector + 1) * step);
    return 0.7 * std::polar(1.0, l.sector * step) + double(l.a) * std::polar(1.0, (l.sector - 0.5) * step) +
           double(l.b) * std::polar(1.0, (l.sector + 0.5) * step);
}

/// Projects to Fourier mode 1, which rotational symmetry separates from the others, and scales to magnitude 1.
void keep_first_mode(const FanLabels& labels, std::vector<Complex>& z) {
    const int n = labels.shape().faces;
    const double step = 2 * std::numbers::pi / n;
    std::map<std::pair<int, int>, Complex> sums;
    const auto centre = [&](FanLabel l) { return labels.lattice() != FanLattice::dual && l.a == 0; };
    for (int i = 0; i < labels.size(); ++i) {
        const FanLabel l = labels.all()[i];
        sums[{l.a, l.b}] += z[i] * std::polar(1.0 / n, -l.sector * step);
    }
    double most = 0;
    for (int i = 0; i < labels.size(); ++i) {
        const FanLabel l = labels.all()[i];
        z[i] = centre(l) ? 0.0 : sums[{l.a, l.b}] * std::polar(1.0, l.sector * step);
        most = std::max(most, std::abs(z[i]));
    }
    for (Complex& x : z) x /= most;
}

/// Rings of hexagons around one k-gon: the dual of a fan of triangles, with its positions in the plane.
FanPatch hexagon_patch(int valence) {
    const SectorFan fan(FanLattice::triangles, {.faces = valence}, k_control_rings);
    FanPatch patch;
    RuleMesh::Builder faces;
    // A triangle becomes a vertex if one of its corners is an inner vertex.
    std::vector<int> number(fan.mesh.face_count(), -1);
    for (int v = 0; v < fan.mesh.vertex_count(); ++v) {
        if (fan.mesh.on_boundary(v)) continue;
        for (const int h : fan.mesh.ring(v).halfedge) {
            const int f = fan.mesh.face(h);
            if (number[f] < 0) {
                number[f] = static_cast<int>(patch.plane.size());
                Complex sum = 0;
                for (const int c : fan.mesh.corners(f)) sum += rough_place(fan.labels, fan.labels.all()[c]) / 3.0;
                patch.plane.emplace_back(sum.real(), sum.imag());
            }
            faces.corner(number[f]);
        }
        faces.end_face();
    }
    patch.mesh = RuleMesh(static_cast<int>(patch.plane.size()), std::move(faces));
    patch.height.assign(patch.plane.size(), 0.0);
    patch.height[0] = 1;  // the first triangle at the centre
    return patch;
}

/// Position of a label in half a disc with straight sectors, or less than half if there are fewer faces than in half a
/// regular lattice; for dual schemes, in the upper half of a grid.
Vec2d rough_boundary_place(const FanLabels& labels, FanLabel l) {
    if (labels.lattice() == FanLattice::dual) return {l.sector == 0 ? l.a + 0.5 : -l.a - 0.5, l.b};
    const int faces = labels.shape().faces;
    const double widest = std::numbers::pi / (labels.lattice() == FanLattice::triangles ? 3 : 2);
    const double step = std::min(std::numbers::pi / faces, widest);
    const auto ray = [&](int i) { return std::polar(1.0, 0.5 * std::numbers::pi + (i - 0.5 * faces) * step); };
    const Complex z = double(l.a) * ray(l.sector) + double(l.b) * ray(l.sector + 1);
    return {z.real(), z.imag()};
}

/// Scales the values so that their largest magnitude is 1.
void scale_to_one(std::vector<double>& values) {
    double most = 0;
    for (const double x : values) most = std::max(most, std::abs(x));
    for (double& x : values) x /= most;
}

/// Patch of a boundary vertex. x is the dominant antisymmetric eigenvector, y the dominant symmetric one but the
/// constant. Both are found by power iteration.
FanPatch boundary_patch(const SchemeInfo& scheme, const SpectralAnalysis& analysis, const RuleOptions& rules) {
    const FanLabels& inner = analysis.matrix.labels;
    SectorFan fan(inner.lattice(), inner.shape(), k_control_rings);
    const RuleStep step = scheme.step(fan.mesh, rules);
    const bool dual = inner.lattice() == FanLattice::dual;
    const std::vector<int> start = dual ? std::vector<int>{step.child_crease[fan.start[0]]} : child_start(fan, step);
    const std::vector<int> rows = find_fan(step.mesh, start, fan.labels);
    const int size = fan.labels.size();
    std::vector<int> mirror(size), place_of_inner;
    std::vector<double> x(size), y(size), finer(step.mesh.vertex_count());
    for (int i = 0; i < size; ++i) {
        const FanLabel label = fan.labels.all()[i];
        mirror[i] = fan.labels.find(fan.labels.mirrored(label));
        const Vec2d at = rough_boundary_place(fan.labels, label);
        x[i] = at.x;
        y[i] = at.y;
    }
    for (const FanLabel label : inner.all()) place_of_inner.push_back(fan.labels.find(label));
    const auto symmetric = [&](std::vector<double>& values, double sign) {
        const std::vector<double> old = values;
        for (int i = 0; i < size; ++i) values[i] = 0.5 * (old[i] + sign * old[mirror[i]]);
    };
    const auto one_level_down = [&](std::vector<double>& values) {
        step.stencils.apply<double>(values, finer);
        for (int i = 0; i < size; ++i) values[i] = finer[rows[i]];
    };
    for (int i = 0; analysis.proper && i < k_iterations; ++i) {
        one_level_down(x);
        symmetric(x, -1);
        one_level_down(y);
        symmetric(y, 1);
        double limit = 0;
        for (int k = 0; k < inner.size(); ++k) limit += analysis.limit[k] * y[place_of_inner[k]];
        for (double& value : y) value -= limit;
        scale_to_one(x);
        scale_to_one(y);
    }
    double right = 0, up = 0;
    for (int i = 0; i < size; ++i) {
        const Vec2d at = rough_boundary_place(fan.labels, fan.labels.all()[i]);
        right += at.x * x[i];
        up += at.y * y[i];
    }
    FanPatch patch;
    for (int i = 0; i < size; ++i) patch.plane.emplace_back(right < 0 ? -x[i] : x[i], up < 0 ? -y[i] : y[i]);
    patch.mesh = std::move(fan.mesh);
    patch.start = std::move(fan.start);
    patch.height.assign(size, 0.0);
    patch.height[0] = 1;
    patch.characteristic = analysis.proper;
    return patch;
}

/// Position of a label in a fan of two sectors, each of which is opened to a half-plane.
Complex half_plane_place(FanLattice lattice, FanLabel l) {
    const double angle = std::numbers::pi / (lattice == FanLattice::triangles ? 3 : 2);
    const Complex z = double(l.a) + double(l.b) * std::polar(1.0, angle);
    return std::polar(std::abs(z), std::numbers::pi * (l.sector + std::arg(z) / angle));
}

}  // namespace

FanPatch fan_patch(const SchemeInfo& scheme, const SpectralAnalysis& analysis, const RuleOptions& rules) {
    const FanShape shape = analysis.matrix.labels.shape();
    if (shape.boundary) return boundary_patch(scheme, analysis, rules);
    if (scheme.family == MeshFamily::hexagons) return hexagon_patch(shape.faces);
    SectorFan fan(fan_lattice(scheme, rules), shape, k_control_rings);
    const RuleStep step = scheme.step(fan.mesh, rules);
    const std::vector<int> rows = find_fan(step.mesh, child_start(fan, step), fan.labels);
    std::vector<Complex> z(fan.labels.size()), finer(step.mesh.vertex_count());
    const bool two_sectors = fan.labels.lattice() != FanLattice::dual && shape.faces == 2;
    for (int i = 0; i < fan.labels.size(); ++i) {
        const FanLabel label = fan.labels.all()[i];
        z[i] = two_sectors ? half_plane_place(fan.labels.lattice(), label) : rough_place(fan.labels, label);
    }
    if (!two_sectors) keep_first_mode(fan.labels, z);
    for (int i = 0; i < k_iterations && !two_sectors; ++i) {
        step.stencils.apply<Complex>(z, finer);
        for (int j = 0; j < fan.labels.size(); ++j) z[j] = finer[rows[j]];
        keep_first_mode(fan.labels, z);
    }
    // Rotate so that the first ray, or the middle of the first side, points to the right.
    const bool dual = fan.labels.lattice() == FanLattice::dual;
    const Complex right = z[fan.labels.find(dual ? FanLabel{0, 0, 0} : FanLabel{0, 1, 0})] +
                          (dual ? z[fan.labels.find({1, 0, 0})] : Complex(0));
    FanPatch patch;
    for (const Complex& x : z) {
        const Complex turned = x * std::conj(right) / std::abs(right);
        patch.plane.emplace_back(turned.real(), turned.imag());
    }
    patch.mesh = std::move(fan.mesh);
    patch.start = std::move(fan.start);
    patch.height.assign(patch.plane.size(), 0.0);
    patch.height[0] = 1;
    patch.characteristic = !two_sectors;
    return patch;
}

void refine(FanPatch& patch, const SchemeInfo& scheme, const RuleOptions& rules) {
    RuleStep step = scheme.step(patch.mesh, rules);
    std::vector<Vec2d> plane(step.mesh.vertex_count());
    std::vector<double> height(step.mesh.vertex_count());
    step.stencils.apply<Vec2d>(patch.plane, plane);
    step.stencils.apply<double>(patch.height, height);
    // A dual fan at a boundary starts at a boundary edge, whose child along the boundary is child_crease.
    const bool dual = fan_lattice(scheme, rules) == FanLattice::dual;
    for (int& h : patch.start)
        h = dual && patch.mesh.twin(h) == RuleMesh::none ? step.child_crease[h] : step.child_halfedge[h];
    patch.mesh = std::move(step.mesh);
    patch.plane = std::move(plane);
    patch.height = std::move(height);
    patch.intervals *= scheme.refinement == Refinement::sqrt3 ? 3 : 2;
    ++patch.steps;
}

BasisSurface basis_surface(const FanPatch& patch, const SchemeInfo& scheme, const RuleOptions& rules,
                           const std::vector<int>& near, double height) {
    BasisSurface surface;
    std::vector<Vec3d> net;
    for (std::size_t v = 0; v < patch.plane.size(); ++v)
        net.push_back({patch.plane[v].x, height * patch.height[v], -patch.plane[v].y});
    tetrakis::detail::LimitSearch search(scheme, rules);
    const auto limits = tetrakis::detail::rule_limits(search, patch.mesh, near);
    std::vector<std::int64_t> number(net.size(), -1);
    for (std::size_t i = 0; i < near.size(); ++i) {
        const LimitPoint point = tetrakis::detail::limit_point(limits, static_cast<int>(i), patch.mesh, net, near[i]);
        number[near[i]] = static_cast<std::int64_t>(i);
        surface.peak = std::max(surface.peak, point.position.y / height);
        surface.mesh.positions.push_back(point.position);
        surface.mesh.normals.push_back(point.normal);
    }
    for (int f = 0; f < patch.mesh.face_count(); ++f) {
        const auto corners = patch.mesh.corners(f);
        if (std::any_of(corners.begin(), corners.end(), [&](int v) { return number[v] < 0; })) continue;
        const auto at = [&](std::size_t i) { return static_cast<std::uint32_t>(number[corners[i]]); };
        for (std::size_t i = 2; i < corners.size(); ++i) surface.mesh.triangles.push_back({at(0), at(i - 1), at(i)});
    }
    return surface;
}

}  // namespace tetrakis::cli
