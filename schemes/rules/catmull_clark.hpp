#pragma once

#include "../core/ring_mask.hpp"

#include <string_view>

namespace tetrakis {

/// Catmull-Clark subdivision. Sources: Catmull, Clark 1978 (rules); Halstead, Kass, DeRose 1993 (limits); DeRose, Kass,
/// Truong 1998 (creases). In quads, a "face" weight belongs to the corner opposite the vertex.
struct CatmullClark {
    static constexpr std::string_view name = "catmull-clark";

    /// Weight of each end of a smooth edge and of each of its two new face points; the same value for n-gons.
    static constexpr double edge_end = 1.0 / 4, edge_face_point = 1.0 / 4;
    /// The same edge rule between two quads, in old points: each end, each of the four far corners.
    static constexpr double edge_end_quads = 3.0 / 8, edge_side_quads = 1.0 / 16;

    /// Moves an interior smooth (or dart) vertex of valence n >= 1; `face`: each new face point. Any faces.
    static RingMask vertex_mask(int valence);
    /// The same between quads; `face`: each opposite corner. vertex = 1 - 7/(4n), edge = 3/(2n^2), face = 1/(4n^2).
    static RingMask vertex_mask_quads(int valence);
    /// Limit position of an interior smooth vertex between quads, valence n >= 1.
    static RingMask limit_mask(int valence);
    /// Eigenvalue of the mode of angle `angle` (2 pi k / n in the interior, pi k / K beside a boundary or crease):
    /// (5 + c + sqrt((1 + c) (9 + c))) / 16, c = cos(angle). The subdominant one is at k = 1.
    static double mode_eigenvalue(double angle);
    /// Ratio of edge to face weights in the tangent masks of that mode (A_n in Halstead et al.):
    /// edge i: A cos(i angle), face i: cos(i angle) + cos((i + 1) angle); also with sin.
    static double tangent_edge_factor(double angle);
};

}  // namespace tetrakis
