#pragma once

#include "../../hier/forest/site.hpp"
#include "../../hier/mesh/control_mesh.hpp"

#include <cmath>
#include <cstdint>
#include <utility>

namespace tetrakis::detail {

/// Radii that single precision can hold, in which views store vertices.
inline constexpr double k_smallest_radius = 1e-37, k_largest_radius = 1e37;

/// A cube about the origin, faces outward.
inline ControlMesh cube_roots(double half_side) {
    ControlMeshData data;
    for (int v = 0; v < 8; ++v)
        data.positions.push_back(half_side * Vec3d(2 * (v & 1) - 1, (v & 2) - 1, (v >> 1 & 2) - 1));
    data.face_vertices = {0, 2, 3, 1, 4, 5, 7, 6, 0, 1, 5, 4, 2, 6, 7, 3, 0, 4, 6, 2, 1, 3, 7, 5};
    for (std::uint32_t f = 0; f <= 6; ++f) data.face_offsets.push_back(4 * f);
    return ControlMesh::build(std::move(data));
}

/// Position of a point of a corner cell, on roots that are flat parallelograms.
/// @param x, y  in sides of the cell
inline Vec3d on_flat_roots(const ControlMesh& roots, HalfedgeId cell, double x, double y) {
    const auto corner = [&](HalfedgeId h) { return roots.positions()[roots.origin(h).value]; };
    const Vec3d v = corner(cell);
    return v + 0.5 * x * (corner(roots.next(cell)) - v) + 0.5 * y * (corner(roots.prev(cell)) - v);
}
inline Vec3d on_flat_roots(const ControlMesh& roots, const Site& site) {
    return on_flat_roots(roots, site.root, std::ldexp(site.at.x, -site.level), std::ldexp(site.at.y, -site.level));
}

/// Longitude and latitude from (0, 0), at the antimeridian and the north pole, to (1, 1).
inline Vec2d longitude_latitude(const Vec3d& direction) {
    return {std::atan2(direction.y, direction.x) / (2 * M_PI) + 0.5,
            std::atan2(std::hypot(direction.x, direction.y), direction.z) / M_PI};
}

}  // namespace tetrakis::detail
