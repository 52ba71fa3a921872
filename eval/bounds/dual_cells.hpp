#pragma once

#include "../../hier/base/vec.hpp"
#include "../../hier/trees/vertex_roots.hpp"
#include "../../refine/points/level_source.hpp"
#include "bezier_pieces.hpp"
#include "labelled_polygon.hpp"

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <unordered_map>
#include <vector>

namespace tetrakis::detail {

/// A triangle of a cell, in lengths of the cell's sides; its edge numbers are those of the mesh's face.
using DualPiece = LabelledTriangle;

/// Control points of the limit surface of a quadratic dual scheme, by cells of the vertex quadtrees. A cell is regular
/// if four cells meet at each of its corners; across boundaries and creases its control points are repeated, as the
/// schemes' rules have it. Its surface then depends on its own control point and the eight around. Other cells touch an
/// extraordinary point. Of their quarters three are regular; the surface over the fourth lies in the convex hull of the
/// control points around the extraordinary point, because no mask has a negative weight.
class DualCells {
  public:
    static constexpr std::uint32_t k_none = 0xFFFF'FFFFu;
    /// Levels below a leaf at which the cell at an extraordinary point is bounded by the hull.
    static constexpr int k_hull_levels = 3;

    /// An extraordinary point: where not four roots meet, or where a crease ends inside. In cells of level 0.
    using Point = VertexRoots::Fan;

    /// Keeps references to both.
    DualCells(const LevelSource& points, const VertexRoots& roots);

    std::span<const Point> points() const { return points_; }
    /// Number of the extraordinary point at a corner of a cell, or k_none.
    std::uint32_t point(const VertexCell& cell, int corner) const;
    /// Position of a cell's vertex in the cell, in lengths of its sides: in the middle, or on a side where the surface
    /// ends or a crease runs.
    Vec2d vertex(const VertexCell& cell) const;

    /// Finds the control points that visit() needs of these leaves.
    void find(std::span<const VertexCell> leaves, const std::function<void(double)>& tell, int levels = k_hull_levels);
    /// Visits the parts of the surface over a piece of a leaf.
    /// @param on_net   called with (net, piece) for each part in a regular cell
    /// @param on_hull  called with (points) for the rest: the surface is in their convex hull
    template <class OnNet, class OnHull>
    void visit(const VertexCell& cell, const DualPiece& piece, OnNet&& on_net, OnHull&& on_hull,
               int levels = k_hull_levels) const;
    /// Visits the polynomials of the surface over a piece of a regular cell.
    /// @param take  called with (BezierTriangle, part of the piece that it is over)
    template <class Take>
    static void for_each_polynomial(const Net9& net, const DualPiece& piece, bool midedge, Take&& take);

  private:
    struct Hash {
        std::size_t operator()(const VertexCell& cell) const;
    };
    /// The neighbour across a side; none where the surface ends or a crease runs.
    std::optional<VertexRoots::Across> across(const VertexCell& cell, int side) const;
    bool irregular(const VertexCell& cell) const;
    /// Appends the cells whose control points are stored for a cell. For a regular cell: it and those around it, row by
    /// row. Else: cells of its level whose points span the hull of all cells that touch the extraordinary point.
    void add_control_cells(const VertexCell& cell, std::vector<VertexCell>& cells) const;
    std::uint32_t point_of(const VertexCell& cell) const;
    /// The cell that stores a cell's control points; at an extraordinary point, all cells share its first corner's.
    VertexCell keeper(const VertexCell& cell) const;
    void collect(const VertexCell& cell, int levels, std::vector<VertexCell>& wanted) const;
    static VertexCell quarter(const VertexCell& cell, int number) {
        const std::uint32_t x = number == 1 || number == 2, y = number >= 2;
        return {cell.root, {2 * cell.at.x + x, 2 * cell.at.y + y}, static_cast<std::uint8_t>(cell.level + 1)};
    }

    const LevelSource& source_;
    const VertexRoots& roots_;
    std::vector<Point> points_;
    std::vector<std::uint32_t> point_at_;                               // 4 per root
    std::unordered_map<VertexCell, std::vector<Vec3d>, Hash> control_;  // by keeper()
};

template <class OnNet, class OnHull>
void DualCells::visit(const VertexCell& cell, const DualPiece& piece, OnNet&& on_net, OnHull&& on_hull,
                      int levels) const {
    if (!irregular(cell)) return on_net(Net9(control_.at(cell)), piece);
    if (levels == 0) return on_hull(std::span<const Vec3d>(control_.at(keeper(cell))));
    for (int k = 0; k < 4; ++k)
        in_quarter(piece, k, 4).for_each_triangle([&](const DualPiece& part) {
            visit(quarter(cell, k), part, on_net, on_hull, levels - 1);
        });
}

template <class Take>
void DualCells::for_each_polynomial(const Net9& net, const DualPiece& piece, bool midedge, Take&& take) {
    if (!midedge) return take(polynomial_over(net, piece.at), piece);
    // The four parts of the cell between its diagonals.
    for (const int side : {0, 1, 2, 3}) {
        const double up = side >= 2 ? 1 : -1, right = side == 1 || side == 2 ? 1 : -1;
        LabelledPolygon(piece)
            .clipped([&](const Vec2d& p) { return up * (p.y - p.x); })
            .clipped([&](const Vec2d& p) { return right * (p.x + p.y - 1); })
            .for_each_triangle([&](const DualPiece& part) { take(four_direction_over(net, side, part.at), part); });
    }
}

}  // namespace tetrakis::detail
