#pragma once

#include "../core/masks.hpp"
#include "../core/rule_step.hpp"

#include <array>

namespace tetrakis {

/// Catmull-Clark subdivision. Sources: Catmull, Clark 1978 (rules); Halstead, Kass, DeRose 1993 (limits); DeRose, Kass,
/// Truong 1998 (creases). In quads, a "face" weight belongs to the corner opposite the vertex.
struct CatmullClark {
    /// Smooth edge rule: each end of the edge, and each of its two new face points; for any n-gons.
    static constexpr double edge_end = 1.0 / 4, edge_face_point = 1.0 / 4;
    /// The same rule between two quads, as weights of old points: each end; the four far corners have 1/16 each.
    static constexpr double edge_end_quads = 3.0 / 8;

    /// Moves an interior smooth (or dart) vertex of valence n >= 1 between any faces; `face`: each new face point.
    static RingMask vertex_mask(int valence);
    /// Limit position of an interior smooth vertex between quads, valence n >= 1.
    static RingMask limit_mask(int valence);
    /// Eigenvalue of the mode of angle `angle` (2 pi k / n in the interior, pi k / K beside a boundary or crease):
    /// (5 + c + sqrt((1 + c) (9 + c))) / 16, c = cos(angle). The subdominant one is at k = 1.
    static double mode_eigenvalue(double angle);
    /// Ratio of edge to face weights in the tangent masks of that mode (A_n in Halstead et al.):
    /// edge i: A cos(i angle), face i: cos(i angle) + cos((i + 1) angle); also with sin.
    static double tangent_edge_factor(double angle);
    /// Masks of an interior smooth vertex between quads, with the given limit mask.
    static ClosedMasks ring_closed_masks(int valence, const RingMask& limit);
};

/// One step of Catmull-Clark on any polygons, with rules for smooth, crease, boundary, corner, dart and semi-sharp.
///
/// Options: the C1 edge rule beside creases (Biermann, Levin, Zorin 2000), between quads. With K faces on the side of
/// the crease vertex c, it moves the plain edge point by cos(theta) / 4 (c - e), theta = pi / K. The brief form has cos
/// = 1, where the plain rule fails (K > 3). Sectors of corners may have an angle (RuleMesh::corner_angle() or the
/// option); concave ones of two faces or more get the flatness step. Other vertex weights beta and gamma.
/// @throws std::invalid_argument  the corner angle is not in [0, 2 pi) or is pi; beta, gamma at a vertex that has other
///                                faces than quads, or outside catmull_clark_weight_range() at a vertex of the mesh:
///                                there would be no tangent plane (the message gives the range)
RuleStep catmull_clark_step(const RuleMesh& mesh, const RuleOptions& options);

ClosedMasks catmull_clark_closed_masks(const FanShape& shape, const RuleOptions& options);

/// Corners of the triangle in the (beta, gamma) plane inside which a vertex of valence n between quads keeps its
/// subdominant pair. beta is the total weight of edge neighbours, gamma of opposite corners; the vertex has the rest.
///
/// Only the rotation-symmetric part of the ring matrix depends on beta and gamma. Its eigenvalues are 1 and the roots
/// of x^2 - t x + d with t = 3/4 - beta - gamma, d = (1 - 2 beta) / 16. Both roots are below lambda in magnitude if and
/// only if |d| < lambda^2 and |t| < lambda + d / lambda (Schur-Cohn): three lines bound the triangle.
std::array<std::array<double, 2>, 3> catmull_clark_weight_range(int valence);
/// Whether beta and gamma are inside that triangle.
bool catmull_clark_weights_admissible(int valence, double beta, double gamma);

}  // namespace tetrakis
