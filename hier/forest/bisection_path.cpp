#include "bisection_path.hpp"

#include "corner_cell.hpp"

namespace tetrakis {

CellTriangle cell_triangle(const ControlMesh& mesh, HalfedgeId root, int depth, std::uint64_t path) {
    BisectionShape shape = BisectionShape::root();
    for (int d = 0; d < depth; ++d) shape = shape.child(d, static_cast<int>((path >> (depth - 1 - d)) & 1));
    return shape.in(bisection_cell(mesh, root, depth, path), depth);
}

CellTriangle child(const CellTriangle& triangle, int bit) {
    const auto& [a, b, apex] = triangle.corner;
    // A base along a diagonal of the lattice has its middle on the next level only.
    const int shift = static_cast<int>((a.x ^ b.x) & 1u);
    const auto refine = [&](LatticePoint p) { return LatticePoint{p.x << shift, p.y << shift}; };
    const LatticePoint fine_a = refine(a), fine_b = refine(b), fine_apex = refine(apex);
    const LatticePoint middle{(fine_a.x + fine_b.x) / 2, (fine_a.y + fine_b.y) / 2};
    CellTriangle result{triangle.root, static_cast<std::uint8_t>(triangle.level + shift), {}};
    result.corner = bit == 0 ? std::array{fine_apex, fine_a, middle} : std::array{fine_b, fine_apex, middle};
    return result;
}

Site corner_site(const ControlMesh& mesh, const CellTriangle& triangle, std::size_t k) {
    const std::uint32_t n = 1u << triangle.level;
    CellPoint p{triangle.root, triangle.corner[k].x, triangle.corner[k].y};
    if (p.x > n) p = cross(mesh, p, CellSide::next_cell, n);
    const LatticePoint at{static_cast<std::uint32_t>(p.x), static_cast<std::uint32_t>(p.y)};
    return canonical(mesh, {p.root, at, triangle.level});
}

}  // namespace tetrakis
