#pragma once

#include "../triangles/point_triangle.hpp"
#include "mesh_sampling.hpp"
#include "surface_family.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

namespace tetrakis::detail {

/// Intervals a side of the lattice of limit points over a triangle of a hierarchy. Its points are the vertices that the
/// triangle would have after two more levels.
inline constexpr int k_limit_lattice = 4;
inline constexpr int k_limit_lattice_bits = 2;
inline constexpr int k_limit_samples = (k_limit_lattice + 1) * (k_limit_lattice + 2) / 2;

/// The limit points of one triangle: rows from corner 2 towards the edge from corner 0 to corner 1.
using LimitSamples = std::array<Vec3d, k_limit_samples>;

constexpr int lattice_index(int row, int i) { return row * (row + 1) / 2 + i; }
constexpr int lattice_points(int intervals) { return (intervals + 1) * (intervals + 2) / 2; }

/// The corners of a triangle among its samples.
inline std::array<Vec3d, 3> corners_of(const LimitSamples& s) {
    return {s[static_cast<std::size_t>(lattice_index(k_limit_lattice, 0))],
            s[static_cast<std::size_t>(lattice_index(k_limit_lattice, k_limit_lattice))], s[0]};
}

/// The canonical site of point i of row `row` of a triangle's lattice with 2^bits intervals a side.
template <class Family>
Site lattice_site_of(const ControlMesh& mesh, const CellTriangle& t, int bits, int row, int i) {
    const auto n = 1u << bits, w0 = static_cast<std::uint32_t>(row - i), w1 = static_cast<std::uint32_t>(i),
               w2 = n - static_cast<std::uint32_t>(row);
    const auto at = [&](std::uint32_t p0, std::uint32_t p1, std::uint32_t p2) { return w0 * p0 + w1 * p1 + w2 * p2; };
    const auto& c = t.corner;
    return Family::canonical_site(
        mesh,
        Family::lattice_site(mesh, t.root, {at(c[0].x, c[1].x, c[2].x), at(c[0].y, c[1].y, c[2].y)}, t.level + bits));
}

/// The sample of a triangle's lattice with n intervals a side that is farthest from the triangle by PlaneMeasure.
/// Samples on hard edges are compared with the edge itself, too.
inline Maximum farthest_sample(std::span<const Vec3d> s, int n, const PlaneMeasure& plane,
                               const std::array<bool, 3>& hard) {
    const Vec3d ends[4] = {s[s.size() - 1 - static_cast<std::size_t>(n)], s.back(), s[0],
                           s[s.size() - 1 - static_cast<std::size_t>(n)]};
    Maximum top;
    for_each_lattice_point(n, [&](int i, double b0, double b1, double b2) {
        const Vec3d& p = s[static_cast<std::size_t>(i)];
        const double parametric = glm::length(p - (b0 * ends[0] + b1 * ends[1] + b2 * ends[2]));
        if (parametric <= top.value) return;
        top.offer({b1, b2}, std::min(parametric, plane(p)));
        const double across[3] = {b2, b0, b1};
        for (std::size_t k = 0; k < 3; ++k)
            if (hard[k] && across[k] == 0) top.offer({b1, b2}, segment_distance(p, ends[k], ends[k + 1]));
    });
    return top;
}

/// Estimated upper limit of the distance from a point of a flat triangle to the surface with these samples. It is the
/// distance to the small triangles between the samples, plus how far the surface may bend away from these.
/// @param most  the largest distance of a sample from the flat triangle
inline double distance_to_samples(const Vec3d& q, const LimitSamples& s, double most) {
    // The bend is a sixteenth of `most` if second derivatives are constant; the double allows for others.
    constexpr double k_bend = 1.0 / 8;
    double squared = std::numeric_limits<double>::infinity();
    const auto at = [&](int row, int i) -> const Vec3d& { return s[static_cast<std::size_t>(lattice_index(row, i))]; };
    for (int row = 0; row < k_limit_lattice; ++row)
        for (int i = 0; i <= row; ++i) {
            const Vec3d &a = at(row, i), &b = at(row + 1, i), &c = at(row + 1, i + 1);
            squared = std::min(squared, nearest_on_triangle(q, a, b, c).squared_distance);
            if (i < row) squared = std::min(squared, nearest_on_triangle(q, a, c, at(row, i + 1)).squared_distance);
        }
    return std::sqrt(squared) + k_bend * most;
}

/// The sharpness if it is finite; else 0.
inline double finite_sharpness(double sharpness) { return sharpness < k_sharpness_infinity ? sharpness : 0; }

/// The largest finite sharpness at corner k of a leaf: of the control edge that it lies on, or of its control vertex
/// and the edges there.
template <class Family>
double finite_sharpness_at(const ControlMesh& mesh, const CellTriangle& leaf, std::size_t k) {
    if (const HalfedgeId h = Family::control_edge_at(mesh, leaf, k); h.valid())
        return finite_sharpness(mesh.sharpness(mesh.edge(h)));
    const VertexId v = Family::control_vertex_at(mesh, leaf, k);
    if (!v.valid()) return 0;
    double most = finite_sharpness(mesh.sharpness(v));
    if (mesh.is_isolated(v)) return most;
    for_each_outgoing(mesh, v, [&](HalfedgeId h) {
        most = std::max({most, finite_sharpness(mesh.sharpness(mesh.edge(h))),
                         finite_sharpness(mesh.sharpness(mesh.edge(mesh.prev(h))))});
    });
    return most;
}

/// Visits points of a leaf, as barycentrics, where a lattice with 4 or more intervals a side may miss a rounding. The
/// surface rounds an edge or vertex of sharpness s within 2^-s of the width of its faces. So the points come ever
/// closer to leaf edges and corners on it. There are none if the leaf is no wider than the rounding.
template <class Family, class Visit>
void for_each_strip_point(const ControlMesh& mesh, const CellTriangle& leaf, Visit&& visit) {
    constexpr int k_intervals = 4;  // of a line of points along an edge, or across a corner
    constexpr int k_within = 2;     // number of lines closer than the width of the rounded strip
    constexpr double k_first = 1.0 / 8;
    std::array<int, 3> at_edge, at_corner;
    const auto halvings = [&](double sharpness) {
        return sharpness > 0 ? static_cast<int>(std::ceil(sharpness)) - leaf.level + k_within - 2 : 0;
    };
    for (std::size_t k = 0; k < 3; ++k) {
        const HalfedgeId h = Family::control_edge(mesh, leaf, k);
        at_edge[k] = h.valid() ? halvings(finite_sharpness(mesh.sharpness(mesh.edge(h)))) : 0;
        at_corner[k] = halvings(finite_sharpness_at<Family>(mesh, leaf, k));
    }
    // Visits points on the line where `corner` has the given barycentric weight.
    const auto visit_line = [&](std::size_t corner, double weight) {
        for (int j = 0; j <= k_intervals; ++j) {
            std::array<double, 3> b;
            b[corner] = weight;
            b[(corner + 1) % 3] = (1 - weight) * (k_intervals - j) / k_intervals;
            b[(corner + 2) % 3] = 1 - weight - b[(corner + 1) % 3];
            visit(b[0], b[1], b[2]);
        }
    };
    for (std::size_t k = 0; k < 3; ++k) {
        const std::size_t opposite = (k + 2) % 3;
        for (int i = 0; i < at_edge[k]; ++i) visit_line(opposite, std::ldexp(k_first, -i));
        if (at_corner[k] <= std::max(at_edge[k], at_edge[opposite])) continue;
        for (int i = 0; i < at_corner[k]; ++i) visit_line(k, 1 - std::ldexp(k_first, -i));
    }
}

}  // namespace tetrakis::detail
