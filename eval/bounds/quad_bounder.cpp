#include "quad_bounder.hpp"

#include "../surface/local_frame.hpp"
#include "bezier_pieces.hpp"
#include "star_norms.hpp"

#include <algorithm>
#include <span>

namespace tetrakis {

using detail::QuadNode;
using detail::QuadShape;

namespace {

/// Cells are quartered at most this many levels below the leaf; those that are still irregular then are bounded by
/// their hull.
constexpr int k_most_quarterings = 32;

bool is_root(const CellTriangle& leaf) { return leaf.level == 0 && leaf.corner[1].x == 2; }

}  // namespace

QuadBounder::QuadBounder(const QuadPatches& patches)
    : PatchBounder(detail::surface_rounding(patches.mesh())), patches_(patches) {}

const QuadBounder::Cell& QuadBounder::locate(const CellTriangle& leaf, Corners& at) {
    const auto [x0, x1] = std::minmax({leaf.corner[0].x, leaf.corner[1].x, leaf.corner[2].x});
    const auto [y0, y1] = std::minmax({leaf.corner[0].y, leaf.corner[1].y, leaf.corner[2].y});
    // Half of a cell of its level, or a quarter of one of the level above.
    const int up = x1 - x0 == 1 && y1 - y0 == 1 ? 0 : 1;
    const std::uint32_t x = x0 >> up, y = y0 >> up;
    for (std::size_t k = 0; k < 3; ++k) at[k] = Vec2d(leaf.corner[k].x, leaf.corner[k].y) / (1.0 + up) - Vec2d(x, y);
    const auto level = static_cast<std::size_t>(leaf.level - up);
    if (path_.empty() || leaf.root != root_ || times_forgotten_ != patches_.times_forgotten()) {
        root_ = leaf.root;
        times_forgotten_ = patches_.times_forgotten();
        path_.clear();
        push_cell(patches_.root_node(leaf.root), 0, 0);
    }
    const auto leads_there = [&] {
        const std::size_t depth = path_.size() - 1;
        return depth <= level && path_.back().x == x >> (level - depth) && path_.back().y == y >> (level - depth);
    };
    while (!leads_there()) path_.pop_back();
    while (path_.size() <= level) {
        const std::uint32_t below_x = x >> (level - path_.size()), below_y = y >> (level - path_.size());
        const int qx = static_cast<int>(below_x & 1), qy = static_cast<int>(below_y & 1);
        if (const QuadNode* node = path_.back().irregular) {
            push_cell(node->grown()[detail::quad_quarter(qx, qy)], below_x, below_y);
            continue;
        }
        Cell& child = path_.emplace_back();
        child.x = below_x, child.y = below_y;
        const QuadShape::Patch& parent = path_[path_.size() - 2].patch;
        child_net(parent.net, parent.crease, qx, qy, child.patch.net, child.patch.crease);
    }
    return path_.back();
}

void QuadBounder::push_cell(const QuadNode& node, std::uint32_t x, std::uint32_t y) {
    Cell& cell = path_.emplace_back();
    cell.x = x, cell.y = y;
    if (node.kind == QuadNode::Kind::regular)
        cell.patch = node.patch;
    else
        cell.irregular = &node;
}

LeafError QuadBounder::leaf_error(const CellTriangle& leaf, double decide_at, const EdgeSliding& sliding,
                                  bool may_reject) {
    start(decide_at, may_reject);
    if (is_root(leaf)) {
        bound_root(leaf.root, nullptr, sliding);
        return finish();
    }
    Piece piece{{}, {0, 1, 2}};
    const Cell& cell = locate(leaf, piece.at);
    const auto& at = piece.at;
    set_face(detail::TriangleDistance({cell.position(at[0]), cell.position(at[1]), cell.position(at[2])}, sliding));
    // The middle of the base decides most leaves that must be split.
    if (!attain(node_error(face_.local(cell.position(0.5 * (at[0] + at[1]))), 0))) return finish();
    if (cell.irregular)
        bound_cell(*cell.irregular, piece, k_most_quarterings);
    else
        bound_regular(cell.patch, piece);
    return finish();
}

void QuadBounder::bound_root(HalfedgeId h, const Vec3d* centre, const EdgeSliding& sliding) {
    // Two half-cells, of corners v and w, that share the edge from the middle of the base to the face's centre c.
    const QuadNode &left = patches_.root_node(h), &right = patches_.root_node(patches_.mesh().next(h));
    const Vec2d corner(0), middle(0.5), end(1);
    const auto position = [](const QuadNode& cell, const Vec2d& at) { return QuadPatches::position(cell, at); };
    const Vec3d v = position(left, corner), c = position(left, end), m = position(left, Vec2d(1, 0));
    set_face(detail::TriangleDistance({v, position(right, corner), centre ? *centre : c}, sliding));
    if (centre && !attain(glm::length(c - *centre))) return;
    // The middles of the edges decide most leaves that must be split.
    if (!attain(node_error(face_.local(m), 0)) || !attain(node_error(face_.local(position(right, middle)), 1)) ||
        !attain(node_error(face_.local(position(left, middle)), 2)))
        return;
    bound_cell(left, {{corner, Vec2d(1, 0), end}, {0, -1, 2}}, k_most_quarterings);
    bound_cell(right, {{Vec2d(0, 1), corner, end}, {0, 1, -1}}, k_most_quarterings);
}

LeafError QuadBounder::root_error(HalfedgeId root, const Vec3d& centre, double decide_at, bool may_reject) {
    start(decide_at, may_reject);
    bound_root(root, &centre, {});
    return finish();
}

void QuadBounder::bound_cell(const QuadNode& cell, const Piece& piece, int depth) {
    if (rejected_) return;
    if (cell.kind == QuadNode::Kind::regular) return bound_regular(cell.patch, piece);
    for (std::size_t k = 0; k < 3; ++k) {
        const Vec3d corner = face_.local(QuadPatches::position(cell, piece.at[k]));
        if (!attain(std::max(node_error(corner, piece.edge[k]), node_error(corner, piece.edge[(k + 2) % 3])))) return;
    }
    const auto error = [&](bool may_split) { return irregular_error(cell, piece, may_split); };
    if (!needs_split(depth, error)) return;
    for (const int x : {0, 1})
        for (const int y : {0, 1})
            detail::in_quarter(piece, x, y).for_each_triangle([&](const Piece& part) {
                bound_cell(cell.grown()[detail::quad_quarter(x, y)], part, depth - 1);
            });
}

void QuadBounder::bound_regular(const QuadShape::Patch& cell, Piece piece) {
    // The longest side first: it is bisected.
    const auto& at = piece.at;
    const std::array length{glm::distance(at[0], at[1]), glm::distance(at[1], at[2]), glm::distance(at[2], at[0])};
    const auto longest = std::ranges::max_element(length) - length.begin();
    std::ranges::rotate(piece.at, piece.at.begin() + longest);
    std::ranges::rotate(piece.edge, piece.edge.begin() + longest);
    if (cell.crease)
        bound_strips(cell, piece);
    else
        bound_part(cell.net, piece);
}

double QuadBounder::irregular_error(const QuadNode& cell, const Piece& piece, bool may_split) const {
    if (cell.kind != QuadNode::Kind::star) return hull_error(cell.rings->points(), piece.edge, may_split);
    const detail::StarNorms* norms = detail::StarNorms::of(*cell.star);
    if (!norms) return hull_error(cell.star->points, piece.edge, may_split);
    // The surface against the bilinear function of its corners, and that against the one linear between its values at
    // the piece's corners: x y is off that by a quarter of |dx dy| along a side at most.
    const Vec3d c0 = cell.corner(0), c1 = cell.corner(1), c2 = cell.corner(2), c3 = cell.corner(3);
    std::array<Vec3d, 3> corners;
    double bend = 0;
    for (std::size_t k = 0; k < 3; ++k) {
        const Vec2d &p = piece.at[k], side = piece.at[(k + 1) % 3] - p;
        corners[k] = face_.local((1 - p.y) * ((1 - p.x) * c0 + p.x * c1) + p.y * ((1 - p.x) * c3 + p.x * c2));
        bend = std::max(bend, 0.25 * std::abs(side.x * side.y));
    }
    return norms->deviation(cell.star->points) + bend * glm::length(c0 - c1 + c2 - c3) +
           corner_error(corners, piece.edge);
}

const detail::SexticWeights& QuadBounder::weights_over(const Corners& at) {
    constexpr std::size_t k_most = 8;  // halves and quarters of a cell
    const auto known = std::ranges::find(weights_, at, [](const auto& entry) { return entry.first; });
    if (known != weights_.end()) return known->second;
    if (weights_.size() == k_most) weights_.clear();
    return weights_.emplace_back(at, detail::sextic_weights(at)).second;
}

void QuadBounder::bound_part(const detail::Net16& net, const Piece& piece) {
    const auto& [at, edge] = piece;
    std::array<Vec3d, 3> corners;
    for (std::size_t k = 0; k < 3; ++k) corners[k] = face_.local(regular_position(net, {}, at[k].x, at[k].y));
    // Most pieces need no more.
    if (settled(detail::bicubic_deviation(net, at) + corner_error(corners, edge) + pad_)) return;
    detail::Net16 local;
    for (int y = -1; y <= 2; ++y)
        for (int x = -1; x <= 2; ++x) local.set(x, y, face_.local(net.at(x, y)));
    bound_patch(detail::bicubic_over(local, weights_over(at)), edge);
}

void QuadBounder::bound_strips(const QuadShape::Patch& cell, const Piece& piece) {
    const int axis = cell.crease.across_y() ? 1 : 0;  // across the crease
    const bool far = cell.crease.far();
    const auto distance = [&](const Vec2d& p) { return far ? 1 - p[axis] : p[axis]; };
    const detail::LabelledPolygon<Vec2d> whole(piece);
    std::array<detail::CreaseStrip, 3> strips;
    const auto strip_count = static_cast<std::size_t>(crease_strips(cell.net, cell.crease, strips));
    for (const detail::CreaseStrip& strip : std::span(strips).first(strip_count)) {
        whole.clipped([&](const Vec2d& p) { return distance(p) - strip.begin; })
            .clipped([&](const Vec2d& p) { return strip.end - distance(p); })
            .for_each_triangle([&](Piece part) {
                if (rejected_) return;
                for (Vec2d& p : part.at) {
                    const double across = (distance(p) - strip.origin) / strip.span;
                    p[axis] = far ? 1 - across : across;
                }
                bound_part(strip.net, part);
            });
    }
}

}  // namespace tetrakis
