#pragma once

#include "surface_family.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace tetrakis::detail {

/// 0 for what is smooth or sharp for good.
inline double finite_sharpness(double sharpness) { return sharpness < k_sharpness_infinity ? sharpness : 0; }

/// The largest finite sharpness of the control edge that a corner of a leaf lies on, or of the control vertex it is and
/// the edges there.
template <class Family>
double finite_sharpness_at(const ControlMesh& mesh, const CellTriangle& leaf, std::size_t k) {
    if (const HalfedgeId h = Family::control_edge_at(mesh, leaf, k); h.valid())
        return finite_sharpness(mesh.sharpness(mesh.edge(h)));
    const VertexId v = Family::control_vertex_at(mesh, leaf, k);
    if (!v.valid()) return 0;
    double most = finite_sharpness(mesh.sharpness(v));
    const HalfedgeId first = mesh.vertex_halfedge(v);
    for (HalfedgeId h = first; h.valid();) {
        most = std::max({most, finite_sharpness(mesh.sharpness(mesh.edge(h))),
                         finite_sharpness(mesh.sharpness(mesh.edge(mesh.prev(h))))});
        h = mesh.ccw_outgoing(h);
        if (h == first) break;
    }
    return most;
}

/// Visits points of a leaf, as barycentrics, that a lattice with 4 intervals an edge or more may miss: the surface
/// rounds an edge or vertex of sharpness s off within 2^-s of the faces there, so ever nearer to the leaf's edges and
/// corners that lie on one. None where the leaf is no wider than that.
template <class Family, class Visit>
void for_each_strip_point(const ControlMesh& mesh, const CellTriangle& leaf, Visit&& visit) {
    constexpr int k_along = 4, k_across = 4;  // intervals of an edge; of a line across a corner
    constexpr int k_within = 2;               // halvings more than the strip's own width takes
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
    for (std::size_t k = 0; k < 3; ++k) {
        const std::size_t k1 = (k + 1) % 3, k2 = (k + 2) % 3;
        std::array<double, 3> b;
        double off = k_first;
        for (int i = 0; i < at_edge[k]; ++i, off *= 0.5)
            for (int j = 0; j <= k_along; ++j) {
                b[k2] = off;
                b[k] = (1 - off) * (k_along - j) / k_along;
                b[k1] = 1 - off - b[k];
                visit(b[0], b[1], b[2]);
            }
        if (at_corner[k] <= std::max(at_edge[k], at_edge[k2])) continue;
        off = k_first;
        for (int i = 0; i < at_corner[k]; ++i, off *= 0.5)
            for (int j = 0; j <= k_across; ++j) {
                b[k] = 1 - off;
                b[k1] = off * (k_across - j) / k_across;
                b[k2] = off - b[k1];
                visit(b[0], b[1], b[2]);
            }
    }
}

}  // namespace tetrakis::detail
