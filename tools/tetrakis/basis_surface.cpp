#include "basis_surface.hpp"

#include "../../refine/rules/rule_limit.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace tetrakis::cli {
namespace {

using tetrakis::detail::RuleLimitFinder;

// Rings beyond those drawn that their limits and the next level's are made from.
constexpr int k_rings_beyond = 6;
// Where the middle takes over from the level around it.
constexpr int k_middle_rings = 8;
// Of the extent: about a pixel.
constexpr double k_dot = 0.002;
constexpr int k_deepest_level = 40;

/// A vertex of a ring around the middle, and how far along the ring it is: 0 to 1.
struct RingPlace {
    double along;
    std::uint32_t vertex;
};

/// The labels of one ring, counter-clockwise, from the first ray (a boundary: its right half) on.
std::vector<std::pair<double, FanLabel>> ring_labels(const FanLabels& labels, int r) {
    const int n = labels.shape().faces;
    const bool boundary = labels.shape().boundary;
    std::vector<std::pair<double, FanLabel>> ring;
    if (labels.lattice() == FanLattice::dual && boundary) {
        for (int b = 0; b <= r; ++b) ring.push_back({0, {0, r, b}});
        for (int a = r; a >= 0; --a) ring.push_back({0, {0, a, r + 1}});
        for (int a = 0; a <= r; ++a) ring.push_back({0, {1, a, r + 1}});
        for (int b = r; b >= 0; --b) ring.push_back({0, {1, r, b}});
        for (std::size_t i = 0; i < ring.size(); ++i) ring[i].first = double(i) / double(ring.size() - 1);
        return ring;
    }
    const bool dual = labels.lattice() == FanLattice::dual, triangles = labels.lattice() == FanLattice::triangles;
    const int steps = triangles ? r : dual ? 2 * r + 1 : 2 * r;
    for (int s = 0; s < n; ++s)
        for (int i = 0; i < steps; ++i) {
            const FanLabel label = triangles ? FanLabel{s, r - i, i}
                                   : i <= r  ? FanLabel{s, r, i}
                                             : FanLabel{s, 2 * r - i, r};
            ring.push_back({(s + (i + (dual ? 0.5 : 0)) / steps) / n, label});
        }
    if (boundary) ring.push_back({1, {n, r, 0}});
    return ring;
}

/// The mesh in the making, from outside inwards.
class LevelsOfRings {
  public:
    LevelsOfRings(const SchemeInfo& scheme, const RuleOptions& rules, double height)
        : finder_(scheme, rules), height_(height) {}

    /// The rings from the first to the last of a level, joined to what was added before.
    void add(const SectorFan& fan, const std::vector<Vec3d>& net, int first, int last) {
        std::vector<int> drawn, number(fan.labels.size(), -1);
        for (int v = 0; v < fan.labels.size(); ++v) {
            const int ring = fan.labels.ring_of(fan.labels.all()[v]);
            if (ring < first || ring > last) continue;
            number[v] = static_cast<int>(surface_.mesh.positions.size() + drawn.size());
            drawn.push_back(v);
        }
        add_points(fan.mesh, net, drawn);
        for (int f = 0; f < fan.mesh.face_count(); ++f) {
            const auto corners = fan.mesh.corners(f);
            if (std::any_of(corners.begin(), corners.end(), [&](int v) { return number[v] < 0; })) continue;
            for (std::size_t i = 2; i < corners.size(); ++i)
                triangle(number[corners[0]], number[corners[i - 1]], number[corners[i]]);
        }
        const auto ring = [&](int r) {
            std::vector<RingPlace> places;
            for (const auto& [along, label] : ring_labels(fan.labels, r))
                places.push_back({along, static_cast<std::uint32_t>(number[fan.labels.find(label)])});
            if (!fan.labels.shape().boundary) places.push_back({places[0].along + 1, places[0].vertex});
            return places;
        };
        if (!border_.empty()) join(ring(last));
        border_.clear();
        if (first > 0) border_ = ring(first);
    }

    /// Those of the vertices and the faces between them.
    void add_points(const RuleMesh& mesh, const std::vector<Vec3d>& net, const std::vector<int>& vertices) {
        std::vector<Vec3d> raised = net;
        for (Vec3d& p : raised) p.y *= height_;
        std::vector<LimitPoint> points(vertices.size());
        finder_.points(mesh, raised, vertices, points);
        for (const LimitPoint& p : points) {
            surface_.peak = std::max(surface_.peak, p.position.y / height_);
            surface_.mesh.positions.push_back(p.position);
            surface_.mesh.normals.push_back(p.normal);
        }
    }
    void triangle(int a, int b, int c) {
        surface_.mesh.triangles.push_back(
            {static_cast<std::uint32_t>(a), static_cast<std::uint32_t>(b), static_cast<std::uint32_t>(c)});
    }

    BasisSurface take() { return std::move(surface_); }

  private:
    /// The strip between the ring that the last level ended with and one inside it.
    void join(const std::vector<RingPlace>& inner) {
        std::size_t i = 0, j = 0;
        while (i + 1 < border_.size() || j + 1 < inner.size()) {
            const bool outside =
                j + 1 == inner.size() || (i + 1 < border_.size() && border_[i + 1].along <= inner[j + 1].along);
            const std::uint32_t a = border_[i].vertex, b = inner[j].vertex;
            if (outside)
                surface_.mesh.triangles.push_back({a, border_[++i].vertex, b});
            else
                surface_.mesh.triangles.push_back({inner[++j].vertex, b, a});
        }
    }

    BasisSurface surface_;
    RuleLimitFinder finder_;
    double height_;
    std::vector<RingPlace> border_;
};

Vec3d net_point(const FanPatch& patch, int v) { return {patch.plane[v].x, patch.height[v], -patch.plane[v].y}; }

}  // namespace

BasisSurface basis_surface(const FanPatch& patch, const SchemeInfo& scheme, const FanLabels& labels,
                           const RuleOptions& rules, int rings, double height) {
    const FanLattice lattice = labels.lattice();
    const FanShape shape = labels.shape();
    const int factor = scheme.refinement == Refinement::sqrt3 ? 3 : 2;
    const int outer = rings * patch.intervals - 1, middle = std::min(k_middle_rings, (outer + 1) / factor);
    LevelsOfRings surface(scheme, rules, height);
    const SectorFan whole(lattice, shape, outer + k_rings_beyond);
    std::vector<Vec3d> net;
    for (const int v : find_fan(patch.mesh, patch.start, whole.labels)) net.push_back(net_point(patch, v));

    // The same rings of each further level.
    const SectorFan fan(lattice, shape, factor * middle - 1 + k_rings_beyond);
    const RuleStep step = scheme.step(fan.mesh, rules);
    const bool dual_boundary = lattice == FanLattice::dual && shape.boundary;
    const std::vector<int> rows =
        find_fan(step.mesh, dual_boundary ? std::vector<int>{step.child_crease[fan.start[0]]} : child_start(fan, step),
                 fan.labels);
    const auto extent = [](const FanLabels& of, const std::vector<Vec3d>& points, int ring) {
        double most = 0;
        for (int v = 0; v < of.size(); ++v)
            if (of.ring_of(of.all()[v]) == ring) most = std::max(most, std::hypot(points[v].x, points[v].z));
        return most;
    };
    const double dot = k_dot * extent(whole.labels, net, outer);
    bool coarse = extent(whole.labels, net, 1) > dot;
    surface.add(whole, net, coarse ? middle : 0, outer);
    std::vector<Vec3d> values, finer(step.mesh.vertex_count());
    for (const FanLabel label : fan.labels.all()) values.push_back(net[whole.labels.find(label)]);
    for (int level = 0; coarse; ++level) {
        step.stencils.apply<Vec3d>(values, finer);
        for (std::size_t i = 0; i < values.size(); ++i) values[i] = finer[rows[i]];
        coarse = level < k_deepest_level && extent(fan.labels, values, 1) > dot;
        surface.add(fan, values, coarse ? middle : 0, factor * middle - 1);
    }
    return surface.take();
}

BasisSurface hexagon_basis_surface(const FanPatch& patch, const SchemeInfo& scheme, const RuleOptions& rules,
                                   double reach, double height) {
    std::vector<Vec3d> net;
    std::vector<int> near, number(patch.plane.size(), -1);
    for (int v = 0; v < patch.mesh.vertex_count(); ++v) {
        net.push_back(net_point(patch, v));
        if (glm::length(patch.plane[v]) > reach) continue;
        number[v] = static_cast<int>(near.size());
        near.push_back(v);
    }
    LevelsOfRings surface(scheme, rules, height);
    surface.add_points(patch.mesh, net, near);
    for (int f = 0; f < patch.mesh.face_count(); ++f) {
        const auto corners = patch.mesh.corners(f);
        if (std::any_of(corners.begin(), corners.end(), [&](int v) { return number[v] < 0; })) continue;
        for (std::size_t i = 2; i < corners.size(); ++i)
            surface.triangle(number[corners[0]], number[corners[i - 1]], number[corners[i]]);
    }
    return surface.take();
}

}  // namespace tetrakis::cli
