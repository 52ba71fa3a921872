#include "quad_bounder.hpp"

#include "../surface/local_frame.hpp"
#include "bezier_pieces.hpp"
#include "labelled_polygon.hpp"
#include "star_norms.hpp"

#include <algorithm>

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

}  // namespace

QuadBounder::QuadBounder(const QuadPatches& patches)
    : PatchBounder(detail::surface_rounding(patches.mesh())), patches_(patches), walk_(patches) {}

double QuadBounder::irregular_error(const QuadNode& node, const Piece& piece, const Corners& corners,
                                    bool may_split) const {
    if (node.kind != QuadNode::Kind::star) return hull_error(node.rings->points(), piece.edge, may_split);
    const detail::StarNorms* norms = detail::StarNorms::catmull_clark(node.star->valence, node.star->far_valence);
    if (!norms) return hull_error(node.star->points, piece.edge, may_split);
    // The surface against the bilinear function of its corners, and that against the one linear between its values at
    // the piece's corners: u v differs from that by 1 / 4 at most on half the cell, by 1 / 16 on a quarter.
    const Vec3d c0 = node.corner(0), c1 = node.corner(1), c2 = node.corner(2), c3 = node.corner(3);
    const double off = norms->deviation(node.star->points), twist = glm::length(c0 - c1 + c2 - c3);
    if (!piece.quarter) return off + 0.25 * twist + corner_error(corners, piece.edge);
    const Vec3d centre = face_.local(0.25 * (c0 + c1 + c2 + c3));
    return off + 0.0625 * twist + corner_error({centre, corners[1], corners[2]}, piece.edge);
}

void QuadBounder::bound(const Piece& piece, const Corners& corners, int depth) {
    if (!rejected_) bound(home(piece), piece, corners, depth);
}

void QuadBounder::bound(const PathCell& cell, const Piece& piece, const Corners& corners, int depth) {
    if (!cell.irregular()) return bound_regular(cell, piece, corners);
    const auto error = [&](bool may_split) { return irregular_error(*cell.node, piece, corners, may_split); };
    if (needs_split(depth, error)) split(cell, piece, corners, depth);
}

void QuadBounder::split(const PathCell& cell, const Piece& piece, const Corners& corners, int depth) {
    // The new corners are over the midpoints of the edges (of the base alone for a quarter).
    const auto& C = corners;
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
    Corners m;
    const auto middle = [&](std::size_t i, int point) {
        m[i] = face_.local(cell.point(point));
        return attain(node_error(m[i], E[i]));
    };
    if (piece.quarter) {
        if (!middle(1, k_side_point[k])) return;
        bound(part(k, k1, {none, E[0], E[1]}), {m[1], C[0], C[1]}, depth - 1);
        bound(part(k1, k, {E[1], E[2], none}), {m[1], C[2], C[0]}, depth - 1);
        return;
    }
    if (!middle(0, k_side_point[k]) || !middle(1, k_centre_point) || !middle(2, k_side_point[k3])) return;
    bound(part(k, k, {E[0], none, E[2]}), {C[0], m[0], m[2]}, depth - 1);
    bound(part(k, k2, {none, none, none}), {m[1], m[2], m[0]}, depth - 1);
    bound(part(k1, k, {E[0], E[1], none}), {m[0], C[1], m[1]}, depth - 1);
    bound(part(k3, k, {none, E[1], E[2]}), {m[2], m[1], C[2]}, depth - 1);
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

QuadBounder::Corners QuadBounder::corners_of(const PathCell& cell, const Piece& piece) {
    const int k = piece.turn;
    if (piece.quarter)
        return {cell.point(k_centre_point), cell.point(k_corner_point[k]), cell.point(k_corner_point[(k + 1) & 3])};
    return {cell.point(k_corner_point[k]), cell.point(k_corner_point[(k + 1) & 3]),
            cell.point(k_corner_point[(k + 3) & 3])};
}

Vec3d QuadBounder::middle_of(const PathCell& cell, const Piece& piece) {
    return cell.point(piece.quarter ? k_side_point[piece.turn] : k_centre_point);
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
    const Piece piece = piece_of(leaf);
    const PathCell& cell = home(piece);
    Corners corners = corners_of(cell, piece);
    set_face(detail::TriangleDistance(corners, sliding));
    // The middle of the base decides most leaves that must be split.
    if (attain(node_error(face_.local(middle_of(cell, piece)), 1))) {
        for (Vec3d& p : corners) p = face_.local(p);
        bound(cell, piece, corners, detail::k_max_refinement);
    }
    return finish();
}

void QuadBounder::bound_root(HalfedgeId h, const Vec3d* centre, const EdgeSliding& sliding) {
    // Two half-cells that share the edge from the middle m of the base to the face's centre c. Edges of the leaf: from
    // c to v, v to w, w to c.
    const HalfedgeId g = patches_.mesh().next(h);
    const Piece first{h, 0, 0, 0, 1, false, {-1, 0, 1}}, second{g, 0, 0, 0, 3, false, {1, 2, -1}};
    const Corners left = corners_of(home(first), first);
    const Vec3d to_centre = home(first).point(k_centre_point);
    const Corners right = corners_of(home(second), second);
    const Vec3d c = left[1], v = left[2], w = right[1];
    set_face(detail::TriangleDistance({centre ? *centre : c, v, w}, sliding));
    if (centre && !attain(glm::length(c - *centre))) return;
    const Vec3d m = face_.local(left[0]);
    // The middles of the edges decide most leaves that must be split.
    if (!attain(node_error(m, 1)) || !attain(node_error(face_.local(home(second).point(k_centre_point)), 2)) ||
        !attain(node_error(face_.local(to_centre), 0)))
        return;
    const Vec3d apex = face_.local(c);
    bound(first, {m, apex, face_.local(v)}, detail::k_max_refinement);
    bound(second, {m, face_.local(w), apex}, detail::k_max_refinement);
}

LeafError QuadBounder::root_error(HalfedgeId root, const Vec3d& centre, double decide_at, bool may_reject) {
    start(decide_at, may_reject);
    bound_root(root, &centre, {});
    return finish();
}

void QuadBounder::bound_regular(const PathCell& cell, const Piece& piece, const Corners& corners) {
    // The longest side first.
    const auto& E = piece.edge;
    const std::array<Vec2d, 3> at = longest_first(piece.quarter, piece.turn);
    const Edges edge{E[1], E[2], E[0]};
    static const auto weights = [] {
        std::array<std::array<detail::SexticWeights, 4>, 2> of;
        for (int turn = 0; turn < 4; ++turn)
            for (const bool quarter : {false, true})
                of[quarter][static_cast<std::size_t>(turn)] = detail::sextic_weights(longest_first(quarter, turn));
        return of;
    }();
    if (cell.crease)
        bound_strips(cell, at, edge);
    else
        bound_part(*cell.net, at, {corners[1], corners[2], corners[0]}, edge,
                   &weights[piece.quarter][static_cast<std::size_t>(piece.turn)]);
}

void QuadBounder::bound_part(const detail::Net16& net, const std::array<Vec2d, 3>& at, const Corners& corners,
                             const Edges& edge, const detail::SexticWeights* weights) {
    // Most pieces need no more.
    if (settled(detail::bicubic_deviation(net, at) + corner_error(corners, edge) + pad_)) return;
    detail::Net16 local;
    for (int y = -1; y <= 2; ++y)
        for (int x = -1; x <= 2; ++x) local.set(x, y, face_.local(net.at(x, y)));
    bound_patch(detail::bicubic_over(local, weights != nullptr ? *weights : detail::sextic_weights(at)), edge);
}

void QuadBounder::bound_strips(const PathCell& cell, const std::array<Vec2d, 3>& piece, const Edges& edges) {
    const int axis = cell.crease.across_y() ? 1 : 0;  // across the crease
    const bool far = cell.crease.far();
    const auto distance = [&](const Vec2d& p) { return far ? 1 - p[axis] : p[axis]; };
    const detail::LabelledPolygon<Vec2d> whole(piece, edges);
    std::array<detail::CreaseStrip, 3> strips;
    const auto strip_count = static_cast<std::size_t>(crease_strips(*cell.net, cell.crease, strips));
    for (const detail::CreaseStrip& strip : std::span(strips).first(strip_count)) {
        whole.clipped([&](const Vec2d& p) { return distance(p) - strip.begin; })
            .clipped([&](const Vec2d& p) { return strip.end - distance(p); })
            .for_each_triangle([&](std::array<Vec2d, 3> at, const Edges& edge) {
                if (rejected_) return;
                Corners corners;
                for (std::size_t k = 0; k < 3; ++k) {
                    const double across = (distance(at[k]) - strip.origin) / strip.span;
                    at[k][axis] = far ? 1 - across : across;
                    corners[k] = face_.local(regular_position(strip.net, {}, at[k].x, at[k].y));
                }
                bound_part(strip.net, at, corners, edge);
            });
    }
}

std::array<Vec2d, 3> QuadBounder::longest_first(bool quarter, int turn) {
    if (quarter) return {corner_at(turn), corner_at(turn + 1), Vec2d(0.5)};
    return {corner_at(turn + 1), corner_at(turn + 3), corner_at(turn)};
}

void QuadBounder::sample(const CellTriangle& leaf, int n, std::span<Vec3d> positions) {
    const bool root = is_root(leaf);
    const Piece piece = root ? Piece{leaf.root, 0, 0, 0, 0, false, {}} : piece_of(leaf);
    // The leaf's corners in its cell; a root leaf's second one lies in the next cell.
    const std::array<Vec2d, 3> corner =
        root ? std::array{Vec2d(0), Vec2d(2, 0), Vec2d(1)} : longest_first(piece.quarter, piece.turn);
    const PathCell& cell = home(piece);
    const QuadNode* beyond = root ? &patches_.root_node(patches_.mesh().next(leaf.root)) : nullptr;
    detail::for_each_lattice_point(n, [&](int i, double b0, double b1, double b2) {
        const Vec2d p = b0 * corner[0] + b1 * corner[1] + b2 * corner[2];
        const double x = std::clamp(p.x, 0.0, 2.0), y = std::clamp(p.y, 0.0, 1.0);
        positions[static_cast<std::size_t>(i)] = root && x > 1 ? QuadPatches::position(*beyond, {y, 2 - x})
                                                 : cell.irregular()
                                                     ? QuadPatches::position(*cell.node, {std::min(x, 1.0), y})
                                                     : regular_position(*cell.net, cell.crease, std::min(x, 1.0), y);
    });
}

}  // namespace tetrakis
