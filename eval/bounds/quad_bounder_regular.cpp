#include "bezier_pieces.hpp"
#include "quad_bounder.hpp"

#include <algorithm>

// Pieces of regular cells: triangles over bicubic patches.

namespace tetrakis {

using detail::WalkCell;

namespace {

/// The half (right angle at corner `turn`) or quarter (at the centre, beside the side from corner `turn`) of a cell,
/// the longest side first.
std::array<Vec2d, 3> piece_corners(bool quarter, int turn) {
    const auto corner = [](int i) { return Vec2d(detail::k_corner_x[i & 3], detail::k_corner_y[i & 3]); };
    if (quarter) return {corner(turn), corner(turn + 1), Vec2d(0.5)};
    return {corner(turn + 1), corner(turn + 3), corner(turn)};
}

const detail::SexticWeights& piece_weights(bool quarter, int turn) {
    static const auto table = [] {
        std::array<std::array<detail::SexticWeights, 4>, 2> weights;
        for (int i = 0; i < 8; ++i)
            weights[static_cast<std::size_t>(i / 4)][static_cast<std::size_t>(i % 4)] =
                detail::sextic_weights(piece_corners(i / 4 == 1, i % 4));
        return weights;
    }();
    return table[quarter][static_cast<std::size_t>(turn)];
}

}  // namespace

void QuadBounder::bound_regular(const WalkCell& cell, const Piece& piece, const Corners& corners) {
    const auto& L = corners.linear;
    const auto& E = piece.edge;
    const Part part{piece_corners(piece.quarter, piece.turn), {L[1], L[2], L[0]}, {E[1], E[2], E[0]}};
    if (cell.crease)
        bound_strips(cell, part);
    else
        bound_part(*cell.net, part, piece_weights(piece.quarter, piece.turn));
}

void QuadBounder::bound_part(const detail::Net16& net, const Part& part, const detail::SexticWeights& weights) {
    using Patch = detail::BezierTriangle<6>;
    Patch patch = detail::bicubic_over(net, weights);
    if (distance_) {
        for (Vec3d& p : patch.point) p = face_.local(p);
    } else {
        for (int j = 0; j <= 6; ++j)
            for (int i = 0; i + j <= 6; ++i)
                patch.point[Patch::index(i, j)] -=
                    (1.0 / 6) *
                    ((6.0 - i - j) * part.linear[0] + double(i) * part.linear[1] + double(j) * part.linear[2]);
    }
    bound_patch(patch, part.edge);
}

/// A cell with a crease of finite sharpness: strips along the crease, each one bicubic patch.
void QuadBounder::bound_strips(const WalkCell& cell, const Part& part) {
    const int axis = cell.crease.side == 0 || cell.crease.side == 2 ? 1 : 0;  // across the crease
    const bool far = cell.crease.side == 1 || cell.crease.side == 2;
    struct Corner {
        Vec2d at;
        Vec3d linear;
        int edge;         ///< to the next corner
        double distance;  ///< from the crease
    };
    constexpr std::size_t k_most = 5;  // corners of a triangle cut by two parallel lines
    using Polygon = std::array<Corner, k_most + 1>;
    Polygon whole;
    for (std::size_t i = 0; i < 3; ++i)
        whole[i] = {part.at[i], part.linear[i], part.edge[i], far ? 1 - part.at[i][axis] : part.at[i][axis]};
    // Keeps what lies on the one side (sign 1: at least) of the line at a distance from the crease.
    const auto clip = [](const Polygon& in, std::size_t count, double line, double sign, Polygon& out) {
        std::size_t kept = 0;
        for (std::size_t i = 0; i < count; ++i) {
            const Corner &a = in[i], &b = in[(i + 1) % count];
            const double da = sign * (a.distance - line), db = sign * (b.distance - line);
            if (da >= 0) {
                out[kept] = a;
                if (da == 0 && db < 0) out[kept].edge = -1;
                ++kept;
            }
            if ((da > 0 && db < 0) || (da < 0 && db > 0)) {
                const double t = da / (da - db);
                out[kept++] = {(1 - t) * a.at + t * b.at, (1 - t) * a.linear + t * b.linear, da > 0 ? -1 : a.edge,
                               line};
            }
        }
        return kept;
    };
    std::array<detail::CreaseStrip, 3> strips;
    const auto strip_count = static_cast<std::size_t>(crease_strips(*cell.net, cell.crease, strips));
    for (const detail::CreaseStrip& strip : std::span(strips).first(strip_count)) {
        Polygon near, both;
        const std::size_t count = clip(near, clip(whole, 3, strip.begin, 1, near), strip.end, -1, both);
        if (count < 3) continue;
        for (std::size_t i = 0; i < count; ++i) {
            const double distance = (both[i].distance - strip.origin) / strip.span;
            both[i].at[axis] = far ? 1 - distance : distance;
        }
        for (std::size_t i = 1; i + 1 < count && !rejected_; ++i) {
            const Part triangle{{both[0].at, both[i].at, both[i + 1].at},
                                {both[0].linear, both[i].linear, both[i + 1].linear},
                                {i == 1 ? both[0].edge : -1, both[i].edge, i + 2 == count ? both[i + 1].edge : -1}};
            bound_part(strip.net, triangle, detail::sextic_weights(triangle.at));
        }
    }
}

}  // namespace tetrakis
