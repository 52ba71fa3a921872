#pragma once

#include "rule_mesh.hpp"
#include "rule_step.hpp"

#include <cmath>
#include <numbers>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

namespace tetrakis {

/// The angle that a corner's rules use: at most 350 degrees, and 170 if `angle` is within 10 degrees of 180, because
/// the flatness step divides by its sine.
double usable_corner_angle(double angle);

namespace detail {

inline bool is_corner_angle(double angle) {
    return angle > 0 && angle < 2 * std::numbers::pi && angle != std::numbers::pi;
}

/// Values of RuleMesh::corner_angle() for the next level, where vertices keep their angles. Where the edge between two
/// sectors becomes smooth, the merged sector gets the usable sum of their angles, or none if one had none.
/// @param child  per half-edge: the finer half-edge that leaves the same vertex within the same face
/// @param fine   number of half-edges of the finer mesh
std::vector<double> child_corner_angles(const RuleMesh& mesh, std::span<const int> child, std::size_t fine);

/// Eigenvalue that the flatness step leaves to the ring's fastest mode besides the tangents: the square of the
/// tangents' eigenvalue 1/2, so the curvature stays bounded.
inline constexpr double k_flat_eigenvalue = 0.25;

inline void check_corner_angle(const RuleOptions& options) {
    if (options.corner_angle != 0 && !is_corner_angle(options.corner_angle))
        throw std::invalid_argument("the corner angle must be 0 (plain rule) or in (0, 2 pi), and not pi");
}

/// Angle of the sector at origin(h) that contains face(h): its own, else that of the options.
inline double sector_angle(const RuleMesh& mesh, int h, const RuleOptions& options) {
    const double own = mesh.corner_angle(h);
    return own > 0 ? own : options.corner_angle;
}
/// Whether any corner of the mesh may have an angle.
inline bool may_have_angles(const RuleMesh& mesh, const RuleOptions& options) {
    return options.corner_angle > 0 || mesh.has_corner_angles();
}

inline void need_triangles(const RuleMesh& mesh, const char* scheme) {
    for (int f = 0; f < mesh.face_count(); ++f)
        if (mesh.face_size(f) != 3)
            throw std::invalid_argument(std::string(scheme) + " takes triangles, and face " + std::to_string(f) +
                                        " has " + std::to_string(mesh.face_size(f)) +
                                        " corners; triangulate the mesh first");
}

/// One end of a smooth edge whose rule it changes: a corner with an angle, or a crease with the C1 rule.
struct Bend {
    int out;              ///< half-edge of the edge that leaves that end
    int faces;            ///< number of faces in the sector
    double theta;         ///< angle per face that the rule uses
    double corner_angle;  ///< of the sector; 0 on creases
};
/// @param plain_faces  largest number of faces beside a crease for which the plain rule still has a tangent plane
std::optional<Bend> bend_at(const RuleMesh& mesh, int h, const RuleOptions& options, int plain_faces);

/// Ring edge i of a corner's fan as the affine image of a planar fan of angle alpha, one level down: c + x / 2 with
/// x = (sin(alpha - i theta) (p_0 - c) + sin(i theta) (p_K - c)) / sin(alpha), theta = alpha / K. Exactly the vectors
/// that the corner's edge rule halves.
inline void add_flat_ring_point(StencilRow& row, double weight, int c, const RuleMesh::Ring& sector, int i,
                                double alpha) {
    const double theta = alpha / sector.faces();
    const double first = std::sin(alpha - i * theta) / std::sin(alpha), last = std::sin(i * theta) / std::sin(alpha);
    row.add(c, -weight * (first + last) / 2);
    row.add(sector.neighbour.front(), weight * first / 2);
    row.add(sector.neighbour.back(), weight * last / 2);
}

/// How much of a ring point the flatness step replaces.
inline double flatness_share(double most) { return most > k_flat_eigenvalue ? 1 - k_flat_eigenvalue / most : 0; }

/// The flatness step at concave corners (the idea of Biermann, Levin, Zorin 2000, section 3.2; the amount is ours): the
/// new ring edge i is pulled to the corner's tangent plane, so that the mode with eigenvalue `most` keeps
/// k_flat_eigenvalue. Vectors in the plane are left as they are.
inline StencilRow flattened(const StencilRow& row, int c, const RuleMesh::Ring& sector, int i, double alpha,
                            double most) {
    const double s = flatness_share(most);
    StencilRow result;
    result.add(row, 1 - s);
    result.add(c, s);
    add_flat_ring_point(result, s, c, sector, i, alpha);
    return result;
}

/// The same for the quad between ring edges i and i + 1: the vector to its planar image is the sum of theirs.
inline StencilRow flattened_face(const StencilRow& row, int c, const RuleMesh::Ring& sector, int i, double alpha,
                                 double most) {
    StencilRow result = flattened(row, c, sector, i, alpha, most);
    add_flat_ring_point(result, flatness_share(most), c, sector, i + 1, alpha);
    return result;
}

/// The row of a smooth edge whose rule `bend` changes; flattened where the end is a concave corner.
/// @param corner_mode  largest eigenvalue of the ring's first sine mode at a corner with `faces` faces of angle `theta`
inline StencilRow flattened_edge(const StencilRow& row, const RuleMesh& mesh, const Bend& bend,
                                 double (*corner_mode)(int faces, double theta)) {
    if (bend.corner_angle <= std::numbers::pi) return row;
    const RuleMesh::Ring sector = mesh.sector(bend.out);
    if (sector.closed) return row;
    return flattened(row, mesh.origin(bend.out), sector, sector.position(mesh.target(bend.out)), bend.corner_angle,
                     corner_mode(bend.faces, bend.theta));
}

}  // namespace detail
}  // namespace tetrakis
