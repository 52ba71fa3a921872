#include "dual_face_bound.hpp"

#include "convex_face.hpp"
#include "plane_measure.hpp"

#include <algorithm>
#include <limits>

namespace tetrakis::detail {

namespace {

constexpr double k_unbounded = std::numeric_limits<double>::infinity();

void bound_triangle(const DualSurface& surface, const DualFacePieces& pieces, std::size_t piece,
                    std::span<double> of_corner) {
    std::array<Vec3d, 3> position;
    for (std::size_t k = 0; k < 3; ++k) position[k] = pieces.corners()[pieces.corner(piece, k)].position;
    for (std::size_t i = 0; i < pieces.corners().size(); ++i) {
        const DualFacePieces::Corner& c = pieces.corners()[i];
        const std::array<Vec2d, 3> at = pieces.triangle(piece, c);
        const ShortPolygon whole{at[0], at[1], at[2]};
        if (!(whole.area() > 0)) {
            of_corner[i] = k_unbounded;
            continue;
        }
        const DualBox box = box_of(surface.axes(c.cell.root), c.cell);
        const ShortPolygon part = whole.within(box.low, box.high);
        if (part.is_nothing_beside(box.high - box.low)) continue;
        const FlatMap flat(at, position);
        const auto on_part = [&](const DualPart& polynomial) {
            of_corner[i] = std::max(of_corner[i], polynomial.difference(flat));
        };
        const auto on_point = [&](std::uint32_t point) {
            for (const Vec3d& p : surface.hull(point))
                for (std::size_t k = 0; k < part.size(); ++k)
                    of_corner[i] = std::max(of_corner[i], glm::length(p - flat(part[k])));
        };
        surface.visit(c.leaf, c.cell, part, on_part, on_point);
    }
}

/// All of the face and of its surface is near the first vertex, which is on both.
double bound_blindly(const DualFacePieces& pieces) {
    const Vec3d first = pieces.corners()[0].position;
    double error = 0;
    for (const DualFacePieces::Corner& c : pieces.corners()) error = std::max(error, glm::length(c.position - first));
    pieces.for_each_hull(0, [&](std::span<const Vec3d> points, double slack) {
        for (const Vec3d& p : points) error = std::max(error, glm::length(p - first) + slack);
    });
    return error;
}

double bound_whole(const DualFacePieces& pieces) {
    std::vector<Vec3d> position;
    for (const DualFacePieces::Corner& c : pieces.corners()) position.push_back(c.position);
    const ConvexFace face(position);
    if (!face.convex()) return bound_blindly(pieces);
    double forward = 0, backward = 0;
    pieces.for_each_hull(0, [&](std::span<const Vec3d> points, double slack) {
        for (const Vec3d& p : points) forward = std::max(forward, face.distance(p) + slack);
    });
    for (std::size_t i = 0; i < position.size(); ++i) {
        double off = 0, in_plane = 0;
        pieces.for_each_on_side(0, i, [&](std::span<const Vec3d> points, double slack) {
            for (const Vec3d& p : points) {
                off = std::max(off, face.side_distance(p, i) + slack);
                in_plane = std::max(in_plane, face.side_distance_in_plane(p, i) + slack);
            }
        });
        backward = std::max(backward, in_plane + off);
    }
    return std::max(forward, backward) + face.height();
}

double bound_end(const DualFacePieces& pieces) {
    // The vertices of the two sides of the crease are the same.
    const Vec3d a = pieces.corners()[0].position, b = pieces.corners()[1].position;
    double error = 0;
    pieces.for_each_hull(0, [&](std::span<const Vec3d> points, double slack) {
        for (const Vec3d& p : points) error = std::max(error, segment_distance(p, a, b) + slack);
    });
    return error;
}

}  // namespace

void bound_dual_face(const DualSurface& surface, const DualFacePieces& pieces, bool end, std::span<double> of_corner) {
    std::fill(of_corner.begin(), of_corner.end(), 0.0);
    int coarsest = k_max_level;
    for (const DualFacePieces::Corner& c : pieces.corners()) {
        coarsest = std::min<int>(coarsest, c.cell.level);
        if (c.cell.level > DualSurface::k_deepest_leaf)
            return std::fill(of_corner.begin(), of_corner.end(), k_unbounded);
    }
    if (pieces.plane()) {
        for (std::size_t t = 0; t < pieces.piece_count(); ++t) bound_triangle(surface, pieces, t, of_corner);
        return;
    }
    const double error = end ? bound_end(pieces) : bound_whole(pieces);
    for (std::size_t i = 0; i < of_corner.size(); ++i)
        if (pieces.corners()[i].cell.level == coarsest) of_corner[i] = error;
}

}  // namespace tetrakis::detail
