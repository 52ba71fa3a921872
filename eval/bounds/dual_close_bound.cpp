#include "dual_close_bound.hpp"

#include "convex_face.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace tetrakis::detail {

namespace {

// Planes that meet at a sharper angle are not looked at together.
constexpr double k_least_cosine = 0.3;
// A side's ends lie on the line itself, but for rounding: a share of its length.
constexpr double k_on_line = 1e-11;

ConvexFace flat_piece(const DualFacePieces& pieces, std::size_t piece) {
    std::vector<Vec3d> position;
    for (std::size_t i = 0; i < pieces.side_count(piece); ++i)
        position.push_back(pieces.corners()[pieces.corner(piece, i)].position);
    return ConvexFace(position);
}

/// Both together in the plane of the first; where they are no convex polygon, with the part of the other near the side.
ConvexFace joined(const ConvexFace& flat, std::size_t side, const ConvexFace& other, std::size_t other_side) {
    const std::size_t n = flat.corners().size(), m = other.corners().size();
    const Vec3d middle = 0.5 * (flat.corners()[side] + flat.corners()[(side + 1) % n]);
    std::vector<Vec3d> corners;
    for (const double share : {1.0, 0.5, 0.25}) {
        corners.clear();
        for (std::size_t i = 0; i < n; ++i) {
            corners.push_back(flat.corners()[i]);
            if (i != side) continue;
            for (std::size_t k = 2; k < m; ++k) {
                const Vec3d& p = other.corners()[(other_side + k) % m];
                corners.push_back(middle + share * (p - flat.above(p) * flat.normal() - middle));
            }
        }
        if (ConvexFace both(corners); both.convex()) return both;
    }
    return ConvexFace(corners);
}

}  // namespace

/// What a piece's neighbour across a side adds.
struct DualCloseBound::Neighbour {
    ConvexFace both;
    double back;        ///< heights of its surface above points of the piece
    double rise;        ///< of its plane beyond the line, by the distance from there
    double apart;       ///< what the two lines differ, as an error
    double apart_line;  ///< in the plane
};

std::optional<DualCloseBound::Neighbour> DualCloseBound::neighbour(const ConvexFace& flat,
                                                                   const DualLinks::Side& side) const {
    const auto beyond = links_.across(side);
    if (!beyond || beyond->face >= net_.face_count) return std::nullopt;
    const DualFacePieces pieces(surface_, forest_, net_, positions_, beyond->face);
    const ConvexFace other = flat_piece(pieces, beyond->piece);
    if (!other.convex() || glm::dot(flat.normal(), other.normal()) < k_least_cosine) return std::nullopt;
    const std::size_t n = other.corners().size();
    const Vec3d a = other.corners()[beyond->side], b = other.corners()[(beyond->side + 1) % n];
    const Vec3d own = flat.corners()[side.side], inward = flat.inward(side.side);
    const Vec3d away = other.inward(beyond->side);
    const double cosine = -glm::dot(inward, away), sine = std::abs(glm::dot(flat.normal(), away));
    const double length = glm::length(b - a);
    if (!(cosine > k_least_cosine) || !(length > 0)) return std::nullopt;

    bool outside = true;
    for (std::size_t k = 0; k < n && outside; ++k)
        if (k != beyond->side)
            pieces.for_each_on_side(beyond->piece, k, [&](std::span<const Vec3d> points, double slack) {
                for (const Vec3d& p : points)
                    outside = outside && glm::dot(p - own, inward) + slack <= k_on_line * length;
            });
    if (!outside) return std::nullopt;

    double height = 0, over = 0, reach = 0;
    const Vec3d middle = 0.5 * (a + b), along = (b - a) / length;
    pieces.for_each_hull(beyond->piece, [&](std::span<const Vec3d> points, double slack) {
        for (const Vec3d& p : points) {
            height = std::max(height, std::abs(other.above(p)) + slack);
            over = std::max(over, -glm::dot(p - a, away) + slack);
            reach = std::max(reach, std::abs(glm::dot(p - middle, along)) + slack);
        }
    });
    for (const Vec3d& p : other.corners()) reach = std::max(reach, std::abs(glm::dot(p - middle, along)));
    // What is linear along the side is no more than so many times what it is at the ends.
    const double grown = std::max(1.0, reach / (0.5 * length));
    const double apart_high = grown * std::max(std::abs(flat.above(a)), std::abs(flat.above(b)));
    const double apart_line =
        grown * std::max(std::abs(glm::dot(a - own, inward)), std::abs(glm::dot(b - own, inward)));
    const double sine_of_planes = glm::length(glm::cross(flat.normal(), other.normal()));
    const double past = (apart_line + height * sine_of_planes) / cosine;
    return Neighbour{joined(flat, side.side, other, beyond->side),
                     height + apart_high + sine * std::max(over, past) + k_on_line * length, sine / cosine,
                     apart_high + apart_line + other.height(), apart_line};
}

double DualCloseBound::part_error(const ConvexFace& flat, std::span<const std::optional<Neighbour>> beside,
                                  std::span<const Vec3d> points, double slack, double enough) {
    double least = 0;
    for (const Vec3d& p : points) least = std::max(least, flat.distance(p) + slack);
    for (std::size_t i = 0; i < beside.size() && least > enough; ++i) {
        if (!beside[i] || !beside[i]->both.convex()) continue;
        const Vec3d inward = flat.inward(i), own = flat.corners()[i];
        double off = 0, beyond = 0;
        for (const Vec3d& p : points) {
            off = std::max(off, beside[i]->both.distance(p) + slack);
            beyond = std::max(beyond, -glm::dot(p - own, inward) + slack);
        }
        least = std::min(least, off + beside[i]->rise * (beyond + off + beside[i]->apart_line) + beside[i]->apart);
    }
    return least;
}

double DualCloseBound::side_error(const ConvexFace& flat, const DualFacePieces& pieces, std::size_t piece,
                                  std::size_t side) {
    const Vec3d inward = flat.inward(side), own = flat.corners()[side];
    const double on_line = k_on_line * glm::length(flat.corners()[(side + 1) % flat.corners().size()] - own);
    double off = 0, in_plane = 0;
    pieces.for_each_on_side(piece, side, [&](std::span<const Vec3d> points, double slack) {
        double inner = 0, from_side = 0;
        for (const Vec3d& p : points) {
            inner = std::max(inner, glm::dot(p - own, inward) + slack);
            from_side = std::max(from_side, flat.side_distance_in_plane(p, side) + slack);
            off = std::max(off, flat.side_distance(p, side) + slack);
        }
        in_plane = std::max(in_plane, inner > on_line ? from_side : on_line);
    });
    return in_plane > on_line ? in_plane + off : on_line;
}

double DualCloseBound::piece_error(std::uint32_t face, const DualFacePieces& pieces, std::uint32_t piece,
                                   double give_up_at) const {
    const ConvexFace flat = flat_piece(pieces, piece);
    if (!flat.convex()) return std::numeric_limits<double>::infinity();
    double high = 0, forward = 0;
    pieces.for_each_hull(piece, [&](std::span<const Vec3d> points, double slack) {
        for (const Vec3d& p : points) {
            high = std::max(high, std::abs(flat.above(p)) + slack);
            forward = std::max(forward, flat.distance(p) + slack);
        }
    });
    // No neighbour makes it better than that.
    if (high + flat.height() > give_up_at) return high + flat.height();
    const std::size_t sides = flat.corners().size();
    std::vector<std::optional<Neighbour>> beside;
    double error = high;
    for (std::uint32_t i = 0; i < sides; ++i) {
        beside.push_back(neighbour(flat, {face, piece, i}));
        if (beside.back()) {
            error = std::max(error, beside.back()->back);
            continue;
        }
        error = std::max(error, side_error(flat, pieces, piece, i));
    }
    if (forward > error)
        pieces.for_each_hull(piece, [&](std::span<const Vec3d> points, double slack) {
            error = std::max(error, part_error(flat, beside, points, slack, error));
        });
    return error + flat.height();
}

double DualCloseBound::operator()(std::uint32_t face, const DualFacePieces& pieces, double give_up_at) const {
    double error = 0;
    for (std::uint32_t p = 0; p < pieces.piece_count(); ++p)
        error = std::max(error, piece_error(face, pieces, p, give_up_at));
    return error;
}

}  // namespace tetrakis::detail
