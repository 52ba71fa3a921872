#pragma once

#include "random_mesh.hpp"

#include "../../hier/mesh/triangulate.hpp"
#include "../../refine/adaptive/hierarchy.hpp"

#include <doctest/doctest.h>

#include <array>
#include <set>
#include <string_view>
#include <vector>

// Hierarchies for tests: random meshes that a scheme takes, random sequences of changes.
namespace tetrakis::test {

/// One scheme of each family.
inline constexpr std::string_view k_each_family[] = {"catmull-clark", "loop", "doo-sabin", "sqrt3"};

/// Random triangles, closed or with a boundary, by each boundary rule. By seed: without inner tags; with holes, some
/// creases and corners, infinitely sharp and semi-sharp; or with so many creases that they meet.
inline ControlMesh random_sqrt3_mesh(std::uint64_t seed) {
    RandomMeshOptions options = random_options(seed);
    options.triangles_only = true;
    if (seed % 3 == 0) options.hole = 0;
    options.crease = std::array{0.0, 0.15, 0.4}[seed % 3];
    options.corner = seed % 3 == 0 ? 0 : 0.05;
    if (seed % 7 == 4) {
        options.boundary_rule = BoundaryRule::none;
        // This rule makes faces at the boundary holes: use it if it leaves more than half of the faces.
        const ControlMesh mesh = random_mesh(seed, options);
        std::uint32_t holes = 0;
        for (std::uint32_t f = 0; f < mesh.face_count(); ++f) holes += mesh.is_hole(FaceId(f)) ? 1 : 0;
        if (2 * holes < mesh.face_count()) return mesh;
    }
    options.boundary_rule = seed % 2 == 0 ? BoundaryRule::edge_and_corner : BoundaryRule::edge_only;
    return random_mesh(seed, options);
}

inline ControlMesh hierarchy_mesh(std::string_view scheme, std::uint64_t seed) {
    if (scheme == "sqrt3") return random_sqrt3_mesh(seed);
    if (find_scheme(scheme)->lattice == FanLattice::dual)
        return seed % 2 == 1 ? random_creased_dual_mesh(seed) : random_dual_mesh(seed);
    const ControlMesh mesh = random_mesh(seed);
    const bool triangles = find_scheme(scheme)->family == MeshFamily::triangles;
    return triangles ? triangulate(mesh) : ControlMesh::build(mesh.data());
}

inline void check_sound(const Hierarchy& h) {
    const auto fault = h.check();
    CHECK_MESSAGE(!fault, fault.value_or(""));
}

inline LeafPredicate everything() {
    return each_leaf([](const LeafView&) { return true; });
}

inline std::vector<LeafHandle> leaves_of(const Hierarchy& h) { return {h.leaves().begin(), h.leaves().end()}; }

inline std::set<HierarchyNode> nodes_of(const Hierarchy& h) {
    std::set<HierarchyNode> nodes;
    for (LeafHandle leaf : h.leaves()) nodes.insert(h.node(leaf));
    return nodes;
}

/// Random changes, by the round: a dozen single splits and merges, or one bulk split or merge. Leaves of max_depth are
/// split for the closure of others alone. `seen` is called after each round.
template <class Seen>
void random_changes(Hierarchy& h, int rounds, int max_depth, Random& random, Seen&& seen) {
    for (int round = 0; round < rounds; ++round) {
        const std::vector<LeafHandle> all = leaves_of(h);
        if (all.empty()) return;
        const auto shallow = [&](LeafHandle leaf) { return h.node(leaf).depth < max_depth; };
        if (round % 10 == 3) {
            auto some = random_subset(all, 0.15, random);
            std::erase_if(some, [&](LeafHandle leaf) { return !shallow(leaf); });
            h.refine(some);
        } else if (round % 10 == 8) {
            h.coarsen(random_subset(all, 0.9, random));
        } else {
            for (int i = 0; i < 12; ++i) {
                const LeafHandle leaf = all[random.below(static_cast<std::uint32_t>(all.size()))];
                if (!h.is_leaf(leaf)) continue;
                if (random.chance(0.55)) {
                    if (shallow(leaf)) h.refine(leaf);
                } else if (h.can_coarsen(leaf)) {
                    h.coarsen(leaf);
                }
            }
        }
        seen();
    }
}

/// Whether two meshes agree in all data that must depend on the set of leaves alone.
inline bool same_mesh(const HierarchyMesh& a, const HierarchyMesh& b) {
    return same_bytes(a.mesh.positions, b.mesh.positions) && same_bytes(a.mesh.normals, b.mesh.normals) &&
           a.mesh.face_offsets == b.mesh.face_offsets && a.mesh.face_vertices == b.mesh.face_vertices &&
           a.sites == b.sites && a.faces == b.faces;
}

}  // namespace tetrakis::test
