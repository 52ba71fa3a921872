#include "loop_bounder.hpp"

#include "../surface/local_frame.hpp"
#include "bezier_pieces.hpp"
#include "star_norms.hpp"

#include <algorithm>
#include <cmath>

namespace tetrakis {

using detail::Bary;
using detail::LoopNode;

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

std::array<Bary, 3> corners_of(const CellTriangle& leaf) {
    const double unit = std::ldexp(1.0, -leaf.level);
    std::array<Bary, 3> at;
    for (std::size_t k = 0; k < 3; ++k) {
        const double x = leaf.corner[k].x * unit, y = leaf.corner[k].y * unit;
        at[k] = {1 - x - y, x, y};
    }
    return at;
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

const LoopNode& LoopBounder::locate(HalfedgeId root, Corners& at) const {
    const LoopNode* cell = &patches_.root_node(root);
    const auto all_in = [&](std::size_t k, double sign) {
        return std::ranges::all_of(at, [&](const Bary& b) { return sign * (b[k] - 0.5) >= 0; });
    };
    while (cell->kind != LoopNode::Kind::regular) {
        // The quarter that holds all three corners, if there is one.
        int quarter = all_in(0, -1) && all_in(1, -1) && all_in(2, -1) ? 3 : -1;
        for (int k = 0; k < 3 && quarter < 0; ++k)
            if (all_in(static_cast<std::size_t>(k), 1)) quarter = k;
        if (quarter < 0) break;
        for (Bary& b : at) b = detail::in_quarter(b, quarter);
        cell = cell->grown() + quarter;
    }
    return *cell;
}

LeafError LoopBounder::leaf_error(const CellTriangle& leaf, double decide_at, const EdgeSliding& sliding,
                                  bool may_reject) {
    start(decide_at, may_reject);
    return error_over(leaf.root, corners_of(leaf), sliding);
}

LeafError LoopBounder::part_error(HalfedgeId root, const std::array<Vec2d, 3>& corners, double decide_at) {
    start(decide_at, false);
    Corners at;
    for (std::size_t k = 0; k < 3; ++k) at[k] = detail::LoopShape::point(corners[k].x, corners[k].y);
    return error_over(root, at, {});
}

LeafError LoopBounder::error_over(HalfedgeId root, const Corners& at, const EdgeSliding& sliding) {
    Piece piece{at, {0, 1, 2}};
    const LoopNode& cell = locate(root, piece.at);
    // |S - L| first: it is never smaller than the distance, and known for all triangles of a cell.
    const double size = cell.kind == LoopNode::Kind::regular ? relative_size(piece.at) : 0;
    if (size > 0 && settled(size * size * detail::linear_deviation(cell.patch) + pad_)) return finish();
    std::array<Vec3d, 3> corner;
    for (std::size_t i = 0; i < 3; ++i) corner[i] = LoopPatches::position(cell, piece.at[i]);
    set_face(detail::TriangleDistance(corner, sliding));
    bound_cell(cell, piece, k_max_refinement);
    return finish();
}

void LoopBounder::bound_cell(const LoopNode& cell, const Piece& piece, int depth) {
    if (rejected_) return;
    if (cell.kind == LoopNode::Kind::regular) {
        if (settled(detail::linear_deviation(cell.patch) + corner_error_in(cell, piece) + pad_)) return;
        return bound_surface(detail::box_spline_triangle(cell.patch).over(piece.at), piece.edge);
    }
    const auto error = [&](bool may_split) { return irregular_error(cell, piece, may_split); };
    if (!needs_split(depth, error)) return;
    for (const int quarter : {3, 2, 1, 0})  // the irregular one of a star last
        in_quarter(piece, static_cast<std::size_t>(quarter)).for_each_triangle([&](Piece part) {
            for (Bary& b : part.at) b = detail::in_quarter(b, quarter);
            bound_cell(cell.grown()[quarter], part, depth - 1);
        });
}

double LoopBounder::irregular_error(const LoopNode& cell, const Piece& piece, bool may_split) const {
    if (cell.kind != LoopNode::Kind::star) return hull_error(cell.rings->points(), piece.edge, may_split);
    const detail::LoopStar& star = *cell.star;
    const detail::StarNorms* norms = detail::StarNorms::of(star);
    if (!norms) return hull_error(star.points, piece.edge, may_split);
    return norms->deviation(star.points) + corner_error_in(cell, piece);
}

double LoopBounder::corner_error_in(const LoopNode& cell, const Piece& piece) const {
    const std::array<Vec3d, 3> of_cell{cell.corner(0), cell.corner(1), cell.corner(2)};
    std::array<Vec3d, 3> corner;
    for (std::size_t k = 0; k < 3; ++k) {
        const Bary& b = piece.at[k];
        corner[k] = face_.local(b[0] * of_cell[0] + b[1] * of_cell[1] + b[2] * of_cell[2]);
    }
    return corner_error(corner, piece.edge);
}

}  // namespace tetrakis
