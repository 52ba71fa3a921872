#include "cell_bounder.hpp"

#include "../surface/local_frame.hpp"

#include <algorithm>
#include <cmath>

namespace tetrakis {

namespace {

/// Cells are quartered at most this many levels below the leaf; the bounds of those that are still irregular then
/// count.
constexpr int k_most_quarterings = 40;

}  // namespace

template <class Shape>
CellBounder<Shape>::CellBounder(const PatchTree<Shape>& patches)
    : PatchBounder(detail::surface_rounding(patches.mesh())), patches_(patches) {}

template <class Shape>
LeafError CellBounder<Shape>::leaf_error(const CellTriangle& leaf, double decide_at, const EdgeSliding& sliding,
                                         bool may_reject) {
    start(decide_at, may_reject);
    const double unit = std::ldexp(1.0, -leaf.level);
    Corners at;
    for (std::size_t k = 0; k < 3; ++k) at[k] = unit * Vec2d(leaf.corner[k].x, leaf.corner[k].y);
    return error_over(leaf.root, at, nullptr, sliding);
}

template <class Shape>
LeafError CellBounder<Shape>::part_error(HalfedgeId root, const Corners& corners, double decide_at) {
    start(decide_at, false);
    return error_over(root, corners, nullptr, {});
}

template <class Shape>
LeafError CellBounder<Shape>::root_error(HalfedgeId root, const Vec3d& centre, double decide_at, bool may_reject) {
    start(decide_at, may_reject);
    return error_over(root, {Vec2d(0, 0), Vec2d(2, 0), Vec2d(1, 1)}, &centre, {});
}

template <class Shape>
LeafError CellBounder<Shape>::error_over(HalfedgeId root, const Corners& at, const Vec3d* apex,
                                         const EdgeSliding& sliding) {
    const auto next = [&] { return patches_.mesh().next(root); };
    const auto position = [&](const Vec2d& p) {
        return p.x > 1 ? position_at(next(), {p.y, 2 - p.x}) : position_at(root, p);
    };
    const bool in_one = std::ranges::all_of(at, [](const Vec2d& p) { return p.x <= 1; });
    Piece piece{at, {0, 1, 2}};
    const Node* const cell = in_one ? &locate(root, piece.at) : nullptr;
    const Vec3d last = position(at[2]);
    face_.set({position(at[0]), position(at[1]), apex ? *apex : last}, sliding);
    start_with_face();
    if (apex && !attain(glm::length(last - *apex))) return finish();
    // The middle of the base decides most leaves that must be split.
    if (k_corners == 4 && !attain(node_error(face_.local(position(0.5 * (at[0] + at[1]))), 0))) return finish();
    if (in_one && cell->kind == Node::Kind::regular)
        bound_regular(*cell, piece);
    else if (in_one)
        bound_irregular(*cell, piece, 0, k_most_quarterings);
    else
        for_each_corner_cell(piece, [&](const detail::LabelledPolygon& part, bool is_next) {
            part.for_each_triangle([&](const Piece& of) {
                bound_cell(patches_.root_node(is_next ? next() : root), of, k_most_quarterings);
            });
        });
    return finish();
}

template <class Shape>
const Vec3d& CellBounder<Shape>::position_at(HalfedgeId root, const Vec2d& p) {
    const auto hash = static_cast<std::size_t>(256 * p.x + 4096 * p.y) + 61 * std::size_t{root.value};
    Known& known = known_[hash % known_.size()];
    if (known.root != root || known.at != p) known = {root, p, patches_.position(root, p.x, p.y)};
    return known.position;
}

template <class Shape>
auto CellBounder<Shape>::locate(HalfedgeId root, Corners& at) const -> const Node& {
    const Node* cell = &patches_.root_node(root);
    while (cell->kind != Node::Kind::regular) {
        const int quarter = detail::quarter_of((at[0] + at[1] + at[2]) / 3.0, k_corners);
        Corners below;
        for (std::size_t k = 0; k < 3; ++k) below[k] = detail::in_quarter(at[k], quarter, k_corners);
        if (!std::ranges::all_of(below, [](const Vec2d& p) { return detail::is_in_cell(p, k_corners); })) break;
        at = below;
        cell = cell->grown() + quarter;
    }
    return *cell;
}

template <class Shape>
void CellBounder<Shape>::bound_cell(const Node& cell, const Piece& piece, int depth) {
    if (rejected_) return;
    if (cell.kind == Node::Kind::regular) return bound_regular(cell, piece);
    std::array<Vec3d, 3> corner;
    for (std::size_t k = 0; k < 3; ++k) corner[k] = face_.local(patches_.position(cell, piece.at[k]));
    bound_irregular(cell, piece, corner_error(corner, piece.edge), depth);
}

template <class Shape>
void CellBounder<Shape>::bound_irregular(const Node& cell, const Piece& piece, double at_corners, int depth) {
    if (!attain(at_corners)) return;
    if (cell.kind == Node::Kind::star) {
        Piece in_star = piece;
        for (Vec2d& p : in_star.at) p = detail::turned(p, cell.turn, k_corners);
        const auto least = std::ranges::min_element(in_star.at, {}, [](const Vec2d& p) { return std::pair(p.x, p.y); });
        const auto first = least - in_star.at.begin();
        std::ranges::rotate(in_star.at, in_star.at.begin() + first);
        std::ranges::rotate(in_star.edge, in_star.edge.begin() + first);
        if (const auto* pieces = detail::StarPieces<Shape>::of(*cell.star, in_star.at))
            return bound_star(cell, *pieces, in_star.edge, at_corners, depth);
    }
    const auto by_hull = [&](bool may_split) {
        if (cell.kind == Node::Kind::star) return hull_error(cell.star->points, piece.edge, may_split);
        return hull_error(cell.rings->points(), piece.edge, may_split);
    };
    if (!needs_split(depth, by_hull)) return;
    for (int k = 0; k < 4; ++k) {
        const int quarter = k_corners == 4 ? k : 3 - k;  // a triangle's irregular quarter last
        in_quarter(piece, quarter, k_corners).for_each_triangle([&](const Piece& part) {
            bound_cell(cell.grown()[quarter], part, depth - 1);
        });
    }
}

template <class Shape>
void CellBounder<Shape>::bound_star(const Node& cell, const detail::StarPieces<Shape>& pieces, const Edges& edge,
                                    double at_corners, int depth) {
    using Pieces = detail::StarPieces<Shape>;
    const std::span<const Vec3d> points(cell.star->points);
    const auto fit = pieces.fit(points);
    if (!needs_split(depth, [&](bool) { return pieces.whole.deviation(fit) + at_corners; })) return;
    const auto of_leaf = [&](Edges sides) {
        for (int& side : sides) side = side < 0 ? -1 : edge[static_cast<std::size_t>(side)];
        return sides;
    };
    for (const auto& part : pieces.regular)
        bound_patch(detail::combined<Pieces::k_degree>(points, part.weights), of_leaf(part.edge));
    for (const auto& part : pieces.inner) {
        const detail::BezierTriangle<1> at = detail::combined<1>(points, part.corners);
        Piece piece{part.piece.at, of_leaf(part.piece.edge)};
        const double error = corner_error({face_.local(at[0]), face_.local(at[1]), face_.local(at[2])}, piece.edge);
        if (!attain(error) || settled(part.norms.deviation(fit) + error + pad_)) continue;
        for (Vec2d& p : piece.at) p = detail::turned(p, k_corners - cell.turn, k_corners);
        bound_irregular(cell.grown()[cell.turn], piece, error, depth - 1);
    }
}

template <class Shape>
void CellBounder<Shape>::bound_regular(const Node& cell, const Piece& piece) {
    if constexpr (k_corners == 3) {
        bound_patch(detail::polynomial_over(cell.patch, piece.at), piece.edge);
    } else if (!cell.patch.crease) {
        bound_bicubic(cell.patch, 0, piece);
    } else {
        // Strips along the crease, each of which is one bicubic patch.
        const detail::SideCrease crease = cell.patch.crease;
        const auto distance = [&](const Vec2d& p) {
            const double t = p[crease.axis()];
            return crease.far() ? 1 - t : t;
        };
        const detail::CreasePieces strips = detail::crease_pieces(crease.sharpness);
        for (int s = 0; s < strips.count; ++s) {
            const detail::CreasePieces::Piece& strip = strips.piece[static_cast<std::size_t>(s)];
            detail::LabelledPolygon(piece)
                .clipped([&](const Vec2d& p) { return distance(p) - strip.begin; })
                .clipped([&](const Vec2d& p) { return strip.end - distance(p); })
                .for_each_triangle([&](const Piece& part) {
                    if (!rejected_) bound_bicubic(cell.patch, s, part);
                });
        }
    }
}

template <class Shape>
void CellBounder<Shape>::bound_bicubic(const detail::QuadShape::Patch& cell, int strip, Piece piece) {
    // The longest side becomes side 0, which is bisected.
    auto& [at, edge] = piece;
    const std::array length{glm::distance(at[0], at[1]), glm::distance(at[1], at[2]), glm::distance(at[2], at[0])};
    const auto longest = std::ranges::max_element(length) - length.begin();
    std::ranges::rotate(at, at.begin() + longest);
    std::ranges::rotate(edge, edge.begin() + longest);
    // The control net over the piece's bounding box alone.
    const Vec2d low = glm::min(glm::min(at[0], at[1]), at[2]), high = glm::max(glm::max(at[0], at[1]), at[2]);
    const bool whole = !cell.crease && low == Vec2d(0) && high == Vec2d(1);
    const detail::Net16 net = whole ? cell.net : net_over(cell.net, cell.crease, strip, low, high);
    for (Vec2d& p : at)
        for (int k = 0; k < 2; ++k) p[k] = high[k] > low[k] ? (p[k] - low[k]) / (high[k] - low[k]) : 0;
    bound_patch(detail::polynomial_over(net, at), edge);
}

template class CellBounder<detail::QuadShape>;
template class CellBounder<detail::LoopShape>;

}  // namespace tetrakis
