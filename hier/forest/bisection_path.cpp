#include "bisection_path.hpp"

#include "corner_cell.hpp"

namespace tetrakis {

CellTriangle cell_triangle(const ControlMesh& mesh, HalfedgeId root, int depth, std::uint64_t path) {
    BisectionShape shape = BisectionShape::root();
    for (int d = 0; d < depth; ++d) shape = shape.child(d, static_cast<int>((path >> (depth - 1 - d)) & 1));
    return shape.in(bisection_cell(mesh, root, depth, path), depth);
}

Site corner_site(const ControlMesh& mesh, const CellTriangle& triangle, std::size_t k) {
    const std::uint32_t n = 1u << triangle.level;
    CellPoint p{triangle.root, triangle.corner[k].x, triangle.corner[k].y};
    if (p.x > n) p = cross(mesh, p, CellSide::next_cell, n);
    const LatticePoint at{static_cast<std::uint32_t>(p.x), static_cast<std::uint32_t>(p.y)};
    return canonical(mesh, {p.root, at, triangle.level});
}

}  // namespace tetrakis
