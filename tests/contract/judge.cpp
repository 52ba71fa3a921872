#include "judge.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

namespace tetrakis::contract {

namespace {

constexpr std::uint32_t k_leaf = 4;  // triangles

double squared(const Vec3d& v) { return glm::dot(v, v); }

double squared_to_segment(const Vec3d& p, const Vec3d& a, const Vec3d& b) {
    const Vec3d d = b - a;
    const double length2 = squared(d);
    const double t = length2 > 0 ? std::clamp(glm::dot(p - a, d) / length2, 0.0, 1.0) : 0.0;
    return squared(p - a - t * d);
}

double squared_to_triangle(const Vec3d& p, const Vec3d& a, const Vec3d& b, const Vec3d& c) {
    const Vec3d normal = glm::cross(b - a, c - a);
    const double area2 = squared(normal);
    const auto inside = [&](const Vec3d& from, const Vec3d& to) {
        return glm::dot(glm::cross(to - from, p - from), normal) >= 0;
    };
    if (area2 > 0 && inside(a, b) && inside(b, c) && inside(c, a)) {
        const double height = glm::dot(p - a, normal);
        return height * height / area2;
    }
    return std::min({squared_to_segment(p, a, b), squared_to_segment(p, b, c), squared_to_segment(p, c, a)});
}

double squared_to_box(const Vec3d& p, const Box3d& box) {
    return squared(glm::max(glm::max(box.lower - p, p - box.upper), Vec3d(0)));
}

/// Polygons as fans of triangles.
std::vector<std::array<std::uint32_t, 3>> fans(const PolygonMesh& mesh) {
    std::vector<std::array<std::uint32_t, 3>> result;
    for (std::uint32_t f = 0; f < mesh.face_count(); ++f)
        for (std::uint32_t i = mesh.face_offsets[f] + 1; i + 1 < mesh.face_offsets[f + 1]; ++i)
            result.push_back(
                {mesh.face_vertices[mesh.face_offsets[f]], mesh.face_vertices[i], mesh.face_vertices[i + 1]});
    return result;
}

double farthest(const std::vector<Vec3d>& points, const NearestTriangle& from) {
    double most = 0;
    for (const Vec3d& p : points) most = std::max(most, from.distance(p));
    return most;
}

}  // namespace

NearestTriangle::NearestTriangle(std::vector<Vec3d> points, std::vector<std::array<std::uint32_t, 3>> triangles)
    : points_(std::move(points)), triangles_(std::move(triangles)), order_(triangles_.size()) {
    std::iota(order_.begin(), order_.end(), 0u);
    std::vector<Vec3d> centres;
    for (const auto& t : triangles_) centres.push_back((points_[t[0]] + points_[t[1]] + points_[t[2]]) / 3.0);
    nodes_.emplace_back();
    split(0, 0, static_cast<std::uint32_t>(order_.size()), centres);
}

void NearestTriangle::split(std::uint32_t node, std::uint32_t first, std::uint32_t count,
                            const std::vector<Vec3d>& centres) {
    Box3d box, middles;
    for (std::uint32_t i = first; i < first + count; ++i) {
        for (const std::uint32_t v : triangles_[order_[i]]) box.add(points_[v]);
        middles.add(centres[order_[i]]);
    }
    nodes_[node] = {box, first, count};
    if (count <= k_leaf) return;
    const Vec3d size = middles.upper - middles.lower;
    const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
    const std::uint32_t half = count / 2;
    std::nth_element(order_.begin() + first, order_.begin() + first + half, order_.begin() + first + count,
                     [&](std::uint32_t a, std::uint32_t b) { return centres[a][axis] < centres[b][axis]; });
    const auto child = static_cast<std::uint32_t>(nodes_.size());
    nodes_[node].first = child;
    nodes_[node].count = 0;
    nodes_.resize(child + 2);
    split(child, first, half, centres);
    split(child + 1, first + half, count - half, centres);
}

double NearestTriangle::distance(const Vec3d& p) const {
    double best = std::numeric_limits<double>::infinity();
    std::vector<std::pair<double, std::uint32_t>> open = {{squared_to_box(p, nodes_[0].box), 0}};
    while (!open.empty()) {
        const auto [least, number] = open.back();
        open.pop_back();
        if (least >= best) continue;
        const Node& node = nodes_[number];
        if (node.count == 0) {
            std::pair<double, std::uint32_t> near = {squared_to_box(p, nodes_[node.first].box), node.first};
            std::pair<double, std::uint32_t> far = {squared_to_box(p, nodes_[node.first + 1].box), node.first + 1};
            if (far < near) std::swap(near, far);
            open.push_back(far);
            open.push_back(near);
            continue;
        }
        for (std::uint32_t i = node.first; i < node.first + node.count; ++i) {
            const auto& t = triangles_[order_[i]];
            best = std::min(best, squared_to_triangle(p, points_[t[0]], points_[t[1]], points_[t[2]]));
        }
    }
    return std::sqrt(best);
}

LimitJudge::LimitJudge(const ControlMesh& mesh, const SchemeInfo& scheme, int level, const RuleOptions& rules) {
    const RefineOptions limit{.rules = rules, .limit = true};
    const PolygonMesh fine = refine(mesh, scheme, level, limit), coarse = refine(mesh, scheme, level - 1, limit);
    points_ = fine.positions;
    face_count_ = fine.face_count();
    surface_ = std::make_unique<NearestTriangle>(points_, fans(fine));
    doubt_ = farthest(points_, NearestTriangle(coarse.positions, fans(coarse)));
}

double LimitJudge::limit_to_mesh(const TriangleMesh& mesh) const {
    return farthest(points_, NearestTriangle(mesh.positions, mesh.triangles));
}

double LimitJudge::mesh_to_limit(const TriangleMesh& mesh) const {
    constexpr int k_intervals = 4;  // on each side of a triangle
    double most = 0;
    for (const auto& t : mesh.triangles) {
        const Vec3d &a = mesh.positions[t[0]], &b = mesh.positions[t[1]], &c = mesh.positions[t[2]];
        for (int i = 0; i <= k_intervals; ++i)
            for (int j = 0; i + j <= k_intervals; ++j) {
                const double u = static_cast<double>(i) / k_intervals, v = static_cast<double>(j) / k_intervals;
                most = std::max(most, surface_->distance((1 - u - v) * a + u * b + v * c));
            }
    }
    return most;
}

int judging_level(const ControlMesh& mesh, const SchemeInfo& scheme, const Tessellation& result) {
    constexpr double k_most_faces = 400'000;
    const double faces =
        mesh.halfedge_count() * std::pow(scheme.refinement == Refinement::sqrt3 ? 9.0 : 4.0, result.deepest_level + 1);
    return result.deepest_level + (faces < k_most_faces ? 2 : 1);
}

}  // namespace tetrakis::contract
