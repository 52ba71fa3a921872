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

/// Why a vertex may have no limit.
const char* why_none(const SchemeInfo& scheme, bool recedes) {
    if (recedes)
        return ": each step uses up the outer ring, so what lies near the end of the mesh has no place on the limit "
               "surface";
    if (scheme.family == MeshFamily::hexagons) return ": a crease that ends there";
    return "";
}

}  // namespace

RuleLimits rule_limits(const RuleMesh& mesh, const SchemeInfo& scheme, const RuleOptions& options) {
    std::vector<int> all(mesh.vertex_count());
    std::iota(all.begin(), all.end(), 0);
    return RuleLimitFinder(scheme, options).find(mesh, all, true);
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

Vec3d limit_sum(const StencilTable& table, int row, std::span<const Vec3d> net) {
    Vec3d result(0);
    const auto from = table.points(row);
    const auto weights = table.weights(row);
    for (std::size_t i = 0; i < from.size(); ++i) result += weights[i] * net[static_cast<std::size_t>(from[i])];
    return result;
}

Vec3d limit_normal(const RuleLimits& limits, int i, const RuleMesh& mesh, std::span<const Vec3d> net, int v) {
    Vec3d normal(0);
    const auto at = static_cast<std::size_t>(i);
    for (int row = limits.begin[at]; row < limits.begin[at + 1]; ++row)
        normal += unit_or_zero(glm::cross(limit_sum(limits.tangent1, row, net), limit_sum(limits.tangent2, row, net)));
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

RuleLimits RuleLimitFinder::find(const RuleMesh& mesh, std::span<const int> vertices, bool may_end) {
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
            const bool recedes = boundary_recedes(scheme, state_->options);
            if (!rows && may_end && recedes) {
                limits.beyond.push_back(v);
                limits.positions.push({{v, 1}});
                limits.begin.push_back(limits.tangent1.row_count());
                continue;
            }
            if (!rows)
                throw std::invalid_argument(std::string(scheme.name) + " has no limit mask for vertex " +
                                            std::to_string(v) + " of the level, " +
                                            (mesh.on_boundary(v) ? "on the boundary" : "inside the mesh") +
                                            why_none(scheme, recedes) + "; leave out the limit");
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

RegularLimit* RuleLimitFinder::regular() { return state_->regular(); }

std::optional<int> RuleLimitFinder::regular_rings() {
    const RegularLimit* regular = state_->regular();
    if (regular == nullptr) return std::nullopt;
    return regular->radius() + 1;
}

std::vector<int> RuleLimitFinder::regular_points(const RuleMesh& mesh, std::span<const Vec3d> net,
                                                 std::span<const int> vertices, int rings, std::span<LimitPoint> out) {
    std::vector<int> others;
    RegularLimit* regular = state_->regular();
    const bool any = regular != nullptr && rings > regular->radius();
    if (any) regular->look_at(mesh);
    for (std::size_t i = 0; i < vertices.size(); ++i) {
        const int v = vertices[i];
        if (!any || !regular->found(mesh, v)) {
            others.push_back(static_cast<int>(i));
            continue;
        }
        out[i] = regular->point(net);
        if (out[i].normal == Vec3d(0)) out[i].normal = face_normal_at(mesh, net, v);
    }
    return others;
}

namespace {

/// Puts the point of a vertex together from its rows: sums of terms, and the tangents of each side of a crease.
template <class Sum>
LimitPoint point_of(const RuleMesh& mesh, std::span<const Vec3d> net, int v, int tangent_count, const Sum& sum) {
    LimitPoint point;
    point.position = sum(-1, 0);
    Vec3d normal(0);
    for (int i = 0; i < tangent_count; ++i) {
        const Vec3d t1 = sum(i, 0), t2 = sum(i, 1);
        if (i == 0) {
            point.tangent1 = t1;
            point.tangent2 = t2;
        }
        normal += unit_or_zero(glm::cross(t1, t2));
    }
    point.has_tangent_plane = tangent_count == 1 && normal != Vec3d(0);
    point.normal = unit_of_sum(normal);
    if (point.normal == Vec3d(0)) point.normal = face_normal_at(mesh, net, v);
    return point;
}

}  // namespace

void RuleLimitFinder::points(const RuleMesh& mesh, std::span<const Vec3d> net, std::span<const int> vertices,
                             std::span<LimitPoint> out) {
    const std::vector<int> others =
        regular_points(mesh, net, vertices, rule_limit_rings(state_->scheme, state_->options), out);
    if (others.empty()) return;
    std::vector<int> left;
    for (const int i : others) left.push_back(vertices[i]);
    const RuleLimits limits = find(mesh, left);
    for (std::size_t i = 0; i < left.size(); ++i) {
        const int first = limits.begin[i], row = static_cast<int>(i);
        out[others[i]] = point_of(mesh, net, left[i], limits.begin[i + 1] - first, [&](int pair, int which) {
            const StencilTable& table = pair < 0 ? limits.positions : which == 0 ? limits.tangent1 : limits.tangent2;
            const int at = pair < 0 ? row : first + pair;
            const auto from = table.points(at);
            const auto weights = table.weights(at);
            Vec3d result(0);
            for (std::size_t k = 0; k < from.size(); ++k) result += weights[k] * net[from[k]];
            return result;
        });
    }
}

}  // namespace tetrakis::detail
