#include "rule_limit.hpp"

#include "../../schemes/rules/averaging.hpp"
#include "face_normals.hpp"
#include "fan_limit.hpp"
#include "limit_search.hpp"
#include "regular_limit.hpp"

#include <algorithm>
#include <numeric>
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
                                (scheme.family == MeshFamily::hexagons ? ": a crease that ends there" : "") +
                                "; leave out the limit");
}

Vec3d sum(const StencilTable& table, int row, std::span<const Vec3d> net) {
    Vec3d result(0);
    const auto from = table.points(row);
    const auto weights = table.weights(row);
    for (std::size_t i = 0; i < from.size(); ++i) result += weights[i] * net[static_cast<std::size_t>(from[i])];
    return result;
}

}  // namespace

RuleLimits rule_limits(const RuleMesh& mesh, const SchemeInfo& scheme, const RuleOptions& options) {
    std::vector<int> all(mesh.vertex_count());
    std::iota(all.begin(), all.end(), 0);
    return RuleLimitFinder(scheme, options).find(mesh, all, boundary_recedes(scheme, options));
}

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

LimitPoint limit_point(const RuleLimits& limits, int i, const RuleMesh& mesh, std::span<const Vec3d> net, int v) {
    const int begin = limits.begin[static_cast<std::size_t>(i)], end = limits.begin[static_cast<std::size_t>(i) + 1];
    LimitPoint point;
    point.position = sum(limits.positions, i, net);
    for (int row = begin; row < end; ++row) {
        const Vec3d t1 = sum(limits.tangent1, row, net), t2 = sum(limits.tangent2, row, net);
        if (row == begin) {
            point.tangent1 = t1;
            point.tangent2 = t2;
        }
        point.normal += unit_or_zero(glm::cross(t1, t2));
    }
    point.normal = unit_of_sum(point.normal);
    point.has_tangent_plane = end == begin + 1 && point.normal != Vec3d(0);
    if (point.normal == Vec3d(0)) point.normal = face_normal_at(mesh, net, v);
    return point;
}

Vec3d limit_normal(const RuleLimits& limits, int i, const RuleMesh& mesh, std::span<const Vec3d> net, int v) {
    Vec3d normal(0);
    const auto at = static_cast<std::size_t>(i);
    for (int row = limits.begin[at]; row < limits.begin[at + 1]; ++row)
        normal += unit_or_zero(glm::cross(sum(limits.tangent1, row, net), sum(limits.tangent2, row, net)));
    normal = unit_of_sum(normal);
    return normal != Vec3d(0) ? normal : face_normal_at(mesh, net, v);
}

struct RuleLimitFinder::State {
    State(const SchemeInfo& s, const RuleOptions& o) : scheme(s), options(o), search(scheme, options) {}

    /// The mask of regular vertices, made when it is first asked for; nullptr if there is none.
    RegularLimit* regular() {
        if (asked) return mask ? &*mask : nullptr;
        asked = true;
        if (scheme.family == MeshFamily::hexagons) return nullptr;
        // One more ring than any limit depends on.
        const int rings = rule_limit_rings(scheme, options) + 1;
        const FanLattice lattice = fan_lattice(scheme, options);
        const RuleMesh mesh = RegularLimit::lattice_mesh(lattice, rings);
        const int middle = RegularLimit::middle(rings);
        const std::optional<LimitRows> rows = search.find(mesh, {&middle, 1})[0];
        if (!rows) return nullptr;
        mask.emplace(lattice, rings, rows->limit,
                     rows->tangents.empty() ? std::span<const StencilRow>() : rows->tangents[0]);
        fans.emplace(lattice, mask->radius(), rings - 1,
                     [this](const RuleMesh& fan, std::span<const int> vertices) { return search.find(fan, vertices); });
        return &*mask;
    }

    /// Rows of vertices that are not regular.
    std::vector<std::optional<LimitRows>> others(const RuleMesh& mesh, std::span<const int> vertices) {
        std::vector<std::optional<LimitRows>> rows(vertices.size());
        if (fans) fans->find(mesh, mask->regular(), vertices, rows);
        std::vector<int> left;
        for (std::size_t i = 0; i < rows.size(); ++i)
            if (!rows[i]) left.push_back(vertices[i]);
        std::vector<std::optional<LimitRows>> found = search.find(mesh, left);
        for (std::size_t i = 0, k = 0; i < rows.size(); ++i)
            if (!rows[i]) rows[i] = std::move(found[k++]);
        return rows;
    }

    const SchemeInfo& scheme;
    RuleOptions options;
    LimitSearch search;
    bool asked = false;
    std::optional<RegularLimit> mask;
    std::optional<FanLimits> fans;
};

RuleLimitFinder::RuleLimitFinder(const SchemeInfo& scheme, const RuleOptions& options)
    : state_(std::make_unique<State>(scheme, options)) {}
RuleLimitFinder::~RuleLimitFinder() = default;
RuleLimitFinder::RuleLimitFinder(RuleLimitFinder&&) noexcept = default;

RuleLimits RuleLimitFinder::find(const RuleMesh& mesh, std::span<const int> vertices, bool may_miss) {
    const SchemeInfo& scheme = state_->scheme;
    RegularLimit* regular = state_->regular();
    if (regular != nullptr) regular->look_at(mesh);
    const auto is_regular = [&](int v) { return regular != nullptr && regular->found(mesh, v); };
    std::vector<int> others;
    for (const int v : vertices)
        if (mesh.first(v) != RuleMesh::none && !is_regular(v)) others.push_back(v);
    // By blocks: rows on their own take several times what they take in the tables.
    // Honeycomb refinement has all its vertices here.
    const std::size_t block = std::size_t{1} << (scheme.family == MeshFamily::hexagons ? 8 : 13);
    std::vector<std::optional<LimitRows>> found;
    RuleLimits limits;
    std::size_t next = 0;
    const auto next_rows = [&]() -> const std::optional<LimitRows>& {
        const std::size_t at = next++ % block;
        if (at == 0) {
            found.clear();
            found =
                state_->others(mesh, std::span(others).subspan(next - 1, std::min(block, others.size() - next + 1)));
        }
        return found[at];
    };
    for (const int v : vertices) {
        if (mesh.first(v) == RuleMesh::none) {
            limits.positions.push({{v, 1}});
        } else if (is_regular(v)) {
            limits.positions.push(regular->limit());
            if (auto tangents = regular->tangents()) {
                limits.tangent1.push(std::move(tangents->first));
                limits.tangent2.push(std::move(tangents->second));
            }
        } else {
            const std::optional<LimitRows>& rows = next_rows();
            if (!rows && !may_miss) refuse(mesh, v, scheme);
            if (!rows) {
                limits.missing.push_back(v);
                limits.positions.push({{v, 1}});
                limits.begin.push_back(limits.tangent1.row_count());
                continue;
            }
            limits.positions.push(rows->limit);
            for (const auto& [t1, t2] : rows->tangents) {
                limits.tangent1.push(t1);
                limits.tangent2.push(t2);
            }
        }
        limits.begin.push_back(limits.tangent1.row_count());
    }
    return limits;
}

}  // namespace tetrakis::detail
