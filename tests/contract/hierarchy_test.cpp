#include "../kit/hierarchy_helpers.hpp"
#include "../kit/input_helpers.hpp"
#include "../kit/scratch_dir.hpp"
#include "../kit/surface_topology.hpp"

#include "../../hier/base/error.hpp"
#include "../../refine/adaptive/hierarchy.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <map>
#include <set>
#include <string_view>
#include <utility>
#include <vector>

// Properties that hold for hierarchies of all schemes after any history of changes.

using namespace tetrakis;
using test::everything;
using test::Random;

namespace {

/// Some schemes of each family, whose points are computed by kernels or by the scheme's rules.
constexpr std::string_view k_schemes[] = {"catmull-clark", "4-8",       "kobbelt", "loop",
                                          "tuned-loop",    "doo-sabin", "midedge", "sqrt3"};

/// A random mesh that the scheme accepts. For dual schemes: with infinitely sharp tags, all kinds of tags, or none.
ControlMesh mesh_for(std::string_view scheme, std::uint64_t seed) {
    if (scheme == "sqrt3") return test::random_sqrt3_mesh(seed);
    test::RandomMeshOptions options = test::random_options(seed);
    options.columns = options.rows = 3 + static_cast<int>(seed % 2);
    if (find_scheme(scheme)->lattice == FanLattice::dual) {
        options.crease = seed % 2 == 1 ? 0.25 : 0;
        options.corner = seed % 2 == 1 ? 0.1 : 0;
        return test::random_dual_mesh(seed, options,
                                      seed % 4 == 3 ? test::DualTags::of_all_kinds : test::DualTags::infinitely_sharp);
    }
    options.triangles_only = find_scheme(scheme)->family == MeshFamily::triangles;
    return test::random_mesh(seed, options);
}

/// Calls check(scheme, mesh, random) for all schemes with some meshes each.
template <class Check>
void for_each_mesh(std::uint64_t meshes, Check&& check) {
    for (const std::string_view scheme : k_schemes)
        for (const std::uint64_t seed : test::seeds(meshes)) {
            CAPTURE(scheme);
            CAPTURE(seed);
            const ControlMesh mesh = mesh_for(scheme, seed);
            Random random(seed);
            check(scheme, mesh, random);
        }
}

/// Approximate depth of leaves after that many levels.
int depth_of(const Hierarchy& h, int levels) { return h.tree().child_count == 4 ? levels : 2 * levels; }

void random_history(Hierarchy& h, Random& random, int rounds = 40) {
    test::random_changes(h, rounds, depth_of(h, 3), random, [] {});
}

HierarchyMesh with_normals(const Hierarchy& h) {
    // No limit positions: some schemes have them for some vertices only.
    return h.to_mesh({.positions = MeshPositions::finest, .normals = true});
}

ErrorCode code_of(auto&& call) { return test::error_of(call).code(); }

}  // namespace

TEST_SUITE_BEGIN("contract");

TEST_CASE("hierarchy: the same leaves give the same bytes, refined to at once, one by one, or coarsened to") {
    for_each_mesh(4, [](std::string_view scheme, const ControlMesh& mesh, Random& random) {
        Hierarchy h = make_hierarchy(mesh, scheme);
        if (h.leaf_count() == 0) return;
        random_history(h, random);
        const std::set<HierarchyNode> target = test::nodes_of(h);
        const HierarchyMesh expected = with_normals(h);
        CHECK(target.size() == h.leaf_count());

        Hierarchy at_once = make_hierarchy(mesh, scheme);
        const LeafPredicate above = each_leaf([&](const LeafView& leaf) { return !target.contains(leaf.node); });
        at_once.refine_where(above, at_once.tree().max_depth);
        CHECK(test::nodes_of(at_once) == target);
        CHECK(test::same_mesh(with_normals(at_once), expected));

        Hierarchy one_by_one = make_hierarchy(mesh, scheme);
        for (bool changed = true; changed;) {
            changed = false;
            std::vector<LeafHandle> leaves = test::leaves_of(one_by_one);
            random.shuffle(leaves);
            for (const LeafHandle leaf : leaves) {
                if (!one_by_one.is_leaf(leaf) || target.contains(one_by_one.node(leaf))) continue;
                CHECK(!one_by_one.refine(leaf).empty());
                changed = true;
            }
        }
        CHECK(test::nodes_of(one_by_one) == target);
        CHECK(test::same_mesh(with_normals(one_by_one), expected));

        Hierarchy down = make_hierarchy(mesh, scheme);
        int deepest = 0;
        for (const HierarchyNode& node : target) deepest = std::max<int>(deepest, node.depth);
        down.refine_where(everything(), deepest);
        // sqrt3: a whole triangle becomes the wanted half by a merge on the other side of its edge.
        const auto stays = [&](const HierarchyNode& node) {
            return target.contains(node) || (down.tree().halves && node.depth > 0 && node.depth % 2 == 0 &&
                                             target.contains(down.tree().parent(node)));
        };
        down.coarsen_where(each_leaf([&](const LeafView& leaf) { return !stays(leaf.node); }));
        CHECK(test::nodes_of(down) == target);
        CHECK(test::same_mesh(with_normals(down), expected));
    });
}

TEST_CASE(
    "hierarchy: meshes are conforming, with the control mesh's topology, neighbours share edges and are one level "
    "apart") {
    for_each_mesh(6, [](std::string_view scheme, const ControlMesh& mesh, Random& random) {
        Hierarchy h = make_hierarchy(mesh, scheme);
        const bool dual = h.family() == "vertices";
        random_history(h, random);
        const HierarchyMesh out = with_normals(h);
        const auto faces = test::faces_of(out.mesh);
        const auto expected = test::surface_topology(mesh), found = test::topology(faces);
        CHECK(found.fault.empty());
        // Dual faces extend across borders of holes, and can be missing at borders with creases.
        if (!dual || mesh.data().holes.empty()) {
            CHECK(found.euler == expected.euler);
            CHECK(found.boundary_loops == expected.boundary_loops);
        }
        std::map<LeafHandle, std::set<LeafHandle>> beside;
        for (const LeafHandle leaf : h.leaves())
            for (int side = 0; side < h.view(leaf).sides(); ++side)
                for (const LeafHandle across : h.neighbours(leaf, side)) {
                    REQUIRE(std::abs(h.view(across).level - h.view(leaf).level) <= 1);
                    beside[leaf].insert(across);
                }
        for (const auto& [leaf, others] : beside)
            for (const LeafHandle other : others) REQUIRE(beside[other].contains(leaf));
        if (!dual) {
            // By the mesh: the other leaves whose faces share an edge with a face of the leaf.
            std::map<std::pair<std::uint32_t, std::uint32_t>, LeafHandle> owner;  // by directed edge
            std::map<LeafHandle, std::set<LeafHandle>> in_mesh;
            for (std::size_t f = 0; f < faces.size(); ++f)
                for (std::size_t i = 0; i < 3; ++i) owner[{faces[f][i], faces[f][(i + 1) % 3]}] = out.leaves[f];
            for (const auto& [edge, leaf] : owner)
                if (const auto twin = owner.find({edge.second, edge.first});
                    twin != owner.end() && twin->second != leaf)
                    in_mesh[leaf].insert(twin->second);
            CHECK(beside == in_mesh);
        }
        test::check_sound(h);
    });
}

TEST_CASE("hierarchy: no face, one triangle, a mesh of holes, and two triangles glued along all edges refine as well") {
    ControlMeshData one = test::mesh_data({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}), hole = one;
    hole.holes = {0};
    const ControlMesh triangle = ControlMesh::build(one), empty = ControlMesh::build(hole),
                      pillow = ControlMesh::build(test::mesh_data(one.positions, {{0, 1, 2}, {2, 1, 0}})), nothing;
    for (const std::string_view scheme : k_schemes) {
        CAPTURE(scheme);
        CHECK(make_hierarchy(empty, scheme).to_mesh().mesh.face_count() == 0);
        if (scheme != "sqrt3") CHECK(make_hierarchy(nothing, scheme).leaf_count() == 0);  // sqrt3 needs triangles
        Random random(7);
        for (const ControlMesh* mesh : {&triangle, &pillow}) {
            if (mesh == &pillow && find_scheme(scheme)->lattice == FanLattice::dual) continue;  // vertices of two faces
            Hierarchy h = make_hierarchy(*mesh, scheme);
            for (int i = 0; i < 10; ++i) {
                random_history(h, random, 20);
                test::check_sound(h);
                const HierarchyMesh out = h.to_mesh({.positions = MeshPositions::finest});
                // Several edges of the pillow join the same points: only Euler's formula is checked.
                if (mesh == &pillow)
                    CHECK(out.mesh.face_count() + 4 == 2 * out.mesh.positions.size());
                else
                    CHECK(test::topology(test::faces_of(out.mesh)) == test::surface_topology(triangle));
            }
        }
    }
}

TEST_CASE("hierarchy: what is coarsened as far as it goes is the roots again, by a predicate or one by one") {
    for_each_mesh(3, [](std::string_view scheme, const ControlMesh& mesh, Random& random) {
        Hierarchy h = make_hierarchy(mesh, scheme);
        const HierarchyMesh roots = with_normals(h);
        const std::set<HierarchyNode> nodes = test::nodes_of(h);
        random_history(h, random);
        const std::vector<std::byte> leaves = h.saved();
        h.coarsen_where(everything());
        CHECK(test::nodes_of(h) == nodes);
        CHECK(test::same_mesh(with_normals(h), roots));
        h.load(leaves);
        for (bool merged = true; merged;) {
            merged = false;
            for (const LeafHandle leaf : test::leaves_of(h))
                if (h.is_leaf(leaf) && h.can_coarsen(leaf)) {
                    h.coarsen(leaf);
                    merged = true;
                }
        }
        CHECK(test::nodes_of(h) == nodes);
        CHECK(test::same_mesh(with_normals(h), roots));
    });
}

TEST_CASE("hierarchy: saved leaves come back with the same bytes, from memory and from a file, and go on from there") {
    const ScratchDir scratch;
    for_each_mesh(2, [&](std::string_view scheme, const ControlMesh& mesh, Random& random) {
        Hierarchy h = make_hierarchy(mesh, scheme);
        random_history(h, random);
        const std::vector<std::byte> bytes = h.saved();
        Hierarchy other = make_hierarchy(mesh, scheme);
        const std::vector<LeafHandle> old = test::leaves_of(other);
        other.load(bytes);
        for (const LeafHandle leaf : old) CHECK(!other.is_leaf(leaf));
        CHECK(test::nodes_of(other) == test::nodes_of(h));
        CHECK(test::same_mesh(with_normals(other), with_normals(h)));
        CHECK(other.saved() == bytes);
        h.save(scratch.path() / "leaves");
        Hierarchy third = make_hierarchy(mesh, scheme);
        third.load(scratch.path() / "leaves");
        CHECK(test::same_mesh(with_normals(third), with_normals(h)));
        random_history(third, random, 10);
        test::check_sound(third);
        // The leaves also load for the same faces with other points: an animated control mesh.
        ControlMeshData moved_data = mesh.data();
        for (Vec3d& p : moved_data.positions) p = Vec3d(2 * p.y, p.z + 0.1 * std::sin(5 * p.x), p.x);
        const ControlMesh moved_mesh = ControlMesh::build(std::move(moved_data));
        Hierarchy moved = make_hierarchy(moved_mesh, scheme);
        moved.load(bytes);
        CHECK(test::nodes_of(moved) == test::nodes_of(h));
        CHECK(moved.saved() == bytes);
        test::check_sound(moved);
        // They do not load with one more crease, because dual schemes and sqrt3 number their roots by creases.
        for (std::uint32_t e = 0; e < mesh.edge_count(); ++e) {
            const HalfedgeId halfedge = mesh.edge_halfedge(EdgeId(e));
            if (mesh.sharpness(EdgeId(e)) != 0 || !mesh.twin(halfedge).valid()) continue;
            ControlMeshData creased_data = mesh.data();
            creased_data.creases.push_back({mesh.origin(halfedge).value, mesh.target(halfedge).value, 2});
            const ControlMesh creased_mesh = ControlMesh::build(std::move(creased_data));
            Hierarchy creased = make_hierarchy(creased_mesh, scheme);
            CHECK(code_of([&] { creased.load(bytes); }) == ErrorCode::invalid_input);
            break;
        }
        // Truncated bytes are refused, and nothing changes.
        const HierarchyMesh before = with_normals(third);
        CHECK(code_of([&] { third.load(std::span(bytes).first(bytes.size() - 1)); }) == ErrorCode::invalid_input);
        CHECK(test::same_mesh(with_normals(third), before));
    });
}

TEST_CASE("hierarchy: one and two threads give the same bytes and the same handles") {
    for_each_mesh(2, [](std::string_view scheme, const ControlMesh& mesh, Random&) {
        const auto run = [&](int threads) {
            const RunContext context = test::with_thread_count(threads);
            Hierarchy h = make_hierarchy(mesh, scheme, {.context = context});
            h.refine_where(each_leaf([](const LeafView& leaf) {
                               return (leaf.node.root * 7 + leaf.node.depth) % 3 != 0 || leaf.node.depth < 2;
                           }),
                           depth_of(h, 3), context);
            h.coarsen_where(each_leaf([](const LeafView& leaf) { return leaf.node.root % 5 == 0; }), context);
            HierarchyMesh out = h.to_mesh({.positions = MeshPositions::finest, .normals = true, .context = context});
            return std::pair(std::move(out), test::leaves_of(h));
        };
        const auto one = run(1), two = run(2);
        CHECK(test::same_mesh(one.first, two.first));
        CHECK(one.first.points == two.first.points);
        CHECK(one.first.leaves == two.first.leaves);
        CHECK(one.second == two.second);
    });
}

TEST_CASE("hierarchy: handles of leaves that are gone are refused by all that takes them, and nothing changes") {
    for_each_mesh(2, [](std::string_view scheme, const ControlMesh& mesh, Random& random) {
        Hierarchy h = make_hierarchy(mesh, scheme);
        if (h.leaf_count() == 0) return;
        std::set<LeafHandle> gone;
        for (int round = 0; round < 8; ++round) {
            const std::vector<LeafHandle> before = test::leaves_of(h);
            random_history(h, random, 2);
            for (const LeafHandle leaf : before)
                if (!h.is_leaf(leaf)) gone.insert(leaf);
        }
        REQUIRE(!gone.empty());
        for (const LeafHandle leaf : h.leaves()) CHECK(!gone.contains(leaf));
        const std::vector<LeafHandle> leaves = test::leaves_of(h);
        const LeafHandle good = leaves[0];
        std::size_t looked_at = 0;
        for (const LeafHandle leaf : gone) {
            if (++looked_at > 20) break;
            CHECK(!h.is_leaf(leaf));
            const std::vector<LeafHandle> both{good, leaf};
            CHECK(code_of([&] { h.refine(leaf); }) == ErrorCode::invalid_input);
            CHECK(code_of([&] { h.refine(both); }) == ErrorCode::invalid_input);
            CHECK(code_of([&] { h.coarsen(leaf); }) == ErrorCode::invalid_input);
            CHECK(code_of([&] { h.coarsen(both); }) == ErrorCode::invalid_input);
            CHECK(code_of([&] { (void)h.can_coarsen(leaf); }) == ErrorCode::invalid_input);
            CHECK(code_of([&] { (void)h.node(leaf); }) == ErrorCode::invalid_input);
            CHECK(code_of([&] { (void)h.view(leaf); }) == ErrorCode::invalid_input);
            CHECK(code_of([&] { (void)h.neighbours(leaf, 0); }) == ErrorCode::invalid_input);
        }
        CHECK(test::leaves_of(h) == leaves);
    });
}

TEST_SUITE_END();
