#include "corner_angles.hpp"

#include <algorithm>
#include <cmath>

namespace tetrakis {

namespace {

constexpr double radians(double degrees) { return degrees * std::numbers::pi / 180; }
constexpr double k_beside_flat = radians(10), k_nearly_flat = radians(170), k_most = radians(350);

/// Angles at a vertex one level down, in the order of its ring's half-edges; empty if the vertex is no corner then.
std::vector<double> child_angles(const RuleMesh& mesh, int v, const RuleMesh::Ring& ring) {
    const int n = ring.faces();
    std::vector<double> angle(n);
    for (int i = 0; i < n; ++i) angle[i] = mesh.corner_angle(ring.halfedge[i]);
    std::vector<float> sharpness;
    for (const float s : ring.sharpness) sharpness.push_back(child_sharpness(s));
    if (vertex_rule(sharpness, child_sharpness(mesh.vertex_sharpness(v))) != VertexRule::corner) return {};
    bool merges = false;
    for (int i = 0; i < n; ++i) merges = merges || (is_sharp(ring.sharpness[i]) && !is_sharp(sharpness[i]));
    if (!merges) return angle;
    int start = 0;
    while (start < n && !is_sharp(sharpness[start])) ++start;
    const bool whole = start == n;  // nothing is sharp any more
    if (whole)
        while (!is_sharp(ring.sharpness[--start])) {
        }
    std::vector<double> result(n);
    for (int i = 0, end = 0; i < n; i = end) {
        const auto at = [&](int k) { return (start + k) % n; };
        double sum = 0;
        int sectors = 0;
        bool all = true;
        for (end = i; end < n && (end == i || whole || !is_sharp(sharpness[at(end)])); ++end) {
            if (end > i && !is_sharp(ring.sharpness[at(end)])) continue;  // the same sector
            const double a = angle[at(end)];
            sum += a;
            all = all && a != 0;
            ++sectors;
        }
        const double merged = !all ? 0 : sectors == 1 ? sum : usable_corner_angle(sum);
        for (int k = i; k < end; ++k) result[at(k)] = merged;
    }
    return result;
}

}  // namespace

double usable_corner_angle(double angle) {
    if (std::abs(angle - std::numbers::pi) < k_beside_flat) return k_nearly_flat;
    return std::min(angle, k_most);
}

std::optional<detail::Bend> detail::bend_at(const RuleMesh& mesh, int h, const RuleOptions& options, int plain_faces) {
    using enum EdgeBesideCrease;
    // A semi-sharp edge is one of a crease's own edges, not beside it.
    if (mesh.sharp(h) || (options.edge_beside_crease == plain && !may_have_angles(mesh, options))) return std::nullopt;
    const auto bends = [&](int out) {
        const VertexRule rule = mesh.rule(mesh.origin(out));
        return rule == VertexRule::crease || (rule == VertexRule::corner && sector_angle(mesh, out, options) > 0);
    };
    const bool u = bends(h), v = bends(mesh.twin(h));
    if (u == v) return std::nullopt;
    const int out = u ? h : mesh.twin(h), K = mesh.sector(out).faces();
    if (mesh.rule(mesh.origin(out)) == VertexRule::corner) {
        const double angle = sector_angle(mesh, out, options);
        return Bend{out, K, angle / K, angle};
    }
    if (options.edge_beside_crease == cosine) return Bend{out, K, std::numbers::pi / K, 0};
    if (options.edge_beside_crease == plain || K <= plain_faces) return std::nullopt;
    return Bend{out, K, 0, 0};
}

std::vector<double> detail::child_corner_angles(const RuleMesh& mesh, std::span<const int> child, std::size_t fine) {
    std::vector<double> result;
    if (!mesh.has_corner_angles()) return result;
    std::vector<int> vertices;
    for (int h = 0; h < mesh.halfedge_count(); ++h)
        if (mesh.corner_angle(h) != 0) vertices.push_back(mesh.origin(h));
    std::sort(vertices.begin(), vertices.end());
    vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
    for (const int v : vertices) {
        const RuleMesh::Ring ring = mesh.ring(v);
        const std::vector<double> angle = child_angles(mesh, v, ring);
        if (angle.empty()) continue;
        result.resize(fine, 0.0);
        for (int i = 0; i < ring.faces(); ++i) result[child[ring.halfedge[i]]] = angle[i];
    }
    return result;
}

}  // namespace tetrakis
