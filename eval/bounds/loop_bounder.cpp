#include "loop_bounder.hpp"

#include "../surface/local_frame.hpp"
#include "bezier_pieces.hpp"
#include "labelled_polygon.hpp"
#include "star_norms.hpp"

#include <algorithm>
#include <cmath>
#include <span>

namespace tetrakis {

using detail::Bary;
using detail::corner_at;
using detail::LoopCell;

namespace {

/// Cells are quartered at most this many levels below the leaf; those that are still irregular then are bounded by
/// their hull.
constexpr int k_max_refinement = 40;

/// Size of a triangle whose sides are parallel to its cell's, relative to it; 0 for any other one.
double relative_size(const std::array<Bary, 3>& at) {
    for (std::size_t p = 0; p < 3; ++p) {
        const std::size_t p1 = (p + 1) % 3, p2 = (p + 2) % 3;
        if (at[0][p2] == at[1][p2] && at[1][p] == at[2][p] && at[2][p1] == at[0][p1])
            return std::abs(at[1][p] - at[0][p]);
    }
    return 0;
}

/// What a quarter of the cell has of a polygon.
detail::LabelledPolygon<Bary> in_quarter(const detail::LabelledPolygon<Bary>& whole, std::size_t quarter) {
    const auto half = [&](std::size_t k, double sign) {
        return [k, sign](const Bary& p) { return sign * (p[k] - 0.5); };
    };
    if (quarter < 3) return whole.clipped(half(quarter, 1));
    return whole.clipped(half(0, -1)).clipped(half(1, -1)).clipped(half(2, -1));
}

}  // namespace

LoopBounder::LoopBounder(const LoopPatches& patches)
    : PatchBounder(detail::surface_rounding(patches.mesh())), patches_(patches) {}

LoopCell LoopBounder::locate(const CellTriangle& leaf, Corners& at) const {
    LoopCell cell;
    patches_.root_cell(leaf.root, cell);
    std::int64_t size = std::int64_t{1} << leaf.level;
    std::array<std::array<std::int64_t, 3>, 3> p;
    const auto turn = [&](int by) {
        if (by == 0) return;
        for (auto& b : p) std::rotate(b.begin(), b.begin() + by, b.end());
    };
    for (int i = 0; i < 3; ++i) {
        const std::int64_t x = leaf.corner[i].x, y = leaf.corner[i].y;
        p[i] = {size - x - y, x, y};
    }
    turn(cell.turn);
    while (cell.kind != LoopCell::Kind::regular && size > 1) {
        // The quarter that holds all three corners, if there is one.
        const std::int64_t half = size / 2;
        int quarter = -1;
        for (int k = 0; k < 3; ++k)
            if (p[0][k] >= half && p[1][k] >= half && p[2][k] >= half) quarter = k;
        if (quarter < 0) {
            bool in_centre = true;
            for (const auto& b : p) in_centre &= b[0] <= half && b[1] <= half && b[2] <= half;
            if (!in_centre) break;
            quarter = 3;
        }
        for (auto& b : p) {
            if (quarter == 3)
                b = {half - b[0], half - b[1], half - b[2]};
            else
                b[quarter] -= half;
        }
        size = half;
        patches_.child(cell, quarter, cell);
        turn(cell.turn);
    }
    const double scale = 1.0 / static_cast<double>(size);
    for (int i = 0; i < 3; ++i)
        at[i] = {static_cast<double>(p[i][0]) * scale, static_cast<double>(p[i][1]) * scale,
                 static_cast<double>(p[i][2]) * scale};
    return cell;
}

Vec3d LoopBounder::position(const LoopCell& cell, const Bary& at) const {
    const int corner = corner_at(at);
    return corner >= 0 ? patches_.corner(cell, corner) : patches_.position(cell, at);
}

LeafError LoopBounder::leaf_error(const CellTriangle& leaf, double decide_at, const EdgeSliding& sliding,
                                  bool may_reject) {
    start(decide_at, may_reject);
    Piece piece{{}, {0, 1, 2}};
    const LoopCell cell = locate(leaf, piece.at);
    return error_in(cell, piece, sliding);
}

LeafError LoopBounder::part_error(HalfedgeId root, const std::array<Vec2d, 3>& corners, double decide_at) {
    start(decide_at, false);
    Piece piece{{}, {0, 1, 2}};
    LoopCell cell;
    patches_.root_cell(root, cell);
    for (std::size_t i = 0; i < 3; ++i) {
        const Vec2d& p = corners[i];
        piece.at[i] = detail::turned({1 - p.x - p.y, p.x, p.y}, cell.turn);
    }
    return error_in(cell, piece, {});
}

LeafError LoopBounder::error_in(const LoopCell& cell, const Piece& piece, const EdgeSliding& sliding) {
    // |S - L| first: it is never smaller than the distance, and known for all triangles of a cell.
    const double size = cell.kind == LoopCell::Kind::regular ? relative_size(piece.at) : 0;
    if (size > 0 && settled(size * size * detail::linear_deviation(cell.net) + pad_)) return finish();
    std::array<Vec3d, 3> corner;
    for (std::size_t i = 0; i < 3; ++i) corner[i] = position(cell, piece.at[i]);
    set_face(detail::TriangleDistance(corner, sliding));
    bound_cell(cell, piece, k_max_refinement);
    return finish();
}

void LoopBounder::bound_cell(const LoopCell& cell, const Piece& piece, int depth) {
    if (rejected_) return;
    if (cell.kind == LoopCell::Kind::regular) {
        const std::array<Vec3d, 3> corner{detail::box_spline_corner(cell.net, 0),
                                          detail::box_spline_corner(cell.net, 1),
                                          detail::box_spline_corner(cell.net, 2)};
        if (settled(detail::linear_deviation(cell.net) + corner_error_in(corner, piece) + pad_)) return;
        return bound_surface(detail::box_spline_triangle(cell.net).over(piece.at), piece.edge);
    }
    const auto error = [&](bool may_split) { return irregular_error(cell, piece, may_split); };
    if (cell.kind != LoopCell::Kind::split && !needs_split(depth, error)) return;
    const detail::LabelledPolygon<Bary> whole(piece.at, piece.edge);
    for (const int quarter : {3, 2, 1, 0}) {  // the irregular one of a star last
        const auto part = in_quarter(whole, static_cast<std::size_t>(quarter));
        if (part.empty()) continue;
        LoopCell child;
        patches_.child(cell, quarter, child);
        part.for_each_triangle([&](Corners at, const Edges& edge) {
            for (Bary& b : at) b = detail::turned(detail::in_quarter(b, quarter), child.turn);
            bound_cell(child, {at, edge}, depth - 1);
        });
    }
}

double LoopBounder::irregular_error(const LoopCell& cell, const Piece& piece, bool may_split) const {
    if (cell.kind != LoopCell::Kind::star) return hull_error(cell.node->rings().points(), piece.edge, may_split);
    const int valence = cell.star->valence();
    const std::span points(cell.star->points(), static_cast<std::size_t>(detail::loop_star_size(valence)));
    const detail::StarNorms* norms = detail::StarNorms::loop(valence);
    if (!norms) return hull_error(points, piece.edge, may_split);
    return norms->deviation(points) +
           corner_error_in({patches_.corner(cell, 0), patches_.corner(cell, 1), patches_.corner(cell, 2)}, piece);
}

double LoopBounder::corner_error_in(const std::array<Vec3d, 3>& cell, const Piece& piece) const {
    std::array<Vec3d, 3> corner;
    for (std::size_t k = 0; k < 3; ++k) {
        const Bary& b = piece.at[k];
        corner[k] = face_.local(b[0] * cell[0] + b[1] * cell[1] + b[2] * cell[2]);
    }
    return corner_error(corner, piece.edge);
}

QuickError LoopBounder::quick_error(const CellTriangle& leaf) {
    std::array<Vec3d, 6> s;
    sample(leaf, 2, s);
    return QuickError(s);
}

void LoopBounder::sample(const CellTriangle& leaf, int n, std::span<Vec3d> positions) {
    Corners at;
    const LoopCell cell = locate(leaf, at);
    detail::for_each_lattice_point(n, [&](int i, double b0, double b1, double b2) {
        Bary b;
        for (std::size_t c = 0; c < 3; ++c) b[c] = b0 * at[0][c] + b1 * at[1][c] + b2 * at[2][c];
        positions[static_cast<std::size_t>(i)] = position(cell, b);
    });
}

}  // namespace tetrakis
