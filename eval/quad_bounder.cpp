#include "tetrakis/eval/quad_bounder.hpp"

#include <cassert>
#include <limits>

namespace tetrakis {

using detail::Net16;
using detail::QuadNode;
using detail::SecondBounds;
using detail::Weights4;

namespace {

constexpr int k_corner_x[4] = {0, 1, 1, 0};
constexpr int k_corner_y[4] = {0, 0, 1, 1};

/// Rounding of one patch evaluation and one interpolation, in units of the largest coordinate: fewer than 100
/// operations on values not larger than it, each off by half an ulp at most.
constexpr double k_rounding = 128 * std::numeric_limits<double>::epsilon();

/// Pieces are split at most this many levels below the leaf; cells that are still irregular then are bounded by their
/// hull.
/// Leaves reach level 30, and cell numbers must fit 64 bits.
constexpr int k_max_refinement = 32;

/// Finest sample lattice of a regular piece: its bound is then tight to 1 / 64 of the second-derivative bound.
constexpr int k_finest_lattice = 8;

/// Sixteenths of a cell: every lattice of a piece stands on them.
constexpr int k_parts = 16;

/// B-spline weights at sixteenths.
struct PartWeights {
    Weights4 at[k_parts + 1];
    PartWeights() {
        for (int i = 0; i <= k_parts; ++i) at[i] = detail::cubic_basis(static_cast<double>(i) / k_parts);
    }
};
const PartWeights k_part_weights;

/// Positions of a piece's lattice points in sixteenths of its cell: origin + i a + j b for the corners 0, 1, 2.
struct LatticeShape {
    int ox, oy, ax, ay, bx, by, step;
    int x(int i, int j) const { return ox + i * ax + j * bx; }
    int y(int i, int j) const { return oy + i * ay + j * by; }
};

LatticeShape lattice_shape(int turn, bool quarter, int n) {
    const auto cx = [](int k) { return k_parts * k_corner_x[k & 3]; };
    const auto cy = [](int k) { return k_parts * k_corner_y[k & 3]; };
    LatticeShape s;
    int px1, py1, px2, py2;
    if (quarter) {
        s.ox = s.oy = k_parts / 2;
        px1 = cx(turn), py1 = cy(turn), px2 = cx(turn + 1), py2 = cy(turn + 1);
        s.step = k_parts / (2 * n);
    } else {
        s.ox = cx(turn), s.oy = cy(turn);
        px1 = cx(turn + 1), py1 = cy(turn + 1), px2 = cx(turn + 3), py2 = cy(turn + 3);
        s.step = k_parts / n;
    }
    s.ax = (px1 - s.ox) / n, s.ay = (py1 - s.oy) / n, s.bx = (px2 - s.ox) / n, s.by = (py2 - s.oy) / n;
    return s;
}

/// A net evaluated along x at the columns of a lattice: four control points along y are left for each.
struct LatticeColumns {
    double rows[k_parts + 1][3][4];

    void fill(const Net16& net, const LatticeShape& shape) {
        for (int i = 0; i <= k_parts; i += shape.step) {
            const Weights4& w = k_part_weights.at[i];
            for (int k = 0; k < 3; ++k)
                for (int r = 0; r < 4; ++r) {
                    const double* p = net.c[k] + 4 * r;
                    rows[i][k][r] = (w[0] * p[0] + w[1] * p[1]) + (w[2] * p[2] + w[3] * p[3]);
                }
        }
    }
    Vec3d at(int x, int y) const {
        const Weights4& w = k_part_weights.at[y];
        Vec3d result;
        for (int k = 0; k < 3; ++k) {
            const double* p = rows[x][k];
            result[k] = (w[0] * p[0] + w[1] * p[1]) + (w[2] * p[2] + w[3] * p[3]);
        }
        return result;
    }
};

/// Second-derivative bounds of the strips of a single-crease cell: at the crease, and the rest of the cell.
struct CreaseBounds {
    SecondBounds strip, rest;
    double width = 1;  ///< of the strip
    bool across_y = false;

    explicit CreaseBounds(const Net16& net, detail::SideCrease crease) {
        const auto pieces = detail::CreasePieces::make(crease.sharpness);
        across_y = crease.side == 0 || crease.side == 2;
        const bool far = crease.side == 1 || crease.side == 2;
        width = pieces.last_is_whole ? pieces.begin[pieces.count - 1] : 1;
        const int across = across_y ? 4 : 1, along = across_y ? 1 : 4;
        for (int i = 0; i < pieces.count; ++i) {
            Net16 part;
            for (int k = 0; k < 3; ++k)
                for (int row = 0; row < 4; ++row)
                    for (int j = 0; j < 4; ++j) {
                        double sum = 0;
                        for (int q = 0; q < 4; ++q)
                            sum += pieces.control[i][j][static_cast<std::size_t>(q)] *
                                   net.c[k][row * along + (far ? 3 - q : q) * across];
                        part.c[k][row * along + (far ? 3 - j : j) * across] = sum;
                    }
            const bool whole = pieces.whole(i);
            const double scale = whole ? 1 : 1 / (pieces.end[i] - pieces.begin[i]);
            const SecondBounds b = across_y ? SecondBounds::of(part, 1, scale) : SecondBounds::of(part, scale, 1);
            if (whole) {
                rest = b;
            } else if (i == 0) {
                strip = b;
            } else {
                strip2 = b;
                has_strip2 = true;
            }
        }
        if (!pieces.last_is_whole) rest = strip;
    }
    SecondBounds strip2;
    bool has_strip2 = false;

    /// An eighth of an effective second derivative along (a, b): |S''| <= outside everywhere but for a part of the
    /// line, at one of its ends, of relative length w, where it is at most inside: the deviation is then at most
    /// outside / 8 + w^2 / 2 (inside - outside).
    double deviation(double a, double b) const {
        double inside = strip.along(a, b);
        if (has_strip2) inside = std::max(inside, strip2.along(a, b));
        const double outside = width < 1 ? rest.along(a, b) : inside;
        const double reach = std::abs(across_y ? b : a);
        if (reach == 0) return std::max(inside, outside) / 8;
        const double w = std::min(1.0, width / reach);
        // Where the strip may cover most of the line, the plain bound is the better one.
        return std::min(std::max(inside, outside) / 8, outside / 8 + 0.5 * w * w * std::max(0.0, inside - outside));
    }
};

}  // namespace

QuadBounder::QuadBounder(const QuadPatches& patches)
    : patches_(patches), cells_(k_max_level + k_max_refinement + 4), nets_(k_max_level + k_max_refinement + 4) {
    for (const Vec3d& p : patches.mesh().positions())
        scale_ = std::max({scale_, std::abs(p.x), std::abs(p.y), std::abs(p.z)});
}

QuadBounder::Cell& QuadBounder::cell(HalfedgeId root, int level, std::uint64_t x, std::uint64_t y) {
    int from = -1;
    if (root == root_) {
        // The deepest kept cell that holds the wanted one.
        from = std::min(depth_, level);
        while (from > 0) {
            const Cell& kept = cells_[static_cast<std::size_t>(from)];
            if (kept.x == x >> (level - from) && kept.y == y >> (level - from)) break;
            --from;
        }
    }
    if (from < 0) {
        root_ = root;
        Cell& top = cells_[0];
        top = Cell{};
        top.node = &patches_.root_node(root);
        if (top.node->kind == QuadNode::Kind::regular) top.net = &top.node->net, top.crease = top.node->crease;
        from = 0;
    }
    for (int l = from + 1; l <= level; ++l) {
        const Cell& parent = cells_[static_cast<std::size_t>(l - 1)];
        Cell& child = cells_[static_cast<std::size_t>(l)];
        child.x = x >> (level - l), child.y = y >> (level - l);
        child.known = 0;
        child.has_bounds = false;
        const int qx = static_cast<int>(child.x & 1), qy = static_cast<int>(child.y & 1);
        if (parent.irregular()) {
            child.node = parent.node->grown() + 2 * qy + qx;
            const bool regular = child.node->kind == QuadNode::Kind::regular;
            child.net = regular ? &child.node->net : nullptr;
            child.crease = regular ? child.node->crease : detail::SideCrease{};
            if (const detail::CellFacts* facts = child.node->facts.get()) {
                child.corner = facts->corner;
                child.known = 15;
                child.bounds = facts->bounds;
                child.has_bounds = true;
            }
        } else {
            child.node = nullptr;
            Net16& net = nets_[static_cast<std::size_t>(l)];
            if (parent.crease) {
                child_net(*parent.net, parent.crease, qx, qy, net, child.crease);
            } else {
                child_net(*parent.net, qx, qy, net);
                child.crease = {};
            }
            child.net = &net;
        }
    }
    depth_ = level;
    return cells_[static_cast<std::size_t>(level)];
}

Vec3d QuadBounder::cell_point(const Cell& cell, double x, double y) {
    if (cell.irregular()) return QuadPatches::position(*cell.node, x, y);
    return regular_position(*cell.net, cell.crease, x, y);
}

/// A corner of a smooth regular cell: the mask (1, 4, 1) / 6, both ways.
static Vec3d corner_position(const Net16& net, int x, int y) {
    Vec3d result;
    for (int k = 0; k < 3; ++k) {
        const double* p = net.c[k] + 4 * y + x;
        result[k] = ((p[0] + p[2]) + (p[8] + p[10]) + 4 * ((p[1] + p[9]) + (p[4] + p[6])) + 16 * p[5]) / 36;
    }
    return result;
}

Vec3d QuadBounder::cell_corner(Cell& cell, int corner) {
    if (!(cell.known & (1 << corner))) {
        cell.corner[static_cast<std::size_t>(corner)] =
            cell.irregular() || cell.crease ? cell_point(cell, k_corner_x[corner], k_corner_y[corner])
                                            : corner_position(*cell.net, k_corner_x[corner], k_corner_y[corner]);
        cell.known = static_cast<std::uint8_t>(cell.known | (1 << corner));
    }
    return cell.corner[corner];
}

double QuadBounder::deviation(Cell& cell, const Piece& piece) {
    // Directions of the piece's edges in the cell: hypotenuse first.
    double a[3], b[3];
    if (!piece.quarter) {
        a[0] = 1, b[0] = (piece.turn & 1) ? 1 : -1;
        a[1] = 1, b[1] = 0, a[2] = 0, b[2] = 1;
    } else {
        const bool flat = (piece.turn & 1) == 0;
        a[0] = flat, b[0] = !flat;
        a[1] = 0.5, b[1] = 0.5, a[2] = 0.5, b[2] = -0.5;
    }
    if (cell.crease) {
        const CreaseBounds bounds(*cell.net, cell.crease);
        double e[3];
        for (int k = 0; k < 3; ++k) e[k] = bounds.deviation(a[k], b[k]);
        return std::min({std::max(e[1], e[2]) + e[0], std::max(e[0], e[2]) + e[1], std::max(e[0], e[1]) + e[2]});
    }
    if (!cell.has_bounds) {
        cell.bounds = SecondBounds::of(*cell.net);
        cell.has_bounds = true;
    }
    return detail::triangle_deviation(cell.bounds.along(a[0], b[0]), cell.bounds.along(a[1], b[1]),
                                      cell.bounds.along(a[2], b[2]));
}

double QuadBounder::hull_distance(const Cell& cell, const std::array<Vec3d, 3>& linear) {
    double far = 0;
    const auto look = [&](const Vec3d& p) {
        for (const Vec3d& l : linear) far = std::max(far, glm::dot(p - l, p - l));
    };
    if (cell.node->kind == QuadNode::Kind::star) {
        for (const Vec3d& p : cell.node->star->points) look(p);
    } else {
        for (const Vec3d& p : cell.node->local->points) look(p);
    }
    return std::sqrt(far);
}

void QuadBounder::bound(const Piece& piece, const Corners& corners, int depth) {
    if (rejected_) return;
    double attained = 0;
    for (const Vec3d& d : corners.deviation) attained = std::max(attained, glm::dot(d, d));
    attained = std::sqrt(attained);
    lower_ = std::max(lower_, attained);
    if (may_reject_ && lower_ > decide_at_) {
        rejected_ = true;
        return;
    }
    Cell& home = cell(piece.root, piece.level, piece.x, piece.y);
    if (!home.irregular() && !home.crease) {
        bound_regular(home, piece, corners, attained);
        return;
    }
    const double pad = k_rounding * scale_;
    const double upper =
        (home.irregular() ? hull_distance(home, corners.linear) : attained + deviation(home, piece)) + pad;
    if (upper <= decide_at_ || upper <= 1.05 * lower_ + pad || upper <= upper_ || depth == 0) {
        upper_ = std::max(upper_, upper);
        return;
    }
    // Split: the new corners are the midpoints of the edges (of the base alone for a quarter).
    const auto middle = [&](const Vec3d& s, int i, int j, Vec3d& linear, Vec3d& deviation) {
        linear = 0.5 * (corners.linear[static_cast<std::size_t>(i)] + corners.linear[static_cast<std::size_t>(j)]);
        deviation = s - linear;
    };
    const int k = piece.turn, k1 = (k + 1) & 3, k2 = (k + 2) & 3, k3 = (k + 3) & 3;
    const auto part = [&](int at, int turn) {
        Piece p = piece;
        p.level += 1;
        p.x = 2 * piece.x + static_cast<unsigned>(k_corner_x[at]);
        p.y = 2 * piece.y + static_cast<unsigned>(k_corner_y[at]);
        p.turn = turn;
        p.quarter = false;
        return p;
    };
    const auto mid_side = [&](int side) {
        const int i = side & 3, j = (side + 1) & 3;
        // Where a quarter beside it keeps its corners, they need not be evaluated again.
        if (home.irregular()) {
            const QuadNode* quarters = home.node->grown();
            if (const auto& facts = quarters[2 * k_corner_y[i] + k_corner_x[i]].facts)
                return facts->corner[static_cast<std::size_t>(j)];
            if (const auto& facts = quarters[2 * k_corner_y[j] + k_corner_x[j]].facts)
                return facts->corner[static_cast<std::size_t>(i)];
        }
        return cell_point(home, 0.5 * (k_corner_x[i] + k_corner_x[j]), 0.5 * (k_corner_y[i] + k_corner_y[j]));
    };
    const auto mid_cell = [&] {
        if (home.irregular())
            for (int i = 0; i < 4; ++i)
                if (const auto& facts = home.node->grown()[2 * k_corner_y[i] + k_corner_x[i]].facts)
                    return facts->corner[static_cast<std::size_t>((i + 2) & 3)];
        return cell_point(home, 0.5, 0.5);
    };
    const auto& L = corners.linear;
    const auto& D = corners.deviation;
    if (piece.quarter) {
        Vec3d l, d;
        middle(mid_side(k), 1, 2, l, d);
        bound(part(k, k1), {{l, L[0], L[1]}, {d, D[0], D[1]}}, depth - 1);
        bound(part(k1, k), {{l, L[2], L[0]}, {d, D[2], D[0]}}, depth - 1);
        return;
    }
    Vec3d l01, d01, l02, d02, l12, d12;
    middle(mid_side(k), 0, 1, l01, d01);
    middle(mid_side(k3), 0, 2, l02, d02);
    middle(mid_cell(), 1, 2, l12, d12);
    bound(part(k, k), {{L[0], l01, l02}, {D[0], d01, d02}}, depth - 1);
    bound(part(k, k2), {{l12, l02, l01}, {d12, d02, d01}}, depth - 1);
    bound(part(k1, k), {{l01, L[1], l12}, {d01, D[1], d12}}, depth - 1);
    bound(part(k3, k), {{l02, l12, L[2]}, {d02, d12, D[2]}}, depth - 1);
}

void QuadBounder::bound_regular(Cell& home, const Piece& piece, const Corners& corners, double attained) {
    // On a lattice with n intervals a side the deviation is at most its largest sample plus the bound of one small
    // triangle, which is 1 / n^2 of the whole one's.
    const double whole = deviation(home, piece);
    const double pad = k_rounding * scale_;
    for (int n = 1;; n *= 2) {
        if (n > 1) attained = std::max(attained, largest_deviation(*home.net, piece, corners, n));
        lower_ = std::max(lower_, attained);
        if (may_reject_ && lower_ > decide_at_) {
            rejected_ = true;
            return;
        }
        const double upper = attained + whole / (n * n) + pad;
        if (upper <= decide_at_ || upper <= 1.05 * lower_ + pad || upper <= upper_ || n == k_finest_lattice) {
            upper_ = std::max(upper_, upper);
            return;
        }
    }
}

double QuadBounder::largest_deviation(const Net16& net, const Piece& piece, const Corners& corners, int n) {
    const LatticeShape shape = lattice_shape(piece.turn, piece.quarter, n);
    LatticeColumns columns;
    columns.fill(net, shape);
    double largest = 0;
    const double inv = 1.0 / n;
    for (int i = 0; i <= n; ++i)
        for (int j = 0; i + j <= n; ++j) {
            if (i == n || j == n || i + j == 0) continue;
            const double b1 = i * inv, b2 = j * inv, b0 = 1 - b1 - b2;
            const Vec3d s = columns.at(shape.x(i, j), shape.y(i, j));
            const Vec3d d = s - (b0 * corners.linear[0] + b1 * corners.linear[1] + b2 * corners.linear[2]);
            largest = std::max(largest, glm::dot(d, d));
        }
    return std::sqrt(largest);
}

QuadBounder::Piece QuadBounder::piece_of(const CellTriangle& leaf) {
    const LatticePoint a = leaf.corner[0], b = leaf.corner[1], apex = leaf.corner[2];
    Piece piece;
    piece.root = leaf.root;
    const std::uint32_t x0 = std::min({a.x, b.x, apex.x}), x1 = std::max({a.x, b.x, apex.x});
    const std::uint32_t y0 = std::min({a.y, b.y, apex.y}), y1 = std::max({a.y, b.y, apex.y});
    if (x1 - x0 == 1 && y1 - y0 == 1) {
        piece.level = leaf.level;
        piece.x = x0, piece.y = y0;
        const int cx = apex.x != x0, cy = apex.y != y0;
        piece.turn = cy == 0 ? cx : 3 - cx;
        return piece;
    }
    piece.level = leaf.level - 1;
    piece.quarter = true;
    piece.x = (apex.x - 1) / 2, piece.y = (apex.y - 1) / 2;
    if (a.y < apex.y && b.y < apex.y)
        piece.turn = 0;
    else if (a.x > apex.x && b.x > apex.x)
        piece.turn = 1;
    else if (a.y > apex.y && b.y > apex.y)
        piece.turn = 2;
    else
        piece.turn = 3;
    return piece;
}

QuadBounder::Corners QuadBounder::leaf_corners(const Piece& piece) {
    Cell& home = cell(piece.root, piece.level, piece.x, piece.y);
    Corners corners;
    const int k = piece.turn;
    if (piece.quarter) {
        corners.linear = {cell_point(home, 0.5, 0.5), cell_corner(home, k), cell_corner(home, (k + 1) & 3)};
    } else {
        corners.linear = {cell_corner(home, k), cell_corner(home, (k + 1) & 3), cell_corner(home, (k + 3) & 3)};
    }
    corners.deviation = {Vec3d(0), Vec3d(0), Vec3d(0)};
    return corners;
}

bool QuadBounder::is_root(const CellTriangle& leaf) { return leaf.level == 0 && leaf.corner[1].x == 2; }

LeafError QuadBounder::parametric_error(const CellTriangle& leaf, double decide_at) {
    decide_at_ = decide_at;
    lower_ = upper_ = 0;
    rejected_ = false;
    if (is_root(leaf)) {
        bound_root(leaf.root, nullptr);
    } else {
        // The middle of the base decides most leaves that must be split.
        const Piece piece = piece_of(leaf);
        const Corners corners = leaf_corners(piece);
        Cell& home = cell(piece.root, piece.level, piece.x, piece.y);
        const int i = piece.turn, j = (piece.turn + 1) & 3;
        const Vec3d middle = piece.quarter ? cell_point(home, 0.5 * (k_corner_x[i] + k_corner_x[j]),
                                                        0.5 * (k_corner_y[i] + k_corner_y[j]))
                                           : cell_point(home, 0.5, 0.5);
        lower_ = glm::length(middle - 0.5 * (corners.linear[1] + corners.linear[2]));
        if (may_reject_ && lower_ > decide_at_) rejected_ = true;
        bound(piece, corners, k_max_refinement);
    }
    if (rejected_) upper_ = std::numeric_limits<double>::infinity();
    return {lower_, std::max(upper_, lower_)};
}

void QuadBounder::bound_root(HalfedgeId h, const Vec3d* centre) {
    // Two half-cells that share the edge from the midpoint m of the base to the centre c.
    const HalfedgeId g = patches_.mesh().next(h);
    const Piece first{h, 0, 0, 0, 1, false}, second{g, 0, 0, 0, 3, false};
    Corners left = leaf_corners(first), right = leaf_corners(second);
    const Vec3d v = left.linear[2], c = left.linear[1], w = right.linear[1], m = left.linear[0];
    const Vec3d base = 0.5 * (v + w), linear_centre = centre ? *centre : c;
    left.linear = {base, linear_centre, v};
    right.linear = {base, w, linear_centre};
    left.deviation[0] = right.deviation[0] = m - base;
    left.deviation[1] = right.deviation[2] = c - linear_centre;
    bound(first, left, k_max_refinement);
    bound(second, right, k_max_refinement);
}

LeafError QuadBounder::root_error(HalfedgeId root, const Vec3d& centre, double decide_at, bool may_reject) {
    decide_at_ = decide_at;
    may_reject_ = may_reject;
    lower_ = upper_ = 0;
    rejected_ = false;
    bound_root(root, &centre);
    may_reject_ = true;
    if (rejected_) upper_ = std::numeric_limits<double>::infinity();
    return {lower_, std::max(upper_, lower_)};
}

double QuadBounder::certified_error(const CellTriangle& leaf, double floor) {
    may_reject_ = false;
    const LeafError e = parametric_error(leaf, floor);
    may_reject_ = true;
    return e.upper;
}

QuickError QuadBounder::quick_error(const CellTriangle& leaf, double) {
    QuickError quick;
    const double infinity = std::numeric_limits<double>::infinity();
    const double pad = k_rounding * scale_;
    if (is_root(leaf)) {
        const HalfedgeId g = patches_.mesh().next(leaf.root);
        const Piece first{leaf.root, 0, 0, 0, 1, false}, second{g, 0, 0, 0, 3, false};
        const Corners left = leaf_corners(first);
        Cell& left_cell = cell(leaf.root, 0, 0, 0);
        const double left_bound = left_cell.irregular() ? infinity : deviation(left_cell, first);
        const Corners right = leaf_corners(second);
        Cell& right_cell = cell(g, 0, 0, 0);
        const double right_bound = right_cell.irregular() ? infinity : deviation(right_cell, second);
        quick.corners = {left.linear[2], right.linear[1], left.linear[1]};
        quick.middle = left.linear[0] - 0.5 * (quick.corners[0] + quick.corners[1]);
        quick.upper = glm::length(quick.middle) + std::max(left_bound, right_bound) + pad;
        return quick;
    }
    const Piece piece = piece_of(leaf);
    const Corners corners = leaf_corners(piece);
    Cell& home = cell(piece.root, piece.level, piece.x, piece.y);
    Vec3d middle;
    if (piece.quarter) {
        const int i = piece.turn, j = (piece.turn + 1) & 3;
        middle = cell_point(home, 0.5 * (k_corner_x[i] + k_corner_x[j]), 0.5 * (k_corner_y[i] + k_corner_y[j]));
    } else {
        middle = cell_point(home, 0.5, 0.5);
    }
    // corners.linear starts at the apex or right angle, which is the leaf's corner 2; 1 and 2 follow counter-clockwise.
    quick.corners = {corners.linear[1], corners.linear[2], corners.linear[0]};
    quick.middle = middle - 0.5 * (quick.corners[0] + quick.corners[1]);
    quick.upper = home.irregular() ? infinity : deviation(home, piece) + pad;
    return quick;
}

void QuadBounder::sample(const CellTriangle& leaf, int n, std::span<Vec3d> positions, std::span<Vec3d> normals) {
    if (normals.empty() && !is_root(leaf) && (n == 2 || n == 4 || n == 8)) {
        const Piece piece = piece_of(leaf);
        const Cell& home = cell(piece.root, piece.level, piece.x, piece.y);
        if (!home.irregular() && !home.crease) {
            // The piece's corners are the leaf's 2, 0, 1.
            const LatticeShape shape = lattice_shape(piece.turn, piece.quarter, n);
            LatticeColumns columns;
            columns.fill(*home.net, shape);
            std::size_t i = 0;
            for (int row = 0; row <= n; ++row)
                for (int j = 0; j <= row; ++j) positions[i++] = columns.at(shape.x(row - j, j), shape.y(row - j, j));
            return;
        }
    }
    std::size_t out = 0;
    const auto put = [&](HalfedgeId root, double x, double y) {
        if (normals.empty()) {
            positions[out] = QuadPatches::position(patches_.root_node(root), x, y);
        } else {
            const SurfacePoint point = patches_.frame(root, x, y);
            positions[out] = point.position;
            normals[out] = glm::cross(point.du, point.dv);
        }
        ++out;
    };
    const double unit = std::ldexp(1.0, -leaf.level);
    const bool root_leaf = is_root(leaf);
    const HalfedgeId beyond = root_leaf ? patches_.mesh().next(leaf.root) : HalfedgeId{};
    for (int row = 0; row <= n; ++row)  // distance from corner 2
        for (int i = 0; i <= row; ++i) {
            const double b1 = static_cast<double>(i) / n, b2 = static_cast<double>(n - row) / n,
                         b0 = static_cast<double>(row - i) / n;
            const double x = (b0 * leaf.corner[0].x + b1 * leaf.corner[1].x + b2 * leaf.corner[2].x) * unit;
            const double y = (b0 * leaf.corner[0].y + b1 * leaf.corner[1].y + b2 * leaf.corner[2].y) * unit;
            if (root_leaf && x > 1)
                put(beyond, y, std::min(1.0, 2 - x));
            else
                put(leaf.root, std::min(x, 1.0), std::min(y, 1.0));
        }
}

}  // namespace tetrakis
