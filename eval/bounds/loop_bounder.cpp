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

const LoopNode& LoopBounder::locate(const CellTriangle& leaf, Corners& at) const {
    const LoopNode* cell = &patches_.root_node(leaf.root);
    std::int64_t size = std::int64_t{1} << leaf.level;
    std::array<std::array<std::int64_t, 3>, 3> p;
    for (int i = 0; i < 3; ++i) {
        const std::int64_t x = leaf.corner[i].x, y = leaf.corner[i].y;
        p[i] = {size - x - y, x, y};
    }
    while (cell->kind != LoopNode::Kind::regular && size > 1) {
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
        cell = cell->grown() + quarter;
    }
    const double scale = 1.0 / static_cast<double>(size);
    for (int i = 0; i < 3; ++i)
        at[i] = {static_cast<double>(p[i][0]) * scale, static_cast<double>(p[i][1]) * scale,
                 static_cast<double>(p[i][2]) * scale};
    return *cell;
}

LeafError LoopBounder::leaf_error(const CellTriangle& leaf, double decide_at, const EdgeSliding& sliding,
                                  bool may_reject) {
    start(decide_at, may_reject);
    Piece piece{{}, {0, 1, 2}};
    const LoopNode& cell = locate(leaf, piece.at);
    return error_in(cell, piece, sliding);
}

LeafError LoopBounder::part_error(HalfedgeId root, const std::array<Vec2d, 3>& corners, double decide_at) {
    start(decide_at, false);
    Piece piece{{}, {0, 1, 2}};
    for (std::size_t i = 0; i < 3; ++i) piece.at[i] = detail::LoopShape::point(corners[i].x, corners[i].y);
    return error_in(patches_.root_node(root), piece, {});
}

LeafError LoopBounder::error_in(const LoopNode& cell, const Piece& piece, const EdgeSliding& sliding) {
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
    const detail::LabelledPolygon<Bary> whole(piece.at, piece.edge);
    for (const int quarter : {3, 2, 1, 0}) {  // the irregular one of a star last
        const auto part = in_quarter(whole, static_cast<std::size_t>(quarter));
        if (part.empty()) continue;
        part.for_each_triangle([&](Corners at, const Edges& edge) {
            for (Bary& b : at) b = detail::in_quarter(b, quarter);
            bound_cell(cell.grown()[quarter], {at, edge}, depth - 1);
        });
    }
}

double LoopBounder::irregular_error(const LoopNode& cell, const Piece& piece, bool may_split) const {
    if (cell.kind != LoopNode::Kind::star) return hull_error(cell.rings->points(), piece.edge, may_split);
    const detail::LoopStar& star = *cell.star;
    const detail::StarNorms* norms =
        star.is_extraordinary(1) || star.is_extraordinary(2) ? nullptr : detail::StarNorms::loop(star.valence[0]);
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

void LoopBounder::sample(const CellTriangle& leaf, int n, std::span<Vec3d> positions) {
    Corners at;
    const LoopNode& cell = locate(leaf, at);
    detail::for_each_lattice_point(n, [&](int i, double b0, double b1, double b2) {
        Bary b;
        for (std::size_t c = 0; c < 3; ++c) b[c] = b0 * at[0][c] + b1 * at[1][c] + b2 * at[2][c];
        positions[static_cast<std::size_t>(i)] = LoopPatches::position(cell, b);
    });
}

}  // namespace tetrakis
