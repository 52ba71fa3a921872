// Adaptive refinement by hand: refine near a point, visit neighbours, make a mesh without cracks, go back to the roots.
#include <tetrakis/tetrakis.hpp>

#include <iostream>

int main() {
    const auto cage = tetrakis::load_control_mesh("data/rook.obj");
    tetrakis::Hierarchy hierarchy = tetrakis::make_hierarchy(cage, "catmull-clark");
    const auto roots = hierarchy.leaf_count();

    // A predicate may use any property of the leaf alone, such as the limit points of its corners.
    const tetrakis::Vec3d eye = cage.bounding_box().upper;
    const double radius = 0.25 * cage.bounding_box().diagonal();
    const auto near = tetrakis::each_leaf([&](const tetrakis::LeafView& leaf) {
        return glm::distance(hierarchy.limit(leaf.corner[0]).position, eye) < radius;
    });
    hierarchy.refine_where(near, 8);
    std::cout << roots << " roots, " << hierarchy.leaf_count() << " leaves after refinement near a point\n";

    // Neighbours differ by one level at most. A handle stays valid until its leaf is split or merged.
    const tetrakis::LeafHandle leaf = hierarchy.leaves()[hierarchy.leaf_count() / 2];
    for (int side = 0; side < hierarchy.view(leaf).sides(); ++side)
        for (const tetrakis::LeafHandle neighbour : hierarchy.neighbours(leaf, side))
            std::cout << "depth " << int(hierarchy.node(leaf).depth) << ", across side " << side << ": depth "
                      << int(hierarchy.node(neighbour).depth) << '\n';
    hierarchy.refine(leaf);  // also splits the leaves that must be split for it

    const tetrakis::HierarchyMesh mesh = hierarchy.to_mesh({.normals = true});
    std::cout << mesh.mesh.face_count() << " faces, " << mesh.mesh.positions.size() << " vertices\n";

    hierarchy.coarsen_where(tetrakis::each_leaf([](const tetrakis::LeafView&) { return true; }));
    std::cout << "coarsened again: " << hierarchy.leaf_count() << " leaves, "
              << (hierarchy.leaf_count() == roots ? "as at the start\n" : "not as at the start\n");
}
