#include "loop_bounder.hpp"

#include "../surface/local_frame.hpp"
#include "bezier_pieces.hpp"
#include "labelled_polygon.hpp"
#include "star_norms.hpp"

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

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

/// A point of a cell.
struct CellPoint {
    Bary at;
    Vec3d linear;  ///< L there
};
CellPoint mix(const CellPoint& a, const CellPoint& b, double t) {
    return {detail::mix(a.at, b.at, t), a.linear + t * (b.linear - a.linear)};
}

/// What a quarter of the cell has of a polygon.
detail::LabelledPolygon<CellPoint> in_quarter(const detail::LabelledPolygon<CellPoint>& whole, std::size_t quarter) {
    const auto half = [&](std::size_t k, double sign) {
        return [k, sign](const CellPoint& p) { return sign * (p.at[k] - 0.5); };
    };
    if (quarter < 3) return whole.clipped(half(quarter, 1));
    return whole.clipped(half(0, -1)).clipped(half(1, -1)).clipped(half(2, -1));
}

/// How far the linear interpolant of a cell's corners is from that of a piece's corners at most, over the piece.
double between(const std::array<Vec3d, 3>& cell, const std::array<Bary, 3>& at, const std::array<Vec3d, 3>& piece) {
    double most = 0;
    for (std::size_t k = 0; k < 3; ++k)
        most = std::max(most, glm::length(at[k][0] * cell[0] + at[k][1] * cell[1] + at[k][2] * cell[2] - piece[k]));
    return most;
}

/// Box spline weights for the positions of a barycentric lattice: samples stand on few points.
class LatticeWeights {
  public:
    static Vec3d position(const detail::Net12& net, const Bary& at) {
        static const LatticeWeights lattice;
        const double x = at[0] * k_side, y = at[1] * k_side;
        const int i = static_cast<int>(x), j = static_cast<int>(y);
        if (i != x || j != y) return detail::box_spline_position(net, at);
        const std::array<double, 12>& weights = lattice.weights_[number(i, j)];
        Vec3d sum = weights[0] * net[0];
        for (std::size_t k = 1; k < 12; ++k) sum += weights[k] * net[k];
        return sum;
    }

  private:
    /// Intervals a side: lattices of 4 on a patch, its quarters, and their quarters.
    static constexpr int k_side = 16;
    LatticeWeights() {
        constexpr double step = 1.0 / k_side;
        for (int i = 0; i <= k_side; ++i)
            for (int j = 0; i + j <= k_side; ++j)
                weights_[number(i, j)] = detail::box_spline_weights({i * step, j * step, (k_side - i - j) * step});
    }
    static std::size_t number(int i, int j) { return static_cast<std::size_t>(i * (k_side + 1) + j); }
    std::array<std::array<double, 12>, (k_side + 1) * (k_side + 1)> weights_;
};

}  // namespace

LoopBounder::LoopBounder(const LoopPatches& patches)
    : PatchBounder(detail::surface_rounding(patches.mesh())), patches_(patches), way_(1) {}

LoopBounder::Level& LoopBounder::locate(const CellTriangle& leaf, Corners& at) {
    if (leaf.root != root_ || known_ == 0) {
        root_ = leaf.root;
        patches_.root_cell(leaf.root, way_[0].cell);
        way_[0].has_patch = false;
        known_ = 1;
    }
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
    turn(way_[0].cell.turn);
    int depth = 0;
    while (way_[depth].cell.kind != LoopCell::Kind::regular && size > 1) {
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
        ++depth;
        if (static_cast<std::size_t>(depth) == way_.size()) way_.emplace_back();
        Level& level = way_[depth];
        if (depth >= known_ || level.quarter != quarter) {
            patches_.child(way_[depth - 1].cell, quarter, level.cell);
            level.quarter = quarter;
            level.has_patch = false;
            known_ = depth + 1;
        }
        turn(level.cell.turn);
    }
    const double scale = 1.0 / static_cast<double>(size);
    for (int i = 0; i < 3; ++i)
        at[i] = {static_cast<double>(p[i][0]) * scale, static_cast<double>(p[i][1]) * scale,
                 static_cast<double>(p[i][2]) * scale};
    return way_[depth];
}

Vec3d LoopBounder::position(const LoopCell& cell, const Bary& at) const {
    const int corner = corner_at(at);
    return corner >= 0 ? patches_.corner(cell, corner) : patches_.position(cell, at);
}

LeafError LoopBounder::leaf_error(const CellTriangle& leaf, double decide_at, const EdgeSliding& sliding,
                                  bool may_reject) {
    start(decide_at, may_reject);
    Piece piece{{}, {}, {0, 1, 2}};
    Level& level = locate(leaf, piece.at);
    return error_in(level, piece, sliding);
}

LeafError LoopBounder::part_error(HalfedgeId root, const std::array<Vec2d, 3>& corners, double decide_at) {
    start(decide_at, false);
    Piece piece{{}, {}, {0, 1, 2}};
    Level& level = locate({root, 0, {LatticePoint{0, 0}, {1, 0}, {0, 1}}}, piece.at);
    for (std::size_t i = 0; i < 3; ++i) {
        const Vec2d& p = corners[i];
        piece.at[i] = detail::turned({1 - p.x - p.y, p.x, p.y}, level.cell.turn);
    }
    return error_in(level, piece, {});
}

LeafError LoopBounder::error_in(Level& level, Piece& piece, const EdgeSliding& sliding) {
    std::array<Vec3d, 3>& corner = piece.linear;
    if (level.cell.kind != LoopCell::Kind::regular) {
        for (std::size_t i = 0; i < 3; ++i) corner[i] = position(level.cell, piece.at[i]);
        set_face(detail::TriangleDistance(corner, sliding));
        bound_cell(level.cell, piece, k_max_refinement);
        return finish();
    }
    if (!level.has_patch) {
        level.patch = detail::box_spline_triangle(level.cell.net);
        level.linear_deviation = detail::linear_deviation(level.cell.net);
        level.has_patch = true;
    }
    // S - L first: it is never smaller than the distance, and known for all triangles of a cell.
    const double size = relative_size(piece.at);
    if (size > 0 && settled(size * size * level.linear_deviation + pad_)) return finish();
    for (std::size_t i = 0; i < 3; ++i) corner[i] = LatticeWeights::position(level.cell.net, piece.at[i]);
    set_face(detail::TriangleDistance(corner, sliding));
    bound_regular(level.patch, piece);
    return finish();
}

void LoopBounder::bound_regular(const Patch& cell, const Piece& piece) {
    Patch patch = cell.over(piece.at);
    for (Vec3d& p : patch.point) p = face_.local(p);
    bound_patch(patch, piece.edge);
}

void LoopBounder::bound_cell(const LoopCell& cell, const Piece& piece, int depth) {
    if (rejected_) return;
    if (cell.kind == LoopCell::Kind::regular) {
        // No error is larger than |S - L|.
        const std::array<Vec3d, 3> corner{detail::box_spline_corner(cell.net, 0),
                                          detail::box_spline_corner(cell.net, 1),
                                          detail::box_spline_corner(cell.net, 2)};
        if (settled(detail::linear_deviation(cell.net) + between(corner, piece.at, piece.linear) + pad_)) return;
        return bound_regular(detail::box_spline_triangle(cell.net), piece);
    }
    if (cell.kind != LoopCell::Kind::split) {
        const bool may_split = depth > 0 && !exhausted();
        const double upper = irregular_error(cell, piece, may_split) + pad_;
        if (settled(upper)) return;
        if (!may_split) return give_up(upper);
    }
    ++splits_;
    const detail::LabelledPolygon<CellPoint> whole(
        {{{piece.at[0], piece.linear[0]}, {piece.at[1], piece.linear[1]}, {piece.at[2], piece.linear[2]}}}, piece.edge);
    for (const int quarter : {3, 2, 1, 0}) {  // the irregular one of a star last
        const auto part = in_quarter(whole, static_cast<std::size_t>(quarter));
        if (part.empty()) continue;
        LoopCell child;
        patches_.child(cell, quarter, child);
        part.for_each_triangle([&](const std::array<CellPoint, 3>& corners, const Edges& edge) {
            Piece inside;
            inside.edge = edge;
            for (std::size_t k = 0; k < 3; ++k) {
                inside.at[k] = detail::turned(detail::in_quarter(corners[k].at, quarter), child.turn);
                inside.linear[k] = corners[k].linear;
            }
            bound_cell(child, inside, depth - 1);
        });
    }
}

double LoopBounder::irregular_error(const LoopCell& cell, const Piece& piece, bool may_split) const {
    if (cell.kind == LoopCell::Kind::star) {
        const int valence = cell.star->valence();
        const Vec3d* points = cell.star->points();
        if (const detail::StarNorms* norms = detail::StarNorms::loop(valence)) {
            const std::array<Vec3d, 3> corner{patches_.corner(cell, 0), patches_.corner(cell, 1),
                                              patches_.corner(cell, 2)};
            return norms->deviation({points, static_cast<std::size_t>(detail::loop_star_size(valence))}, 0) +
                   between(corner, piece.at, piece.linear);
        }
    }
    return hull_error(cell, piece.edge, may_split);
}

double LoopBounder::hull_error(const LoopCell& cell, const Edges& edge, bool may_split) const {
    double error = 0;
    const auto look = [&](std::span<const Vec3d> points) {
        for (const Vec3d& p : points) {
            const Vec3d local = face_.local(p);
            error = std::max(error, node_error(local, -1));
            for (const int e : edge)
                if (e >= 0) error = std::max(error, node_error(local, e));
            if (may_split && !is_settled(error + pad_)) return;
        }
    };
    if (cell.kind == LoopCell::Kind::star)
        look({cell.star->points(), static_cast<std::size_t>(detail::loop_star_size(cell.star->valence()))});
    else
        look(cell.node->rings().points());
    return error;
}

QuickError LoopBounder::quick_error(const CellTriangle& leaf) {
    QuickError quick;
    std::array<Vec3d, 6> s;
    sample(leaf, 2, s);
    quick.corners = {s[3], s[5], s[0]};
    for (const Vec3d& m : {s[4] - 0.5 * (s[3] + s[5]), s[1] - 0.5 * (s[3] + s[0]), s[2] - 0.5 * (s[5] + s[0])})
        if (glm::dot(m, m) > glm::dot(quick.middle, quick.middle)) quick.middle = m;
    return quick;
}

void LoopBounder::sample(const CellTriangle& leaf, int n, std::span<Vec3d> positions) {
    Corners at;
    const LoopCell& cell = locate(leaf, at).cell;
    const bool is_regular = cell.kind == LoopCell::Kind::regular;
    std::array<LoopCell, 4> quarters;  // of an irregular cell, as they are met
    std::array<bool, 4> is_known{};
    const auto position = [&](const Bary& b) {
        if (is_regular) return LatticeWeights::position(cell.net, b);
        if (const int corner = corner_at(b); corner >= 0) return patches_.corner(cell, corner);
        const int quarter = detail::quarter_of(b);
        LoopCell& child = quarters[static_cast<std::size_t>(quarter)];
        if (!std::exchange(is_known[static_cast<std::size_t>(quarter)], true)) patches_.child(cell, quarter, child);
        const Bary inside = detail::turned(detail::in_quarter(b, quarter), child.turn);
        return child.kind == LoopCell::Kind::regular ? LatticeWeights::position(child.net, inside)
                                                     : this->position(child, inside);
    };
    const double step = 1.0 / n;
    std::size_t out = 0;
    for (int row = 0; row <= n; ++row)  // distance from corner 2
        for (int i = 0; i <= row; ++i) {
            const double b0 = (row - i) * step, b1 = i * step, b2 = (n - row) * step;
            Bary b;
            for (std::size_t c = 0; c < 3; ++c) b[c] = b0 * at[0][c] + b1 * at[1][c] + b2 * at[2][c];
            positions[out++] = position(b);
        }
}

}  // namespace tetrakis
