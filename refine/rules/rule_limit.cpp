#include "rule_limit.hpp"

#include "face_normals.hpp"

#include <algorithm>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>

namespace tetrakis::detail {

namespace {

[[noreturn]] void refuse(const RuleMesh& mesh, int v, const SchemeInfo& scheme) {
    throw std::invalid_argument(std::string(scheme.name) + " has no limit mask for vertex " + std::to_string(v) +
                                " of the level, " + (mesh.on_boundary(v) ? "on the boundary" : "inside the mesh") +
                                (scheme.family == MeshFamily::hexagons ? ": a crease that ends there" : ""));
}

Vec3d sum(const StencilTable& table, int row, std::span<const Vec3d> net) {
    Vec3d result(0);
    const auto from = table.points(row);
    const auto weights = table.weights(row);
    for (std::size_t i = 0; i < from.size(); ++i) result += weights[i] * net[static_cast<std::size_t>(from[i])];
    return result;
}

}  // namespace

Vec3d face_normal_at(const RuleMesh& mesh, std::span<const Vec3d> net, int v) {
    FaceNormals normals;
    std::vector<Vec3d> points;
    for (const int h : mesh.ring(v).halfedge) {
        points.clear();
        for (const int w : mesh.corners(mesh.face(h))) points.push_back(net[w]);
        normals.add(points, static_cast<std::size_t>(h - mesh.face_begin(mesh.face(h))));
    }
    return normals.normal();
}

Vec3d limit_normal(const RuleLimits& limits, int i, const RuleMesh& mesh, std::span<const Vec3d> net, int v) {
    Vec3d normal(0);
    const auto at = static_cast<std::size_t>(i);
    for (int row = limits.begin[at]; row < limits.begin[at + 1]; ++row)
        normal += unit_or_zero(glm::cross(sum(limits.tangent1, row, net), sum(limits.tangent2, row, net)));
    normal = unit_of_sum(normal);
    return normal != Vec3d(0) ? normal : face_normal_at(mesh, net, v);
}

LimitPoint limit_point(const RuleLimits& limits, int i, const RuleMesh& mesh, std::span<const Vec3d> net, int v) {
    const int begin = limits.begin[static_cast<std::size_t>(i)], end = limits.begin[static_cast<std::size_t>(i) + 1];
    LimitPoint point;
    point.position = sum(limits.positions, i, net);
    point.normal = limit_normal(limits, i, mesh, net, v);
    if (begin == end) return point;
    point.tangent1 = sum(limits.tangent1, begin, net);
    point.tangent2 = sum(limits.tangent2, begin, net);
    point.has_tangent_plane = end == begin + 1 && unit_or_zero(glm::cross(point.tangent1, point.tangent2)) != Vec3d(0);
    return point;
}

RuleLimits rule_limits(LimitSearch& search, const RuleMesh& mesh, std::span<const int> vertices, bool may_miss) {
    // In blocks: rows that are not in a table yet take several times the memory that they take in it.
    constexpr std::size_t block = std::size_t{1} << 13;
    RuleLimits limits;
    std::vector<int> some;
    for (std::size_t begin = 0; begin < vertices.size(); begin += block) {
        const auto here = vertices.subspan(begin, std::min(block, vertices.size() - begin));
        some.clear();
        for (const int v : here)
            if (mesh.first(v) != RuleMesh::none) some.push_back(v);
        const std::vector<std::optional<LimitRows>> found = search.find(mesh, some);
        for (std::size_t i = 0, k = 0; i < here.size(); ++i) {
            const int v = here[i];
            const bool isolated = mesh.first(v) == RuleMesh::none;
            const std::optional<LimitRows> none, &rows = isolated ? none : found[k++];
            if (!rows && !isolated && !may_miss) refuse(mesh, v, search.scheme());
            if (!rows && !isolated) limits.missing.push_back(v);
            limits.positions.push(rows ? rows->limit : StencilRow{{v, 1}});
            if (rows)
                for (const auto& [t1, t2] : rows->tangents) {
                    limits.tangent1.push(t1);
                    limits.tangent2.push(t2);
                }
            limits.begin.push_back(limits.tangent1.row_count());
        }
    }
    return limits;
}

}  // namespace tetrakis::detail
