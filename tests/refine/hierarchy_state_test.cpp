#include "../kit/hierarchy_helpers.hpp"
#include "../kit/input_helpers.hpp"
#include "../kit/scratch_dir.hpp"

#include "../../hier/base/error.hpp"
#include "../../refine/adaptive/hierarchy.hpp"
#include "../../refine/adaptive/hierarchy_file.hpp"

#include <doctest/doctest.h>
#include <zlib.h>

#include <cstddef>
#include <filesystem>
#include <iterator>
#include <map>
#include <span>
#include <string_view>

using namespace tetrakis;
using test::contains;
using test::error_of;
using test::Random;

namespace {

std::map<LeafHandle, HierarchyNode> leaf_map(const Hierarchy& h) {
    std::map<LeafHandle, HierarchyNode> leaves;
    for (LeafHandle leaf : h.leaves()) leaves[leaf] = h.node(leaf);
    return leaves;
}

// The level of the finest leaf around each vertex, from all leaves.
std::map<Site, int> finest_levels(const Hierarchy& h) {
    std::map<Site, int> levels;
    for (LeafHandle leaf : h.leaves()) {
        const LeafView view = h.view(leaf);
        for (std::size_t k = 0; k < view.corner_count; ++k) {
            int& level = levels[view.corner[k]];
            level = std::max(level, int{view.level});
        }
    }
    return levels;
}

// Faces of the mesh by leaf, as sites.
std::map<LeafHandle, std::set<std::vector<Site>>> leaf_shapes(const Hierarchy& h) {
    std::map<LeafHandle, std::set<std::vector<Site>>> result;
    const HierarchyMesh out = h.to_mesh({.positions = MeshPositions::finest});
    const auto faces = test::faces_of(out.mesh);
    for (std::size_t f = 0; f < faces.size(); ++f) {
        std::vector<Site> face;
        for (std::uint32_t v : faces[f]) face.push_back(out.sites[v]);
        result[out.leaves[f]].insert(face);
    }
    return result;
}

}  // namespace

TEST_SUITE_BEGIN("refine");

TEST_CASE("the journal tells the leaves that came and went, the ones reshaped and the vertices moved since any stamp") {
    for (const std::string_view scheme : test::k_each_family)
        for (const std::uint64_t seed : test::seeds(2)) {
            CAPTURE(scheme);
            CAPTURE(seed);
            const ControlMesh mesh = test::hierarchy_mesh(scheme, seed);
            Hierarchy h = make_hierarchy(mesh, scheme);
            Random random(seed);
            test::random_changes(h, 8, 5, random, [] {});  // before the journal begins
            struct Then {
                std::uint64_t stamp;
                std::map<LeafHandle, HierarchyNode> leaves;
                std::map<Site, int> levels;
                std::map<LeafHandle, std::set<std::vector<Site>>> shapes;
            };
            const auto now = [&] { return Then{h.stamp(), leaf_map(h), finest_levels(h), leaf_shapes(h)}; };
            CHECK_THROWS_AS((void)h.changes_since(0), Error);  // never given
            std::vector<Then> history{now()};
            CHECK_THROWS_AS((void)h.changes_since(history[0].stamp + 1), Error);
            CHECK(h.changes_since(history[0].stamp).added.empty());
            int moved = 0, reshaped = 0;
            test::random_changes(h, 14, 5, random, [&] {
                const Then here = now();
                for (const Then& then : history) {
                    const HierarchyChanges changes = h.changes_since(then.stamp);
                    REQUIRE(changes.complete);
                    std::map<LeafHandle, HierarchyNode> leaves = then.leaves;
                    for (const JournalLeaf& leaf : changes.removed) {
                        REQUIRE(leaves.at(leaf.leaf) == leaf.node);
                        leaves.erase(leaf.leaf);
                    }
                    for (const JournalLeaf& leaf : changes.added) REQUIRE(leaves.emplace(leaf.leaf, leaf.node).second);
                    REQUIRE(leaves == here.leaves);
                    std::set<LeafHandle> told;
                    for (const JournalLeaf& leaf : changes.reshaped) told.insert(leaf.leaf);
                    for (const auto& [leaf, shape] : here.shapes)
                        if (then.shapes.count(leaf) && then.shapes.at(leaf) != shape) {
                            ++reshaped;
                            REQUIRE(told.count(leaf) == 1);
                        }
                    std::vector<Site> expected;
                    for (const auto& [site, level] : here.levels)
                        if (const auto old = then.levels.find(site); old != then.levels.end() && old->second != level)
                            expected.push_back(site);
                    REQUIRE(changes.moved == expected);
                    moved += !expected.empty();
                }
                history.push_back(here);
            });
            if (h.leaf_count() > 0 && h.family() != "vertices") CHECK(moved > 0);
            if (h.family() == "triangles" && h.leaf_count() > 0) CHECK(reshaped > 0);
            // Forgetting keeps what is later.
            const std::uint64_t middle = history[history.size() / 2].stamp;
            h.forget_before(middle);
            CHECK(h.changes_since(middle).complete);
            if (middle > 0) CHECK(!h.changes_since(middle - 1).complete);
            h.limit_journal(0);
            CHECK(h.changes_since(h.stamp()).complete);
            CHECK(h.changes_since(h.stamp()).added.empty());
            if (h.leaf_count() > 0 && h.stamp() > middle) CHECK(!h.changes_since(middle).complete);
        }
}

TEST_CASE("shrink() after coarsening leaves what new hierarchies of the same leaves take, and no handle of before") {
    for (const std::string_view scheme : test::k_each_family)
        for (const std::uint64_t seed : test::seeds(2)) {
            CAPTURE(scheme);
            CAPTURE(seed);
            const ControlMesh mesh = test::hierarchy_mesh(scheme, seed);
            Hierarchy h = make_hierarchy(mesh, scheme);
            if (h.leaf_count() == 0) continue;
            Random random(seed);
            const auto all = test::everything();
            const std::uint64_t stamp = h.stamp();
            std::vector<LeafHandle> gone;
            for (const bool to_the_roots : {false, true}) {
                h.refine_where(all, h.tree().child_count == 4 ? 3 : 6);
                test::random_changes(h, 5, 8, random, [] {});
                for (LeafHandle leaf : h.leaves()) gone.push_back(leaf);
                const std::uint64_t before_bytes = h.memory_bytes();
                h.coarsen_where(
                    each_leaf([&](const LeafView& leaf) { return to_the_roots || leaf.node.root % 5 != 0; }));
                for (LeafHandle leaf : h.leaves()) gone.push_back(leaf);
                const std::set<HierarchyNode> nodes = test::nodes_of(h);
                const HierarchyMesh expected = h.to_mesh();
                REQUIRE(h.shrink());
                CHECK(2 * h.memory_bytes() < before_bytes);
                Hierarchy fresh = make_hierarchy(mesh, scheme);
                fresh.refine_where(each_leaf([&](const LeafView& leaf) { return nodes.count(leaf.node) == 0; }),
                                   fresh.tree().max_depth);
                CHECK_FALSE(fresh.shrink());
                CHECK(h.memory_bytes() == fresh.memory_bytes());
                CHECK(h.point_slots() == fresh.point_slots());
                CHECK(!h.check());
                CHECK(test::nodes_of(h) == nodes);
                CHECK(test::same_mesh(h.to_mesh(), expected));
                for (LeafHandle leaf : gone) REQUIRE(!h.is_leaf(leaf));
                CHECK(!h.changes_since(stamp).complete);
            }
            // Nothing is in another place if there was nothing to close up; slots to come are of new generations.
            const std::uint64_t now = h.stamp();
            const std::map<LeafHandle, HierarchyNode> leaves = leaf_map(h);
            CHECK_FALSE(h.shrink());
            CHECK(leaf_map(h) == leaves);
            h.refine_where(all, h.tree().child_count == 4 ? 3 : 6);
            for (LeafHandle leaf : gone) REQUIRE(!h.is_leaf(leaf));
            const HierarchyChanges changes = h.changes_since(now);
            REQUIRE(changes.complete);
            CHECK(changes.added.size() == h.leaf_count());
            CHECK(changes.removed.size() == leaves.size());
            CHECK(!h.check());
        }
}

TEST_CASE("[bad-input] corrupt, cut off and foreign files are refused, and nothing changes") {
    const ScratchDir scratch;
    for (const std::string_view scheme : test::k_each_family) {
        CAPTURE(scheme);
        const ControlMesh mesh = test::hierarchy_mesh(scheme, 1);
        Hierarchy h = make_hierarchy(mesh, scheme);
        Random random(1);
        test::random_changes(h, 12, 5, random, [] {});
        const std::vector<std::byte> good = h.saved();
        test::random_changes(h, 3, 5, random, [] {});
        const auto before = test::leaves_of(h);
        const auto refused = [&](std::span<const std::byte> bytes, std::string_view text) {
            const Error error = error_of([&] { h.load(bytes); });
            CHECK(error.code() == ErrorCode::invalid_input);
            CHECK(std::string_view(error.what()).find(text) != std::string_view::npos);
            REQUIRE(test::leaves_of(h) == before);
        };
        for (std::size_t size = 0; size < good.size(); ++size) refused(std::span(good).first(size), "");
        for (std::size_t i = 0; i < good.size(); ++i) {
            std::vector<std::byte> bad = good;
            bad[i] ^= static_cast<std::byte>(1u << random.below(8));
            refused(bad, "");
        }
        std::vector<std::byte> bad = good;
        bad[0] = std::byte{'T'};
        refused(bad, "does not begin");
        bad = good;
        bad[8] = std::byte{9};
        refused(bad, "version 9");
        bad = good;
        bad[good.size() - 6] ^= std::byte{1};
        refused(bad, "checksum");
        bad.resize(bad.size() - 1);
        refused(bad, "cut off");
        CHECK(!h.check());
        // Another mesh, another scheme.
        const ControlMesh other_mesh = test::hierarchy_mesh(scheme, 2);
        refused(make_hierarchy(other_mesh, scheme).saved(), "other faces, holes or tags");
        const std::string_view sibling = scheme == "loop" ? "midpoint" : "bilinear";
        refused(make_hierarchy(mesh, sibling).saved(), sibling);
        // Files.
        for (const std::filesystem::path& none : {scratch.path() / "none.bin", scratch.path()}) {
            CAPTURE(none.string());
            const Error error = error_of([&] { h.load(none); });
            CHECK(error.code() == ErrorCode::io);
            CHECK(contains(error.what(), none.string()));
            CHECK(contains(error.what(), "directory") == (none == scratch.path()));
        }
        const std::filesystem::path file = scratch.path() / "bad.bin";
        spill(file, "tetrakis, but not one");
        const Error foreign = error_of([&] { h.load(file); });
        CHECK(foreign.code() == ErrorCode::invalid_input);
        CHECK(contains(foreign.what(), "bad.bin"));
        CHECK(error_of([&] { h.save(scratch.path() / "no" / "folder" / "leaves.bin"); }).code() == ErrorCode::io);
        CHECK(!h.check());
        CHECK(test::leaves_of(h) == before);
    }
}

TEST_CASE("[bad-input] a memory limit ends refinement between two rounds, and refuses a mesh") {
    for (const std::string_view scheme : test::k_each_family) {
        CAPTURE(scheme);
        const ControlMesh mesh = test::hierarchy_mesh(scheme, 2);
        const auto all = test::everything();
        Hierarchy h = make_hierarchy(mesh, scheme);
        const int last_depth = h.tree().child_count == 4 ? 4 : 7;
        RunContext context;
        context.max_memory_bytes = h.memory_bytes() + (1u << 14);
        const Error full = error_of([&] { h.refine_where(all, last_depth, context); });
        CHECK(full.code() == ErrorCode::memory_limit);
        CHECK(contains(full.what(), std::to_string(h.leaf_count())));
        CHECK(contains(full.what(), "and the limit is"));
        CHECK(h.memory_bytes() <= context.max_memory_bytes);
        CHECK(!h.check());  // which sqrt3 remembers twins from
        // As far as it came, it is what it would have been; from there it goes on.
        int depth = 0;
        for (const LeafHandle leaf : h.leaves()) depth = std::max(depth, int{h.node(leaf).depth});
        CHECK(depth < last_depth);
        Hierarchy same = make_hierarchy(mesh, scheme);
        same.refine_where(all, depth);
        if (scheme != "sqrt3") CHECK(same.saved() == h.saved());  // a split may make whole ones, a depth further
        // A mesh has a limit of its own.
        context.max_memory_bytes = 1u << 26;
        CHECK_NOTHROW(h.to_mesh({.context = context}));
        context.max_memory_bytes = 1000;
        CHECK_THROWS_WITH_AS(h.to_mesh({.context = context}), doctest::Contains("and the limit is 0 KiB"), Error);
        context.max_memory_bytes = std::uint64_t{1} << 32;
        h.refine_where(all, last_depth, context);
        same.refine_where(all, last_depth);
        CHECK(same.saved() == h.saved());
    }
}

TEST_CASE("[bad-input] leaves saved with other choices of rules are refused, and named") {
    const ControlMesh mesh = test::hierarchy_mesh("averaging", 1);
    const auto with = [&](RuleOptions rules, std::string_view scheme = "averaging") {
        return make_hierarchy(mesh, scheme, {.rules = rules});
    };
    const auto refused = [&](Hierarchy h, const Hierarchy& other, const char* text) {
        h.refine(h.leaves()[0]);
        const auto before = test::leaves_of(h);
        CHECK_THROWS_WITH_AS(h.load(other.saved()), doctest::Contains(text), Error);
        CHECK(test::leaves_of(h) == before);
        h.load(h.saved());
        CHECK(!h.check());
    };
    refused(with({.averaging_steps = 4}), with({.averaging_steps = 2}),
            "saved with averaging_steps 2 of scheme \"averaging\", this hierarchy has averaging_steps 4");
    refused(with({}), with({.averaging_steps = 1}),
            "averaging_steps 1 of scheme \"averaging\", this hierarchy has plain");
    refused(with({.averaging_steps = 1}), with({}), "saved with plain rules");
    refused(with({}), with({.averaging_steps = 2}), "averaging_steps 2 of scheme");  // and of another family
    refused(with({.catmull_clark_beta = 0.4, .catmull_clark_gamma = 0.0625}, "catmull-clark"),
            with({.edge_beside_crease = EdgeBesideCrease::brief}, "catmull-clark"),
            "catmull_clark_beta 0.4, catmull_clark_gamma 0.0625");
}

TEST_CASE("[bad-input] well-formed files of other leaves give these leaves or none") {
    for (const std::string_view scheme : test::k_each_family)
        for (const std::uint64_t seed : test::seeds(3)) {
            CAPTURE(scheme);
            CAPTURE(seed);
            const ControlMesh mesh = test::hierarchy_mesh(scheme, seed);
            Hierarchy h = make_hierarchy(mesh, scheme);
            if (h.leaf_count() == 0) continue;
            Random random(seed);
            test::random_changes(h, 12, 5, random, [] {});
            const HierarchyTree tree = h.tree();  // a copy: loading makes another
            std::set<std::uint32_t> roots;
            for (LeafHandle leaf : h.leaves()) roots.insert(h.node(leaf).root);
            const auto file = [&](const std::set<HierarchyNode>& nodes) {
                return detail::encode_hierarchy(
                    {scheme, h.family(), "", detail::mesh_fingerprint(mesh)}, tree,
                    [&](std::uint32_t root) { return roots.count(root) == 1; },
                    std::vector<HierarchyNode>(nodes.begin(), nodes.end()));
            };
            const std::vector<std::byte> good = h.saved();
            REQUIRE(file(test::nodes_of(h)) == good);
            int refused = 0;
            for (int trial = 0; trial < 60; ++trial) {
                // As many splits as merges, or some more: without regard to what lies beside.
                std::set<HierarchyNode> nodes = test::nodes_of(h);
                for (int i = 0, n = 1 + trial % 5; i < n; ++i) {
                    auto at = std::next(nodes.begin(), random.below(static_cast<std::uint32_t>(nodes.size())));
                    const HierarchyNode split = *at;
                    nodes.erase(at);
                    for (const HierarchyNode& child : h.children(split)) nodes.insert(child);
                    at = std::next(nodes.begin(), random.below(static_cast<std::uint32_t>(nodes.size())));
                    if (at->depth == 0 || random.chance(0.2)) continue;
                    const HierarchyNode parent = tree.parent(*at);
                    const auto siblings = h.children(parent);
                    if (!std::all_of(siblings.begin(), siblings.end(),
                                     [&](const HierarchyNode& node) { return nodes.count(node) != 0; }))
                        continue;
                    for (const HierarchyNode& child : siblings) nodes.erase(child);
                    nodes.insert(parent);
                }
                const std::vector<std::byte> bytes = file(nodes);
                const auto before = test::leaves_of(h);
                try {
                    h.load(bytes);
                    REQUIRE(test::nodes_of(h) == nodes);
                    REQUIRE(h.saved() == bytes);
                } catch (const Error& e) {
                    CHECK(e.code() == ErrorCode::invalid_input);
                    REQUIRE(test::leaves_of(h) == before);
                    REQUIRE(h.saved() == good);
                    ++refused;
                }
                REQUIRE(!h.check());
                h.load(good);
            }
            CHECK(refused > 0);
            // The last byte's spare bits, with a checksum that knows of them.
            std::vector<std::byte> spare = good;
            spare[good.size() - 5] |= std::byte{0x80};
            if (spare == good) continue;
            const auto crc =
                crc32(0, reinterpret_cast<const unsigned char*>(spare.data()), static_cast<unsigned>(spare.size() - 4));
            for (std::size_t i = 0; i < 4; ++i)
                spare[spare.size() - 4 + i] = static_cast<std::byte>(crc >> 8 * i & 0xFF);
            CHECK_THROWS_AS(h.load(spare), Error);
        }
}

TEST_CASE("[bad-input] schemes without hierarchy, meshes and choices that a scheme does not have are refused") {
    const ControlMesh quads = test::hierarchy_mesh("catmull-clark", 1);
    const auto code = [&](auto&& call) { return error_of(call).code(); };
    CHECK(code([&] { make_hierarchy(quads, "catmull-klark"); }) == ErrorCode::invalid_input);
    CHECK(code([&] { make_hierarchy(quads, "loop"); }) == ErrorCode::invalid_input);
    CHECK(code([&] { make_hierarchy(quads, "honeycomb"); }) == ErrorCode::unsupported);
    // Faces are named as their file numbers them.
    const ControlMesh cube = ControlMesh::build(test::model_data("cube"));
    for (const char* scheme : {"loop", "butterfly"})
        CHECK(test::contains(error_of([&] { make_hierarchy(cube, scheme); }).what(), "face 1 (line 12) has 4 corners"));
    HierarchyOptions options;
    options.rules.averaging_steps = 2;
    options.rules.averaging_boundary = AveragingBoundary::recede;
    const ControlMesh open = test::random_mesh(1, {.removed_faces = 2});
    CHECK(code([&] { make_hierarchy(open, "averaging", options); }) == ErrorCode::unsupported);
}

TEST_SUITE_END();
