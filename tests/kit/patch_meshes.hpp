#pragma once

#include "random_mesh.hpp"

#include "../../eval/distance/surface_family.hpp"
#include "../../hier/forest/bisection_path.hpp"

#include <algorithm>
#include <array>
#include <type_traits>

namespace tetrakis::test {

/// Small random meshes with tags of all kinds and faces that the patch family accepts. Seeds 2 k and 2 k + 1 differ in
/// the crease method alone. Every third mesh has so many creases that chains of them meet.
template <class Family>
ControlMesh random_patch_mesh(std::uint64_t seed) {
    const std::uint64_t mesh = seed / 2;
    RandomMeshOptions options = random_options(mesh);
    options.columns = std::min(options.columns, 4);
    options.rows = std::min(options.rows, 4);
    options.triangles_only = std::is_same_v<Family, LoopFamily>;
    if (mesh % 3 == 0) options.crease = 0.5;
    if (mesh % 4 == 1) options.split = options.merge = 0;
    ControlMeshData data = random_mesh_data(mesh, options);
    data.crease_method = seed % 2 == 1 ? CreaseMethod::chaikin : CreaseMethod::uniform;
    return ControlMesh::build(std::move(data));
}

/// One half-edge for each root of the surface: a root is a whole face (Loop), or one corner of a face.
template <class Family>
std::vector<HalfedgeId> roots_of(const ControlMesh& mesh) {
    std::vector<HalfedgeId> roots;
    for (std::uint32_t h = 0; h < mesh.halfedge_count(); ++h) {
        const FaceId face = mesh.face(HalfedgeId(h));
        if (std::is_same_v<Family, LoopFamily> && mesh.face_halfedge(face).value != h) continue;
        if (!mesh.is_hole(face)) roots.push_back(HalfedgeId(h));
    }
    return roots;
}

/// A random leaf of the bisection: a root, or a half or a quarter of a cell (odd and even depths).
inline CellTriangle random_quad_leaf(Random& random, const ControlMesh& mesh, HalfedgeId cell, int deepest) {
    BisectionShape shape = BisectionShape::root();
    const int depths = static_cast<int>(random.below(static_cast<std::uint32_t>(2 * deepest + 2)));
    for (int depth = 0; depth < depths; ++depth) {
        const int bit = static_cast<int>(random.below(2));
        if (depth == 0 && bit == 1) cell = mesh.next(cell);
        shape = shape.child(depth, bit);
    }
    return shape.in(cell, depths);
}

/// A random red triangle of a root, or one of its green parts.
inline CellTriangle random_loop_leaf(Random& random, HalfedgeId root, int deepest) {
    const auto below = [&](std::uint32_t n) { return random.below(n); };
    const int level = static_cast<int>(below(static_cast<std::uint32_t>(deepest) + 1));
    const std::uint32_t side = 1u << level;
    std::array<LatticePoint, 3> c;
    const std::uint32_t x = below(side), y = below(side - x);
    const bool inverted = x + y + 2 <= side && below(2) == 1;
    if (inverted)
        c = {LatticePoint{x + 1, y + 1}, {x, y + 1}, {x + 1, y}};
    else
        c = {LatticePoint{x, y}, {x + 1, y}, {x, y + 1}};
    const std::uint32_t green = below(4);
    if (green < 2) return {root, static_cast<std::uint8_t>(level), c};
    std::array<LatticePoint, 3> p, m;
    for (int k = 0; k < 3; ++k) p[k] = {2 * c[k].x, 2 * c[k].y};
    for (int k = 0; k < 3; ++k) m[k] = {c[k].x + c[(k + 1) % 3].x, c[k].y + c[(k + 1) % 3].y};
    const std::uint32_t k = below(3), k1 = (k + 1) % 3, k2 = (k + 2) % 3;
    CellTriangle leaf{root, static_cast<std::uint8_t>(level + 1), {}};
    if (green == 2)
        leaf.corner = below(2) ? std::array{p[k], p[k1], m[k1]} : std::array{p[k], m[k1], p[k2]};
    else
        leaf.corner = below(2) ? std::array{p[k], m[k], m[k1]} : std::array{p[k], m[k1], m[k2]};
    const std::uint32_t turn = below(3);
    std::rotate(leaf.corner.begin(), leaf.corner.begin() + turn, leaf.corner.end());
    return leaf;
}

template <class Family>
CellTriangle random_leaf(Random& random, const ControlMesh& mesh, int deepest) {
    if constexpr (std::is_same_v<Family, LoopFamily>)
        return random_loop_leaf(random, mesh.face_halfedge(FaceId(random.below(mesh.face_count()))), deepest);
    else
        return random_quad_leaf(random, mesh, HalfedgeId(random.below(mesh.halfedge_count())), deepest);
}

}  // namespace tetrakis::test
