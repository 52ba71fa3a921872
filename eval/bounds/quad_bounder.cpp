#include "quad_bounder.hpp"

#include "../surface/local_frame.hpp"
#include "bezier_pieces.hpp"
#include "labelled_polygon.hpp"
#include "star_norms.hpp"

#include <algorithm>

namespace tetrakis {

using detail::PathCell;
using detail::QuadNode;

namespace {

Vec3d position(const PathCell& cell, const Vec2d& at) {
    return cell.irregular() ? QuadPatches::position(*cell.node, at)
                            : regular_position(*cell.net, cell.crease, at.x, at.y);
}

bool is_root(const CellTriangle& leaf) { return leaf.level == 0 && leaf.corner[1].x == 2; }

}  // namespace

QuadBounder::QuadBounder(const QuadPatches& patches)
    : PatchBounder(detail::surface_rounding(patches.mesh())), patches_(patches), walk_(patches) {}

QuadBounder::Piece QuadBounder::piece_of(const CellTriangle& leaf) {
    const auto [x0, x1] = std::minmax({leaf.corner[0].x, leaf.corner[1].x, leaf.corner[2].x});
    const auto [y0, y1] = std::minmax({leaf.corner[0].y, leaf.corner[1].y, leaf.corner[2].y});
    // Half of a cell of its level, or a quarter of one of the level above.
    const int up = x1 - x0 == 1 && y1 - y0 == 1 ? 0 : 1;
    Piece piece{leaf.root, leaf.level - up, x0 >> up, y0 >> up, {}, {0, 1, 2}};
    for (std::size_t k = 0; k < 3; ++k)
        piece.at[k] = Vec2d(leaf.corner[k].x, leaf.corner[k].y) / (1.0 + up) - Vec2d(piece.x, piece.y);
    return piece;
}

LeafError QuadBounder::leaf_error(const CellTriangle& leaf, double decide_at, const EdgeSliding& sliding,
                                  bool may_reject) {
    start(decide_at, may_reject);
    if (is_root(leaf)) {
        bound_root(leaf.root, nullptr, sliding);
        return finish();
    }
    const Piece piece = piece_of(leaf);
    const PathCell& cell = home(piece);
    const auto& at = piece.at;
    set_face(detail::TriangleDistance({position(cell, at[0]), position(cell, at[1]), position(cell, at[2])}, sliding));
    // The middle of the base decides most leaves that must be split.
    if (attain(node_error(face_.local(position(cell, 0.5 * (at[0] + at[1]))), 0)))
        bound(piece, detail::k_max_refinement);
    return finish();
}

void QuadBounder::bound_root(HalfedgeId h, const Vec3d* centre, const EdgeSliding& sliding) {
    // Two half-cells, of corners v and w, that share the edge from the middle of the base to the face's centre c.
    const HalfedgeId g = patches_.mesh().next(h);
    const Vec2d corner(0), middle(0.5), end(1);
    const Piece first{h, 0, 0, 0, {corner, Vec2d(1, 0), end}, {0, -1, 2}},
        second{g, 0, 0, 0, {Vec2d(0, 1), corner, end}, {0, 1, -1}};
    const PathCell& left = home(first);
    const Vec3d v = position(left, corner), c = position(left, end), m = position(left, Vec2d(1, 0)),
                to_centre = position(left, middle);
    const PathCell& right = home(second);
    set_face(detail::TriangleDistance({v, position(right, corner), centre ? *centre : c}, sliding));
    if (centre && !attain(glm::length(c - *centre))) return;
    // The middles of the edges decide most leaves that must be split.
    if (!attain(node_error(face_.local(m), 0)) || !attain(node_error(face_.local(position(right, middle)), 1)) ||
        !attain(node_error(face_.local(to_centre), 2)))
        return;
    bound(first, detail::k_max_refinement);
    bound(second, detail::k_max_refinement);
}

LeafError QuadBounder::root_error(HalfedgeId root, const Vec3d& centre, double decide_at, bool may_reject) {
    start(decide_at, may_reject);
    bound_root(root, &centre, {});
    return finish();
}

void QuadBounder::bound(const Piece& piece, int depth) {
    if (rejected_) return;
    const PathCell& cell = home(piece);
    if (!cell.irregular()) {
        // The longest side first: it is bisected.
        std::array<Vec2d, 3> at = piece.at;
        Edges edge = piece.edge;
        const std::array length{glm::distance(at[0], at[1]), glm::distance(at[1], at[2]), glm::distance(at[2], at[0])};
        const auto longest = std::ranges::max_element(length) - length.begin();
        std::ranges::rotate(at, at.begin() + longest);
        std::ranges::rotate(edge, edge.begin() + longest);
        return cell.crease ? bound_strips(cell, at, edge) : bound_part(*cell.net, at, edge);
    }
    const QuadNode& node = *cell.node;
    for (std::size_t k = 0; k < 3; ++k) {
        const Vec3d corner = face_.local(position(cell, piece.at[k]));
        if (!attain(std::max(node_error(corner, piece.edge[k]), node_error(corner, piece.edge[(k + 2) % 3])))) return;
    }
    const auto error = [&](bool may_split) { return irregular_error(node, piece, may_split); };
    if (!needs_split(depth, error)) return;
    const detail::LabelledPolygon<Vec2d> whole(piece.at, piece.edge);
    for (const int x : {0, 1})
        for (const int y : {0, 1})
            whole.clipped([&](const Vec2d& p) { return (2 * x - 1) * (p.x - 0.5); })
                .clipped([&](const Vec2d& p) { return (2 * y - 1) * (p.y - 0.5); })
                .for_each_triangle([&](std::array<Vec2d, 3> at, const Edges& edge) {
                    for (Vec2d& p : at) p = 2.0 * p - Vec2d(x, y);
                    bound({piece.root, piece.level + 1, 2 * piece.x + static_cast<std::uint64_t>(x),
                           2 * piece.y + static_cast<std::uint64_t>(y), at, edge},
                          depth - 1);
                });
}

double QuadBounder::irregular_error(const QuadNode& node, const Piece& piece, bool may_split) const {
    if (node.kind != QuadNode::Kind::star) return hull_error(node.rings->points(), piece.edge, may_split);
    const detail::StarNorms* norms = detail::StarNorms::catmull_clark(node.star->valence, node.star->far_valence);
    if (!norms) return hull_error(node.star->points, piece.edge, may_split);
    // The surface against the bilinear function of its corners, and that against the one linear between its values at
    // the piece's corners: x y is off that by a quarter of |dx dy| along a side at most.
    const Vec3d c0 = node.corner(0), c1 = node.corner(1), c2 = node.corner(2), c3 = node.corner(3);
    std::array<Vec3d, 3> corners;
    double bend = 0;
    for (std::size_t k = 0; k < 3; ++k) {
        const Vec2d &p = piece.at[k], side = piece.at[(k + 1) % 3] - p;
        corners[k] = face_.local((1 - p.y) * ((1 - p.x) * c0 + p.x * c1) + p.y * ((1 - p.x) * c3 + p.x * c2));
        bend = std::max(bend, 0.25 * std::abs(side.x * side.y));
    }
    return norms->deviation(node.star->points) + bend * glm::length(c0 - c1 + c2 - c3) +
           corner_error(corners, piece.edge);
}

const detail::SexticWeights& QuadBounder::weights_over(const std::array<Vec2d, 3>& at) {
    constexpr std::size_t k_most = 8;  // halves and quarters of a cell
    const auto known = std::ranges::find(weights_, at, [](const auto& entry) { return entry.first; });
    if (known != weights_.end()) return known->second;
    if (weights_.size() == k_most) weights_.clear();
    return weights_.emplace_back(at, detail::sextic_weights(at)).second;
}

void QuadBounder::bound_part(const detail::Net16& net, const std::array<Vec2d, 3>& at, const Edges& edge) {
    std::array<Vec3d, 3> corners;
    for (std::size_t k = 0; k < 3; ++k) corners[k] = face_.local(regular_position(net, {}, at[k].x, at[k].y));
    // Most pieces need no more.
    if (settled(detail::bicubic_deviation(net, at) + corner_error(corners, edge) + pad_)) return;
    detail::Net16 local;
    for (int y = -1; y <= 2; ++y)
        for (int x = -1; x <= 2; ++x) local.set(x, y, face_.local(net.at(x, y)));
    bound_patch(detail::bicubic_over(local, weights_over(at)), edge);
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
                for (Vec2d& p : at) {
                    const double across = (distance(p) - strip.origin) / strip.span;
                    p[axis] = far ? 1 - across : across;
                }
                bound_part(strip.net, at, edge);
            });
    }
}

void QuadBounder::sample(const CellTriangle& leaf, int n, std::span<Vec3d> positions) {
    const bool root = is_root(leaf);
    // A root leaf's second corner lies in the next cell.
    const Piece piece = root ? Piece{leaf.root, 0, 0, 0, {Vec2d(0), Vec2d(2, 0), Vec2d(1)}, {}} : piece_of(leaf);
    const PathCell& cell = home(piece);
    const QuadNode* beyond = root ? &patches_.root_node(patches_.mesh().next(leaf.root)) : nullptr;
    detail::for_each_lattice_point(n, [&](int i, double b0, double b1, double b2) {
        const Vec2d p = b0 * piece.at[0] + b1 * piece.at[1] + b2 * piece.at[2];
        const double x = std::clamp(p.x, 0.0, 2.0), y = std::clamp(p.y, 0.0, 1.0);
        positions[static_cast<std::size_t>(i)] =
            root && x > 1 ? QuadPatches::position(*beyond, {y, 2 - x}) : position(cell, {std::min(x, 1.0), y});
    });
}

}  // namespace tetrakis
