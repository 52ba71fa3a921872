#include "mesh_sliding.hpp"

#include "../../hier/base/parallel.hpp"
#include "../../hier/mesh/mesh_links.hpp"

#include <algorithm>

namespace tetrakis {

namespace {

/// Margins for the rounding of angles, and of corners that another computation has rounded differently.
constexpr double k_margin = 1 + 1e-6;
constexpr double k_normal_rounding = 1e-6;

std::size_t next(std::size_t k) { return k == 2 ? 0 : k + 1; }

}  // namespace

MeshSliding::MeshSliding(std::span<const std::array<std::uint32_t, 3>> triangles, std::span<const Vec3d> positions)
    : triangles_(triangles), twin_(3 * triangles.size(), k_none), facets_(triangles.size()) {
    const auto count = static_cast<std::uint32_t>(triangles.size());
    for_each_index(count, [&](std::uint32_t t) {
        Facet& facet = facets_[t];
        const auto& v = triangles[t];
        const std::array<Vec3d, 3> p{positions[v[0]], positions[v[1]], positions[v[2]]};
        const std::array<Vec3d, 3> side{p[1] - p[0], p[2] - p[1], p[0] - p[2]};
        const Vec3d cross = glm::cross(side[0], side[1]);
        const double area = glm::length(cross);
        if (!(area > 0)) return;
        facet.normal = Vec3f(cross / area);
        const std::array<double, 3> length{glm::length(side[0]), glm::length(side[1]), glm::length(side[2])};
        for (std::size_t k = 0; k < 3; ++k) {
            const std::size_t before = next(next(k));
            // tan(a / 2) = sin a / (1 + cos a)
            const double tangent = area / (length[k] * length[before] - glm::dot(side[k], side[before]));
            facet.tangent[k] = static_cast<float>(std::min(tangent, 1e3) / k_margin);
        }
    });
    std::vector<std::uint32_t> offsets(triangles.size() + 1);
    for (std::size_t t = 0; t < offsets.size(); ++t) offsets[t] = static_cast<std::uint32_t>(3 * t);
    const std::span<const std::uint32_t> corners(triangles.empty() ? nullptr : triangles.front().data(),
                                                 3 * triangles.size());
    const auto uses = detail::sorted_edge_uses(offsets, corners, static_cast<std::uint32_t>(positions.size()));
    for (std::size_t begin = 0, end; begin < uses.size(); begin = end) {
        for (end = begin + 1; end < uses.size() && uses[end].same_edge(uses[begin]);) ++end;
        const std::uint32_t a = uses[begin].halfedge, b = uses[end - 1].halfedge;
        if (end - begin != 2 || corners[a] == corners[b]) continue;
        twin_[a] = b;
        twin_[b] = a;
    }
}

EdgeSliding MeshSliding::of(std::uint32_t t, const std::array<bool, 3>& soft) const {
    EdgeSliding sliding;
    const Facet& own = facets_[t];
    for (std::size_t k = 0; k < 3; ++k) {
        const std::uint32_t twin = twin_[3 * std::size_t{t} + k];
        if (!soft[k] || twin == k_none) continue;
        const Facet& other = facets_[twin / 3];
        const Vec3d n(own.normal), m(other.normal);
        const double along = glm::dot(n, m);
        // Upper bound on the angle between the planes: its tangent.
        const double fold = k_margin * glm::length(glm::cross(n, m)) / along + k_normal_rounding;
        if (!(along > 0.5 && fold <= k_largest_fold)) continue;
        sliding.edge[k] = true;
        sliding.fold[k] = fold;
        sliding.flap[k] =
            std::min({own.tangent[k], own.tangent[next(k)], other.tangent[twin % 3], other.tangent[next(twin % 3)]});
    }
    return sliding;
}

}  // namespace tetrakis
