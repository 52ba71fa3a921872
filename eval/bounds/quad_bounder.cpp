#include "quad_bounder.hpp"

#include "../surface/local_frame.hpp"
#include "../triangles/point_triangle.hpp"
#include "bezier_pieces.hpp"
#include "labelled_polygon.hpp"
#include "star_norms.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace tetrakis {

using detail::k_centre_point;
using detail::k_corner_point;
using detail::k_corner_x;
using detail::k_corner_y;
using detail::k_side_point;
using detail::PathCell;
using detail::QuadNode;

namespace {

Vec2d corner_at(int k) { return Vec2d(k_corner_x[k & 3], k_corner_y[k & 3]); }

/// A point of a cell with a crease.
struct StripPoint {
    Vec2d at;
    Vec3d linear;     ///< L there
    double distance;  ///< from the crease
};
StripPoint mix(const StripPoint& a, const StripPoint& b, double t) {
    return {(1 - t) * a.at + t * b.at, (1 - t) * a.linear + t * b.linear, (1 - t) * a.distance + t * b.distance};
}

}  // namespace

QuadBounder::QuadBounder(const QuadPatches& patches)
    : PatchBounder(detail::surface_rounding(patches.mesh())), patches_(patches), walk_(patches) {}

double QuadBounder::hull_error(const QuadNode& node, const Piece& piece, const Corners& corners, bool may_split) const {
    const Vec3d* points = node.kind == QuadNode::Kind::star ? node.star->points.data() : node.local->points.data();
    const std::size_t count = node.kind == QuadNode::Kind::star ? node.star->points.size() : node.local->points.size();
    double least = std::numeric_limits<double>::infinity(), most = 0;
    for (std::size_t k = 0; k < 3; ++k) {
        // A corner of the piece that all the leaf's edges at the piece meet at stands for all of them.
        const std::size_t opposite = (k + 1) % 3;
        if (distance_ && piece.edge[opposite] >= 0) continue;
        double far = 0;
        for (std::size_t i = 0; i < count && far < least; ++i) {
            const Vec3d d = points[i] - corners.linear[k];
            far = std::max(far, glm::dot(d, d));
        }
        most = std::max(most, far);
        if (distance_)
            least = std::min(least, far);
        else if (may_split && !is_settled(std::sqrt(most)))
            break;
    }
    return std::sqrt(distance_ ? least : most);
}

double QuadBounder::irregular_error(const QuadNode& node, const Piece& piece, const Corners& corners,
                                    bool may_split) const {
    const detail::StarNorms* norms = node.kind == QuadNode::Kind::star
                                         ? detail::StarNorms::catmull_clark(node.star->valence, node.star->far_valence)
                                         : nullptr;
    if (!norms) return hull_error(node, piece, corners, may_split);
    // No error is larger than |S - L|, and L differs from the linear function through the piece's corners by no more
    // than it does at those.
    const int turn = (piece.turn - node.turn) & 3;
    return norms->deviation(node.star->points, piece.quarter ? 4 + turn : turn) + corners.largest_deviation();
}

void QuadBounder::bound(const Piece& piece, const Corners& corners, int depth) {
    if (!rejected_) bound(home(piece), piece, corners, depth);
}

void QuadBounder::bound(PathCell& cell, const Piece& piece, const Corners& corners, int depth) {
    if (!cell.irregular()) return bound_regular(cell, piece, corners);
    const bool may_split = depth > 0 && !exhausted();
    const double upper = irregular_error(*cell.node, piece, corners, may_split) + pad_;
    if (settled(upper)) return;
    if (!may_split) return give_up(upper);
    split(cell, piece, corners, depth);
}

void QuadBounder::split(PathCell& cell, const Piece& piece, const Corners& corners, int depth) {
    ++splits_;
    // The new corners are the midpoints of the edges (of the base alone for a quarter).
    const auto& L = corners.linear;
    const auto& D = corners.deviation;
    const auto& E = piece.edge;
    const int k = piece.turn, k1 = (k + 1) & 3, k2 = (k + 2) & 3, k3 = (k + 3) & 3;
    const auto part = [&](int at, int turn, Edges edge) {
        Piece p = piece;
        p.level += 1;
        p.x = 2 * piece.x + static_cast<unsigned>(k_corner_x[at]);
        p.y = 2 * piece.y + static_cast<unsigned>(k_corner_y[at]);
        p.turn = turn;
        p.quarter = false;
        p.edge = edge;
        return p;
    };
    constexpr int none = -1;
    std::array<Vec3d, 3> l, d;
    const auto middle = [&](std::size_t i, int point) {
        const Vec3d s = cell.point(point);
        l[i] = near_middle(s, L[i], L[(i + 1) % 3]);
        d[i] = s - l[i];
        return attain(node_error(measured_form(s, d[i]), E[i]));
    };
    if (piece.quarter) {
        if (!middle(1, k_side_point[k])) return;
        bound(part(k, k1, {none, E[0], E[1]}), {{l[1], L[0], L[1]}, {d[1], D[0], D[1]}}, depth - 1);
        bound(part(k1, k, {E[1], E[2], none}), {{l[1], L[2], L[0]}, {d[1], D[2], D[0]}}, depth - 1);
        return;
    }
    if (!middle(0, k_side_point[k]) || !middle(1, k_centre_point) || !middle(2, k_side_point[k3])) return;
    bound(part(k, k, {E[0], none, E[2]}), {{L[0], l[0], l[2]}, {D[0], d[0], d[2]}}, depth - 1);
    bound(part(k, k2, {none, none, none}), {{l[1], l[2], l[0]}, {d[1], d[2], d[0]}}, depth - 1);
    bound(part(k1, k, {E[0], E[1], none}), {{l[0], L[1], l[1]}, {d[0], D[1], d[1]}}, depth - 1);
    bound(part(k3, k, {none, E[1], E[2]}), {{l[2], l[1], L[2]}, {d[2], d[1], D[2]}}, depth - 1);
}

Vec3d QuadBounder::near_middle(const Vec3d& p, const Vec3d& a, const Vec3d& b) const {
    return a + (distance_ ? detail::nearest_on_segment(b - a, p - a) : 0.5) * (b - a);
}

QuadBounder::Piece QuadBounder::piece_of(const CellTriangle& leaf) {
    const LatticePoint a = leaf.corner[0], b = leaf.corner[1], apex = leaf.corner[2];
    Piece piece;
    piece.root = leaf.root;
    piece.edge = {0, 1, 2};
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

QuadBounder::Corners QuadBounder::leaf_corners(PathCell& cell, const Piece& piece) {
    const int k = piece.turn;
    Corners corners;
    if (piece.quarter) {
        corners.linear = {cell.point(k_centre_point), cell.point(k_corner_point[k]),
                          cell.point(k_corner_point[(k + 1) & 3])};
    } else {
        corners.linear = {cell.point(k_corner_point[k]), cell.point(k_corner_point[(k + 1) & 3]),
                          cell.point(k_corner_point[(k + 3) & 3])};
    }
    corners.deviation = {Vec3d(0), Vec3d(0), Vec3d(0)};
    return corners;
}

bool QuadBounder::is_root(const CellTriangle& leaf) { return leaf.level == 0 && leaf.corner[1].x == 2; }

LeafError QuadBounder::leaf_error(const CellTriangle& leaf, double decide_at, const EdgeSliding& of_leaf,
                                  bool may_reject) {
    start(decide_at, may_reject);
    // Pieces start at the leaf's last corner.
    const auto turned = [](const auto& of_edges) { return std::array{of_edges[2], of_edges[0], of_edges[1]}; };
    const EdgeSliding sliding{turned(of_leaf.edge), turned(of_leaf.fold), turned(of_leaf.flap)};
    if (is_root(leaf)) {
        bound_root(leaf.root, nullptr, sliding);
        return finish();
    }
    // The middle of the base decides most leaves that must be split.
    const Piece piece = piece_of(leaf);
    PathCell& cell = home(piece);
    const Corners corners = leaf_corners(cell, piece);
    const Vec3d middle = cell.point(piece.quarter ? k_side_point[piece.turn] : k_centre_point);
    set_face(detail::TriangleDistance(corners.linear, sliding));
    const bool slides = stretch_ > 1 && face_.slides(1);
    if (attain(slides ? face_.to_edge(face_.local(middle), 1)
                      : detail::segment_distance(middle, corners.linear[1], corners.linear[2])))
        bound(cell, piece, corners, detail::k_max_refinement);
    return finish();
}

void QuadBounder::bound_root(HalfedgeId h, const Vec3d* centre, const EdgeSliding& sliding) {
    // Two half-cells that share the edge from the midpoint m of the base to the centre c. Edges of the leaf: from c to
    // v, v to w, w to c.
    const HalfedgeId g = patches_.mesh().next(h);
    const Piece first{h, 0, 0, 0, 1, false, {-1, 0, 1}}, second{g, 0, 0, 0, 3, false, {1, 2, -1}};
    Corners left = leaf_corners(home(first), first), right = leaf_corners(home(second), second);
    const Vec3d v = left.linear[2], c = left.linear[1], w = right.linear[1], m = left.linear[0];
    const Vec3d linear_centre = centre ? *centre : c;
    if (!centre) {
        set_face(detail::TriangleDistance({c, v, w}, sliding));
        // The middles of the edges decide most leaves that must be split.
        const auto reject = [&](const Vec3d& p, std::size_t edge) {
            return !attain(face_.to_edge(face_.local(p), edge));
        };
        if (reject(m, 1) || reject(home(second).point(k_centre_point), 2) ||
            reject(home(first).point(k_centre_point), 0))
            return;
    }
    const Vec3d base = near_middle(m, v, w);
    left.linear = {base, linear_centre, v};
    right.linear = {base, w, linear_centre};
    left.deviation[0] = right.deviation[0] = m - base;
    left.deviation[1] = right.deviation[2] = c - linear_centre;
    if (!attain(std::max(node_error(measured_form(m, m - base), 1), centre ? glm::length(c - linear_centre) : 0.0)))
        return;
    bound(first, left, detail::k_max_refinement);
    bound(second, right, detail::k_max_refinement);
}

LeafError QuadBounder::root_error(HalfedgeId root, const Vec3d& centre, double decide_at, bool may_reject) {
    start(decide_at, may_reject);
    bound_root(root, &centre, {});
    return finish();
}

QuickError QuadBounder::quick_error(const CellTriangle& leaf) {
    QuickError quick;
    if (is_root(leaf)) {
        PathCell& cell = walk_.cell(leaf.root, 0, 0, 0);
        const Vec3d v = cell.point(k_corner_point[0]), m = cell.point(k_corner_point[1]),
                    c = cell.point(k_corner_point[2]);
        const Vec3d w = walk_.cell(patches_.mesh().next(leaf.root), 0, 0, 0).point(k_corner_point[0]);
        quick.corners = {v, w, c};
        quick.middle = m - 0.5 * (v + w);
        return quick;
    }
    const Piece piece = piece_of(leaf);
    PathCell& cell = home(piece);
    const Corners corners = leaf_corners(cell, piece);
    const Vec3d middle = cell.point(piece.quarter ? k_side_point[piece.turn] : k_centre_point);
    // corners.linear starts at the apex or right angle, which is the leaf's corner 2; 1 and 2 follow counter-clockwise.
    quick.corners = {corners.linear[1], corners.linear[2], corners.linear[0]};
    quick.middle = middle - 0.5 * (quick.corners[0] + quick.corners[1]);
    return quick;
}

void QuadBounder::bound_regular(const PathCell& cell, const Piece& piece, const Corners& corners) {
    // The longest side first.
    const auto& L = corners.linear;
    const auto& E = piece.edge;
    const Part part{longest_first(piece.quarter, piece.turn), {L[1], L[2], L[0]}, {E[1], E[2], E[0]}};
    static const auto weights = [] {
        std::array<std::array<detail::SexticWeights, 4>, 2> of;
        for (int turn = 0; turn < 4; ++turn)
            for (const bool quarter : {false, true})
                of[quarter][static_cast<std::size_t>(turn)] = detail::sextic_weights(longest_first(quarter, turn));
        return of;
    }();
    if (cell.crease)
        bound_strips(cell, part);
    else
        bound_part(*cell.net, part, corners.largest_deviation(),
                   weights[piece.quarter][static_cast<std::size_t>(piece.turn)]);
}

void QuadBounder::bound_part(const detail::Net16& net, const Part& part, double at_corners,
                             const detail::SexticWeights& weights) {
    // As for irregular cells. Most pieces need no more.
    if (settled(detail::bicubic_deviation(net, part.at) + at_corners + pad_)) return;
    using Patch = detail::BezierTriangle<6>;
    if (distance_) {
        detail::Net16 local;
        for (int y = -1; y <= 2; ++y)
            for (int x = -1; x <= 2; ++x) local.set(x, y, face_.local(net.at(x, y)));
        return bound_patch(detail::bicubic_over(local, weights), part.edge);
    }
    Patch patch = detail::bicubic_over(net, weights);
    for (int j = 0; j <= 6; ++j)
        for (int i = 0; i + j <= 6; ++i)
            patch.point[Patch::index(i, j)] -=
                (1.0 / 6) * ((6.0 - i - j) * part.linear[0] + double(i) * part.linear[1] + double(j) * part.linear[2]);
    bound_patch(patch, part.edge);
}

void QuadBounder::bound_strips(const PathCell& cell, const Part& part) {
    const int axis = cell.crease.side == 0 || cell.crease.side == 2 ? 1 : 0;  // across the crease
    const bool far = cell.crease.side == 1 || cell.crease.side == 2;
    std::array<StripPoint, 3> corners;
    for (std::size_t i = 0; i < 3; ++i)
        corners[i] = {part.at[i], part.linear[i], far ? 1 - part.at[i][axis] : part.at[i][axis]};
    const detail::LabelledPolygon<StripPoint> whole(corners, part.edge);
    std::array<detail::CreaseStrip, 3> strips;
    const auto strip_count = static_cast<std::size_t>(crease_strips(*cell.net, cell.crease, strips));
    for (const detail::CreaseStrip& strip : std::span(strips).first(strip_count)) {
        whole.clipped([&](const StripPoint& p) { return p.distance - strip.begin; })
            .clipped([&](const StripPoint& p) { return strip.end - p.distance; })
            .for_each_triangle([&](std::array<StripPoint, 3> at, const Edges& edge) {
                if (rejected_) return;
                for (StripPoint& p : at) {
                    const double distance = (p.distance - strip.origin) / strip.span;
                    p.at[axis] = far ? 1 - distance : distance;
                }
                const Part triangle{{at[0].at, at[1].at, at[2].at}, {at[0].linear, at[1].linear, at[2].linear}, edge};
                double at_corners = 0;
                for (std::size_t k = 0; k < 3; ++k) {
                    const Vec3d s = regular_position(strip.net, {}, triangle.at[k].x, triangle.at[k].y);
                    at_corners = std::max(at_corners, glm::length(s - triangle.linear[k]));
                }
                bound_part(strip.net, triangle, at_corners, detail::sextic_weights(triangle.at));
            });
    }
}

std::array<Vec2d, 3> QuadBounder::longest_first(bool quarter, int turn) {
    if (quarter) return {corner_at(turn), corner_at(turn + 1), Vec2d(0.5)};
    return {corner_at(turn + 1), corner_at(turn + 3), corner_at(turn)};
}

void QuadBounder::sample_smooth(const detail::Net16& net, const Piece& piece, int n, std::span<Vec3d> positions) {
    // All points stand on sixteenths of the cell. Along x each column leaves four control points along y.
    constexpr int k_parts = 16;
    static const auto weights = [] {
        std::array<detail::Weights4, k_parts + 1> at;
        for (int i = 0; i <= k_parts; ++i)
            at[static_cast<std::size_t>(i)] = detail::cubic_basis(static_cast<double>(i) / k_parts);
        return at;
    }();
    const auto sum = [](const detail::Weights4& w, const double* p) {
        return (w[0] * p[0] + w[1] * p[1]) + (w[2] * p[2] + w[3] * p[3]);
    };
    std::array<std::array<std::array<double, 4>, 3>, k_parts + 1> columns;
    for (std::size_t x = 0; x <= k_parts; x += static_cast<std::size_t>(k_parts / (piece.quarter ? 2 * n : n)))
        for (int k = 0; k < 3; ++k)
            for (int r = 0; r < 4; ++r)
                columns[x][static_cast<std::size_t>(k)][static_cast<std::size_t>(r)] =
                    sum(weights[x], net.c[k] + 4 * r);
    // The piece's corners are the leaf's 2, 0, 1.
    const auto [next, last, own] = longest_first(piece.quarter, piece.turn);
    const Vec2d start = double(k_parts) * own, a = (k_parts / double(n)) * (next - own),
                b = (k_parts / double(n)) * (last - own);
    std::size_t out = 0;
    for (int row = 0; row <= n; ++row)
        for (int j = 0; j <= row; ++j, ++out) {
            const Vec2d p = start + double(row - j) * a + double(j) * b;
            const auto& column = columns[static_cast<std::size_t>(p.x)];
            for (std::size_t k = 0; k < 3; ++k)
                positions[out][static_cast<int>(k)] = sum(weights[static_cast<std::size_t>(p.y)], column[k].data());
        }
}

void QuadBounder::sample(const CellTriangle& leaf, int n, std::span<Vec3d> positions) {
    if (!is_root(leaf) && (n == 2 || n == 4 || n == 8)) {
        const Piece piece = piece_of(leaf);
        const PathCell& cell = home(piece);
        if (cell.smooth()) {
            sample_smooth(*cell.net, piece, n, positions);
            return;
        }
    }
    std::size_t out = 0;
    const auto put = [&](HalfedgeId root, double x, double y) {
        positions[out++] = QuadPatches::position(patches_.root_node(root), x, y);
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
