#include "quad_bounder.hpp"
#include "quad_lattice.hpp"

#include <cmath>

namespace tetrakis {

using detail::WalkCell;

void QuadBounder::sample(const CellTriangle& leaf, int n, std::span<Vec3d> positions, std::span<Vec3d> normals) {
    if (normals.empty() && !is_root(leaf) && (n == 2 || n == 4 || n == 8)) {
        const Piece piece = piece_of(leaf);
        const WalkCell& cell = home(piece);
        if (cell.smooth()) {
            // The piece's corners are the leaf's 2, 0, 1.
            const detail::LatticeShape shape(piece.turn, piece.quarter, n);
            const detail::LatticeColumns columns(*cell.net, shape);
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
