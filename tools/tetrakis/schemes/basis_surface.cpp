#include "basis_surface.hpp"

#include "../../../refine/rules/rule_limit.hpp"

#include <algorithm>
#include <cstdint>

namespace tetrakis::cli {

BasisSurface basis_surface(const FanPatch& patch, const SchemeInfo& scheme, const RuleOptions& rules,
                           const std::vector<int>& near, double height) {
    BasisSurface surface;
    std::vector<Vec3d> net;
    for (std::size_t v = 0; v < patch.plane.size(); ++v)
        net.push_back({patch.plane[v].x, height * patch.height[v], -patch.plane[v].y});
    const auto limits = tetrakis::detail::RuleLimitFinder(scheme, rules).find(patch.mesh, near);
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
