#include "../kit/dual_mesh.hpp"
#include "../kit/hierarchy_helpers.hpp"
#include "../kit/point_match.hpp"
#include "../kit/surface_topology.hpp"

#include "../../hier/base/error.hpp"
#include "../../refine/adaptive/adaptive_dual.hpp"
#include "../../refine/adaptive/hierarchy.hpp"
#include "../../refine/adaptive/vertex_levels.hpp"
#include "../../refine/uniform/refine.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>

using namespace tetrakis;
using test::Random;

namespace {

void check_sound(const Hierarchy& h) {
    const auto fault = h.check();
    CHECK_MESSAGE(!fault, fault.value_or(""));
}

/// The faces of each leaf by their vertices' sites, to see which leaves' faces have changed.
std::map<LeafHandle, std::set<std::vector<Site>>> faces_by_leaf(const Hierarchy& h) {
    std::map<LeafHandle, std::set<std::vector<Site>>> result;
    const HierarchyMesh mesh = h.to_mesh({.positions = MeshPositions::finest});
    for (std::uint32_t f = 0; f < mesh.mesh.face_count(); ++f) {
        std::vector<Site> face;
        for (std::uint32_t i = mesh.mesh.face_offsets[f]; i < mesh.mesh.face_offsets[f + 1]; ++i)
            face.push_back(mesh.sites[mesh.mesh.face_vertices[i]]);
        result[mesh.leaves[f]].insert(face);
    }
    return result;
}

}  // namespace

TEST_SUITE_BEGIN("refine");

TEST_CASE("[inv2] [inv3] [inv4] [inv5] hierarchies of dual schemes: changes of all kinds, and the same leaves again") {
    for (const std::string_view scheme : {"doo-sabin", "midedge", "biquartic"})
        for (const std::uint64_t seed : test::seeds(scheme == "doo-sabin" ? 8 : 2)) {
            CAPTURE(scheme);
            CAPTURE(seed);
            const bool creased = seed % 2 == 1 && scheme != "biquartic";
            const ControlMesh mesh = creased && seed % 4 == 3 ? test::random_semi_sharp_dual_mesh(seed)
                                     : creased                ? test::random_creased_dual_mesh(seed)
                                                              : test::random_dual_mesh(seed);
            Hierarchy h = make_hierarchy(mesh, scheme);
            CHECK(h.family() == "vertices");
            const std::set<HierarchyNode> roots = test::nodes_of(h);
            Random random(seed);
            test::random_changes(h, 20, 4, random, [&] { check_sound(h); });
            const std::set<HierarchyNode> wanted = test::nodes_of(h);
            CHECK(wanted.size() > roots.size());
            const HierarchyMesh expected = h.to_mesh({.positions = MeshPositions::finest, .normals = true});
            const auto topology = test::topology(test::faces_of(expected.mesh));
            CHECK(topology.fault.empty());
            if (!creased || mesh.data().holes.empty()) CHECK(topology.euler == test::surface_topology(mesh).euler);
            // The mesh is that of the quadtrees alone.
            std::set<Site> leaf_sites;
            for (const LeafHandle leaf : h.leaves()) leaf_sites.insert(h.view(leaf).corner[0]);
            AdaptiveDual dual(mesh, *find_scheme(scheme));
            std::vector<LeafId> created;
            for (bool again = true; again;) {
                again = false;
                for (const LeafId leaf : dual.forest().ordered_leaves()) {
                    if (!dual.forest().is_leaf(leaf)) continue;
                    const Site site = cell_site(dual.forest().cell(leaf));
                    const bool finer = std::any_of(leaf_sites.begin(), leaf_sites.end(), [&](const Site& s) {
                        return s.root == site.root && s.level > site.level &&
                               s.at.x >> (s.level - site.level) == site.at.x &&
                               s.at.y >> (s.level - site.level) == site.at.y;
                    });
                    if (!finer || leaf_sites.count(site) != 0) continue;
                    dual.forest().refine({&leaf, 1}, created);
                    again = true;
                }
            }
            const PolygonMesh same = dual.to_mesh({.limit = false});
            CHECK(same.face_vertices == expected.mesh.face_vertices);
            CHECK(test::same_bytes(same.positions, expected.mesh.positions));
            // The same leaves by merging what is finer, and through a file.
            Hierarchy down = make_hierarchy(mesh, scheme);
            down.refine_where(each_leaf([](const LeafView&) { return true; }), 4);
            // What is split in the wanted set stays so; random_changes may reach one deeper by closure.
            while (test::nodes_of(down) != wanted) {
                const auto is_wanted = [&](const HierarchyNode& node) { return wanted.count(node) != 0; };
                std::vector<LeafHandle> merge, split;
                for (const LeafHandle leaf : down.leaves()) {
                    const HierarchyNode node = down.node(leaf);
                    if (is_wanted(node)) continue;
                    const auto below = wanted.upper_bound(node);
                    const bool is_split = below != wanted.end() && down.tree().is_ancestor(node, *below);
                    (is_split ? split : merge).push_back(leaf);
                }
                REQUIRE((!merge.empty() || !split.empty()));
                if (!split.empty())
                    down.refine(split);
                else
                    REQUIRE(!down.coarsen(merge).empty());
            }
            CHECK(test::same_mesh(down.to_mesh({.positions = MeshPositions::finest, .normals = true}), expected));
            Hierarchy loaded = make_hierarchy(mesh, scheme);
            loaded.load(h.saved());
            check_sound(loaded);
            CHECK(test::same_mesh(loaded.to_mesh({.positions = MeshPositions::finest, .normals = true}), expected));
            h.coarsen_where(each_leaf([](const LeafView&) { return true; }));
            CHECK(test::nodes_of(h) == roots);
        }
}

TEST_CASE("[inv1] uniform hierarchies of dual schemes have the faces that refine() keeps beside holes") {
    std::size_t with_holes = 0;
    for (const std::string_view scheme : {"doo-sabin", "midedge", "biquartic"})
        for (const std::uint64_t seed : test::seeds(scheme == "doo-sabin" ? 18 : 4)) {
            CAPTURE(scheme);
            CAPTURE(seed);
            test::RandomMeshOptions options = test::random_options(seed);
            options.hole = 0.15;
            options.crease = seed % 3 == 0 ? 0 : 0.3;
            options.corner = options.crease / 2;
            const ControlMesh mesh = test::random_dual_mesh(
                seed, options, seed % 3 == 2 ? test::DualTags::of_all_kinds : test::DualTags::infinitely_sharp);
            for (std::uint32_t f = 0; f < mesh.face_count(); ++f) with_holes += mesh.is_hole(FaceId(f)) ? 1 : 0;
            for (int level = 1; level <= (scheme == "doo-sabin" ? 3 : 2); ++level) {
                CAPTURE(level);
                Hierarchy h = make_hierarchy(mesh, scheme);
                h.refine_where(each_leaf([](const LeafView&) { return true; }), level - 1);
                const HierarchyMesh mine = h.to_mesh({.positions = MeshPositions::level, .level = level});
                const PolygonMesh expected = refine(mesh, scheme, level);
                REQUIRE(mine.mesh.face_count() == expected.face_count());
                REQUIRE(mine.mesh.positions.size() == expected.positions.size());
                const PointMatch match(expected.positions);
                std::multiset<std::set<std::uint32_t>> theirs, ours;
                // By places: midedge may have several vertices at one.
                for (const auto& face : test::faces_of(expected)) {
                    std::set<std::uint32_t> corners;
                    for (const std::uint32_t v : face) corners.insert(match.nearest(expected.positions[v]));
                    theirs.insert(corners);
                }
                double worst = 0;
                for (const auto& face : test::faces_of(mine.mesh)) {
                    std::set<std::uint32_t> corners;
                    for (const std::uint32_t v : face) {
                        const std::uint32_t nearest = match.nearest(mine.mesh.positions[v]);
                        corners.insert(nearest);
                        worst = std::max(worst, glm::length(expected.positions[nearest] - mine.mesh.positions[v]));
                    }
                    ours.insert(corners);
                }
                CHECK(ours == theirs);
                CHECK(worst < 1e-12 * mesh.bounding_box().diagonal());
            }
        }
    CHECK(with_holes > 0);
}

TEST_CASE("hierarchies as triangles: dual schemes in the 4-8 pattern, others as they are") {
    for (const std::uint64_t seed : test::seeds(6)) {
        CAPTURE(seed);
        const ControlMesh mesh = test::random_dual_mesh(seed);
        Hierarchy h = make_hierarchy(mesh, "doo-sabin");
        AdaptiveDual dual(mesh, *find_scheme("doo-sabin"));
        // Both have their slots in the same order, as they are told the same.
        Random random(seed);
        std::vector<LeafId> created;
        for (int round = 0; round < 3; ++round) {
            const std::vector<LeafHandle> some = test::random_subset(test::leaves_of(h), 0.2, random);
            std::vector<LeafId> slots;
            for (const LeafHandle leaf : some) slots.push_back(leaf.slot);
            h.refine(some);
            dual.forest().refine(slots, created);
        }
        const HierarchyMesh polygons = h.to_mesh(), cut = h.to_mesh({.normals = true, .triangles = true});
        const PolygonMesh expected = dual.to_mesh({.normals = true, .triangles = true});
        CHECK(cut.mesh.face_offsets == expected.face_offsets);
        CHECK(cut.mesh.face_vertices == expected.face_vertices);
        CHECK(cut.mesh.face_material == expected.face_material);
        CHECK(test::same_bytes(cut.mesh.normals, expected.normals));
        CHECK(test::same_bytes(cut.mesh.positions, polygons.mesh.positions));
        REQUIRE(cut.leaves.size() == cut.mesh.face_count());
        REQUIRE(cut.faces.size() == cut.mesh.face_count());
        CHECK(cut.mesh.face_vertices.size() == 3 * cut.leaves.size());
        std::uint32_t t = 0;
        for (std::uint32_t f = 0; f < polygons.mesh.face_count(); ++f)
            for (std::uint32_t k = 2; k < polygons.mesh.face_offsets[f + 1] - polygons.mesh.face_offsets[f]; ++k, ++t) {
                CHECK(cut.leaves[t] == polygons.leaves[f]);
                CHECK(cut.faces[t] == polygons.faces[f]);
            }
        CHECK(test::topology(test::faces_of(cut.mesh)).fault.empty());
    }
    const ControlMesh mesh = test::hierarchy_mesh("loop", 1);
    Hierarchy h = make_hierarchy(mesh, "loop");
    h.refine(h.leaves()[0]);
    CHECK(test::same_mesh(h.to_mesh({.triangles = true}), h.to_mesh()));
}

TEST_CASE("hierarchies of dual schemes: the journal names all leaves that are new or whose faces are others") {
    for (const std::uint64_t seed : test::seeds(8)) {
        CAPTURE(seed);
        const ControlMesh mesh = seed % 4 == 3   ? test::random_semi_sharp_dual_mesh(seed / 2)
                                 : seed % 2 == 1 ? test::random_creased_dual_mesh(seed / 2)
                                                 : test::random_dual_mesh(seed / 2);
        Hierarchy h = make_hierarchy(mesh, "doo-sabin");
        Random random(seed);
        test::random_changes(h, 6, 3, random, [] {});
        const auto before = faces_by_leaf(h);
        const auto leaves_before = test::leaves_of(h);
        const std::uint64_t stamp = h.stamp();
        test::random_changes(h, 4, 4, random, [] {});
        const HierarchyChanges changes = h.changes_since(stamp);
        REQUIRE(changes.complete);
        std::set<LeafHandle> added, removed, reshaped;
        for (const JournalLeaf& leaf : changes.added) added.insert(leaf.leaf);
        for (const JournalLeaf& leaf : changes.removed) removed.insert(leaf.leaf);
        for (const JournalLeaf& leaf : changes.reshaped) reshaped.insert(leaf.leaf);
        const std::set<LeafHandle> then(leaves_before.begin(), leaves_before.end());
        const auto after = faces_by_leaf(h);
        const std::vector<LeafHandle> leaves_after = test::leaves_of(h);
        std::size_t kept = 0;
        for (const LeafHandle leaf : leaves_after) {
            CHECK((then.count(leaf) == 0) == (added.count(leaf) == 1));
            if (then.count(leaf) == 0) continue;
            ++kept;
            const auto faces = [&](const auto& map) {
                const auto at = map.find(leaf);
                return at == map.end() ? std::set<std::vector<Site>>() : at->second;
            };
            if (faces(before) != faces(after)) CHECK(reshaped.count(leaf) == 1);
        }
        CHECK(removed.size() == then.size() - kept);
        CHECK(changes.moved.empty());
    }
}

TEST_CASE("hierarchies of dual schemes: a zoom of 25 levels, points, neighbours, and what they refuse") {
    const ControlMesh mesh = test::random_dual_mesh(2);
    Hierarchy h = make_hierarchy(mesh, "midedge");
    HierarchyNode deepest{5, 0, 0};
    for (int d = 0; d < 25; ++d) deepest = h.tree().child(deepest, 2 * (d % 2));
    const std::uint32_t roots = h.leaf_count();
    h.refine_where(each_leaf([&](const LeafView& leaf) { return h.tree().is_ancestor(leaf.node, deepest); }), 25);
    REQUIRE(h.find(deepest).has_value());
    CHECK(h.leaf_count() - roots < 25 * 40);
    check_sound(h);
    const LeafView view = h.view(*h.find(deepest));
    CHECK(view.level == 26);
    CHECK(view.sides() == 4);
    CHECK(view.corner[0] == h.view(deepest).corner[0]);
    const LimitPoint limit = h.limit(view.corner[0]), frame = h.frame(view.corner[0], 26);
    CHECK(glm::length(limit.position - frame.position) < 1e-6);
    CHECK(glm::length(limit.normal - frame.normal) < 1e-5);
    CHECK(h.position(view.corner[0], 26) == frame.position);
    for (int side = 0; side < 4; ++side) CHECK(h.neighbours(*h.find(deepest), side).count >= 1);
    CHECK_THROWS_AS(h.neighbours(*h.find(deepest), 4), Error);
    CHECK_THROWS_AS((void)h.position(view.corner[0], 27), Error);
    CHECK_THROWS_AS((void)h.position(view.corner[0], 25), Error);
    Site outside = view.corner[0];
    outside.at.x = 1u << 25;
    CHECK_THROWS_AS((void)h.limit(outside), Error);

    class None final : public ErrorEstimator {
        void estimate(std::span<const CellTriangle>, std::span<double>) const override {}
    };
    CHECK_THROWS_WITH_AS(h.refine_where(None(), 0.1, 5), doctest::Contains("estimate_vertices"), Error);
    check_sound(h);
}

TEST_CASE(
    "[bad-input] hierarchies of dual schemes: stale handles, diamonds that are none, nodes, sides and sites are "
    "refused, "
    "nothing changes") {
    for (const std::uint64_t seed : test::seeds(2)) {
        CAPTURE(seed);
        const ControlMesh mesh = seed % 2 == 1 ? test::random_creased_dual_mesh(seed) : test::random_dual_mesh(seed);
        Hierarchy h = make_hierarchy(mesh, "doo-sabin");
        const std::vector<LeafHandle> roots = test::leaves_of(h);
        const auto first = h.refine(roots[0]);
        h.refine(h.refine(first.front()).front());
        const HierarchyMesh before = h.to_mesh();
        const auto fails = [&](auto&& call, std::string_view text) {
            try {
                call();
                FAIL("no error");
            } catch (const Error& e) {
                CHECK(e.code() == ErrorCode::invalid_input);
                INFO(e.what());
                CHECK(std::string_view(e.what()).find(text) != std::string_view::npos);
            }
            check_sound(h);
            CHECK(test::same_mesh(h.to_mesh(), before));
        };
        fails([&] { h.refine(roots[0]); }, "split or merged");
        fails([&] { h.coarsen(roots[0]); }, "split or merged");
        fails([&] { (void)h.view(first.front()); }, "split or merged");
        const std::vector<LeafHandle> mixed{h.leaves().back(), roots[0]};
        fails([&] { h.refine(mixed); }, "generation 0");
        fails([&] { h.coarsen(mixed); }, "generation 0");
        fails([&] { h.refine(LeafHandle{LeafId(1u << 30), 0}); }, "does not exist");
        fails([&] { h.refine(LeafHandle{}); }, "does not exist");
        // A root, and a leaf beside finer ones.
        LeafHandle root, blocked;
        for (const LeafHandle leaf : h.leaves())
            if (!h.can_coarsen(leaf)) (h.node(leaf).depth == 0 ? root : blocked) = leaf;
        REQUIRE(root.slot.valid());
        REQUIRE(blocked.slot.valid());
        fails([&] { h.coarsen(root); }, "diamond");
        fails([&] { h.coarsen(blocked); }, "diamond");
        fails([&] { (void)h.neighbours(h.leaves()[0], -1); }, "side -1");
        fails([&] { (void)h.view(HierarchyNode{h.tree().root_bound, 0, 0}); }, "node");
        fails([&] { (void)h.find(HierarchyNode{0, 1, 1}); }, "node");
        fails([&] { (void)h.limit(Site{HalfedgeId(h.tree().root_bound), {0, 0}, 0}); }, "root");
        fails([&] { (void)h.to_mesh({.positions = MeshPositions::level, .level = -1}); }, "-1");
        fails([&] { h.refine_where(each_leaf([](const LeafView&) { return true; }), 1000); }, "1000");
    }
}

TEST_CASE("an estimator of vertices drives refinement to the smallest set within the tolerance, and coarsening back") {
    /// The size of a cell, larger in one root: known without a surface. Sees that what is around is as it should be.
    class Size final : public ErrorEstimator {
      public:
        explicit Size(std::uint32_t fine) : fine_(fine) {}
        void estimate(std::span<const CellTriangle>, std::span<double>) const override { FAIL("no such triangles"); }
        void estimate_vertices(const VertexForest& forest, std::span<const LeafId> leaves,
                               std::span<double> errors) const override {
            CHECK(!forest.check());
            for (std::size_t i = 0; i < leaves.size(); ++i) {
                const VertexCell cell = forest.cell(leaves[i]);
                errors[i] = (cell.root == fine_ ? 8.0 : 1.0) / static_cast<double>(1u << cell.level);
                if (coarsened == nullptr || forest.leaf_count() == coarsened->leaf_count()) continue;
                std::vector<LeafId> sides{leaves[i]}, around;
                forest.add_other_sides(leaves[i], sides);
                for (const LeafId side : sides)
                    for (int k = 0; k < 4; ++k) {
                        forest.add_leaves_around(side, k, around);
                        for (const LeafId leaf : forest.neighbours(side, k))
                            if (leaf.valid()) around.push_back(leaf);
                    }
                for (const LeafId leaf : around) CHECK(forest.level(leaf) == cell.level);
            }
        }
        /// Where it is not asked about the leaves of this one as they are, but about what merges would make of them,
        /// all leaves around must be of the same level.
        const Hierarchy* coarsened = nullptr;

      private:
        std::uint32_t fine_;
    };
    for (const std::uint64_t seed : test::seeds(6)) {
        CAPTURE(seed);
        const ControlMesh mesh = seed % 4 == 3   ? test::random_semi_sharp_dual_mesh(seed)
                                 : seed % 2 == 1 ? test::random_creased_dual_mesh(seed)
                                                 : test::random_dual_mesh(seed);
        Hierarchy h = make_hierarchy(mesh, "doo-sabin");
        Size size(h.node(h.leaves()[h.leaf_count() / 2]).root);
        h.refine_where(size, 0.5, 12);
        check_sound(h);
        const std::set<HierarchyNode> wanted = test::nodes_of(h);
        int deepest = 0;
        for (const HierarchyNode& node : wanted) deepest = std::max<int>(deepest, node.depth);
        // 8 / 2^4 = 0.5: level 4, the other roots at 1 away from it.
        CHECK(deepest == 4);
        CHECK(h.refine_where(size, 0.5, 12) == 0);
        h.refine_where(each_leaf([](const LeafView&) { return true; }), deepest);
        size.coarsened = &h;
        h.coarsen_where(size, 0.5);
        check_sound(h);
        CHECK(test::nodes_of(h) == wanted);
        CHECK_THROWS_AS(h.refine_where(size, std::nan(""), 12), Error);
        CHECK_THROWS_AS(h.coarsen_where(size, -1), Error);
    }
}

TEST_SUITE_END();
