#include "../kit/hierarchy_helpers.hpp"
#include "../kit/point_sets.hpp"

#include "../../hier/base/error.hpp"
#include "../../hier/forest/sqrt3_slots.hpp"
#include "../../refine/adaptive/adaptive_sqrt3.hpp"
#include "../../refine/adaptive/hierarchy.hpp"
#include "../../refine/adaptive/sqrt3_sites.hpp"
#include "../../refine/uniform/refine.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <string>

using namespace tetrakis;
using test::Random;

namespace {

/// The face of a level that a node is, or is half of.
std::uint64_t face_of(const HierarchyNode& node) {
    std::uint64_t face = node.root;
    for (int k = 1; k <= (node.depth + 1) / 2; ++k) face = 3 * face + (node.path >> (64 - 2 * k) & 3);
    return face;
}

/// The same leaves, split face by split face.
Sqrt3Forest forest_of(const Hierarchy& h) {
    Sqrt3Forest forest(h.mesh());
    for (const LeafHandle leaf : h.leaves()) {
        const HierarchyNode node = h.node(leaf);
        const int level = (node.depth + 1) / 2;
        if (level > 0) forest.refine(Sqrt3Face{static_cast<std::uint8_t>(level - 1), face_of(node) / 3});
    }
    return forest;
}

}  // namespace

TEST_SUITE_BEGIN("refine");

TEST_CASE(
    "[inv1] a sqrt3 hierarchy's mesh is that of the forest, bit for bit, and its points those of uniform levels") {
    for (const std::uint64_t seed : test::seeds(6)) {
        CAPTURE(seed);
        const ControlMesh mesh = test::random_sqrt3_mesh(seed);
        Hierarchy h = make_hierarchy(mesh, "sqrt3");
        CHECK(h.family() == "sqrt3");
        Random random(seed);
        test::random_changes(h, 30, 7, random, [] {});
        const Sqrt3Forest forest = forest_of(h);
        const Sqrt3Mesh expected = sqrt3_mesh(forest, {.limit = true, .normals = true});
        const HierarchyMesh limits = h.to_mesh({.normals = true});
        CHECK(h.leaf_count() == forest.leaf_count());
        CHECK(limits.mesh.face_vertices == expected.mesh.face_vertices);
        CHECK(test::same_bytes(limits.mesh.positions, expected.mesh.positions));
        CHECK(test::same_bytes(limits.mesh.normals, expected.mesh.normals));
        for (std::size_t v = 0; v < limits.sites.size(); ++v)
            CHECK(site_sqrt3(limits.sites[v]) == expected.vertices[v]);
        const HierarchyMesh finest = h.to_mesh({.positions = MeshPositions::finest});
        std::vector<int> level_of(finest.sites.size(), 0);
        for (std::size_t f = 0; f < finest.leaves.size(); ++f)
            for (std::size_t k = 0; k < 3; ++k) {
                int& level = level_of[finest.mesh.face_vertices[3 * f + k]];
                level = std::max<int>(level, h.view(finest.leaves[f]).level);
            }
        for (std::size_t v = 0; v < finest.sites.size(); ++v)
            CHECK(finest.mesh.positions[v] == h.position(finest.sites[v], level_of[v]));
        for (std::size_t v = 0; v < limits.sites.size(); ++v) {
            const LimitPoint point = h.limit(limits.sites[v]);
            CHECK(point.position == limits.mesh.positions[v]);
            CHECK(point.normal == limits.mesh.normals[v]);
        }
        // Leaves one by one.
        for (std::size_t f = 0; f < limits.leaves.size(); ++f) {
            const LeafView view = h.view(limits.leaves[f]);
            REQUIRE(h.find(view.node) == limits.leaves[f]);
            if (f > 0) REQUIRE(h.node(limits.leaves[f - 1]) < view.node);
            for (std::size_t k = 0; k < 3; ++k) {
                const std::uint32_t v = limits.mesh.face_vertices[3 * f + k];
                REQUIRE(view.corner[k] == limits.sites[v]);
                REQUIRE(view.point[k] == limits.points[v]);
                REQUIRE(view.point[k].value < h.point_slots());
                REQUIRE(h.first_level(view.corner[k]) <= view.level);
            }
            CHECK(view.face == expected.leaves[f].control_face);
        }
        const double size = mesh.bounding_box().diagonal();
        for (int level = 2; level <= 4; level += 2) {
            const PolygonMesh uniform = refine(mesh, "sqrt3", level / 2);
            const HierarchyMesh out = h.to_mesh({.positions = MeshPositions::level, .level = level, .normals = true});
            std::vector<Vec3d> there;
            for (std::size_t v = 0; v < out.sites.size(); ++v) {
                if (h.first_level(out.sites[v]) > level) continue;
                there.push_back(out.mesh.positions[v]);
                const LimitPoint frame = h.frame(out.sites[v], level);
                CHECK(frame.position == out.mesh.positions[v]);
                CHECK(frame.normal == out.mesh.normals[v]);
                if (!frame.has_tangent_plane) continue;
                CHECK(glm::length(frame.normal) == doctest::Approx(1));
                CHECK(std::abs(glm::dot(frame.normal, frame.tangent1)) <= 1e-9 * glm::length(frame.tangent1));
            }
            CHECK(test::farthest_from(there, uniform.positions) < 1e-12 * size);
        }
        // Level 0 is the control mesh.
        for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v)
            if (mesh.vertex_halfedge(VertexId(v)).valid())
                CHECK(h.position(sqrt3_site({v, 0, Sqrt3Vertex::Kind::control}), 0) == mesh.position(VertexId(v)));
    }
}

TEST_CASE("[inv5] sqrt3 hierarchies: a split makes three triangles, and whole ones of those beyond") {
    const ControlMesh mesh = test::random_sqrt3_mesh(6);
    Hierarchy h = make_hierarchy(mesh, "sqrt3");
    // A face all of whose neighbours are others.
    const auto neighbours = [&](LeafHandle leaf) {
        std::set<LeafHandle> found;
        for (int side = 0; side < 3; ++side)
            for (const LeafHandle across : h.neighbours(leaf, side)) found.insert(across);
        return found;
    };
    LeafHandle inner;
    for (const LeafHandle leaf : h.leaves())
        if (neighbours(leaf).size() == 3) inner = leaf;
    REQUIRE(inner.slot.valid());
    const HierarchyNode root = h.node(inner);
    const std::uint32_t before = h.leaf_count();
    const auto halves = h.refine(inner);
    REQUIRE(halves.size() == 3);
    CHECK(h.leaf_count() == before + 2);
    for (int k = 0; k < 3; ++k) {
        const LeafView view = h.view(halves[static_cast<std::size_t>(k)]);
        CHECK(view.node == h.children(root)[static_cast<std::size_t>(k)]);
        CHECK(view.node.depth == 1);
        CHECK(view.level == 1);
        REQUIRE(h.children(view.node).size() == 1);
    }
    // The triangle beyond the first edge: both halves become whole ones, over the flipped edge.
    const HierarchyNode half = h.node(halves[0]), whole = h.children(half)[0];
    const auto created = h.refine(halves[0]);
    CHECK(created.size() == 4);
    CHECK(h.leaf_count() == before + 4);
    CHECK(!h.is_leaf(halves[0]));
    CHECK(h.is_leaf(halves[1]));
    REQUIRE(h.find(whole).has_value());
    CHECK(h.parent(whole) == half);
    CHECK(neighbours(*h.find(whole)).size() == 3);
    // Both ways back.
    Hierarchy other = make_hierarchy(mesh, "sqrt3");
    other.load(h.saved());
    CHECK(h.can_coarsen(created.front()));
    h.coarsen(created.front());
    CHECK(h.find(half).has_value());
    CHECK(h.leaf_count() == before + 2);
    other.coarsen(*other.find(whole));
    CHECK(other.leaf_count() == before + 2);
    CHECK(other.find(root).has_value());
    CHECK(!h.check());
    CHECK(!other.check());
}

TEST_CASE(
    "[bad-input] sqrt3 hierarchies: stale handles, sites, levels, depths and estimators are refused, nothing changes") {
    const ControlMesh mesh = test::random_sqrt3_mesh(3);
    Hierarchy h = make_hierarchy(mesh, "sqrt3");
    const std::vector<LeafHandle> roots = test::leaves_of(h);
    const auto first = h.refine(roots[0]);
    h.refine(first);
    const HierarchyMesh before = h.to_mesh();
    const auto fails = [&](auto&& call, ErrorCode code, std::string_view text) {
        try {
            call();
            FAIL("no error");
        } catch (const Error& e) {
            CHECK(e.code() == code);
            INFO(e.what());
            CHECK(std::string_view(e.what()).find(text) != std::string_view::npos);
        }
        CHECK(!h.check());
        CHECK(test::same_mesh(h.to_mesh(), before));
    };
    fails([&] { h.refine(roots[0]); }, ErrorCode::invalid_input, "split or merged");
    fails([&] { h.coarsen(roots[0]); }, ErrorCode::invalid_input, "split or merged");
    for (const LeafHandle leaf : first)
        if (!h.is_leaf(leaf)) fails([&] { (void)h.view(leaf); }, ErrorCode::invalid_input, "split or merged");
    fails([&] { h.refine(LeafHandle{}); }, ErrorCode::invalid_input, "does not exist");
    for (const LeafHandle leaf : test::leaves_of(h))
        if (!h.can_coarsen(leaf)) fails([&] { h.coarsen(leaf); }, ErrorCode::invalid_input, "diamond");
    fails([&] { (void)h.neighbours(h.leaves()[0], 3); }, ErrorCode::invalid_input, "side 3");
    using Kind = Sqrt3Vertex::Kind;
    const auto site = [](std::uint64_t key, int birth, Kind kind) {
        return sqrt3_site({key, static_cast<std::uint8_t>(birth), kind});
    };
    fails([&] { (void)h.limit(Site{HalfedgeId(4), {0, 0}, 0}); }, ErrorCode::invalid_input, "kind");
    fails([&] { (void)h.limit(site(0, 60, Kind::centre)); }, ErrorCode::invalid_input, "above");
    fails([&] { (void)h.limit(site(mesh.vertex_count(), 0, Kind::control)); }, ErrorCode::invalid_input, "no such");
    fails([&] { (void)h.limit(site(0, 1, Kind::control)); }, ErrorCode::invalid_input, "no such");
    fails([&] { (void)h.limit(site(mesh.face_count(), 1, Kind::centre)); }, ErrorCode::invalid_input, "no such");
    fails([&] { (void)h.limit(site(0, 1, Kind::first)); }, ErrorCode::invalid_input, "no such");
    fails([&] { (void)h.limit(site(0, 0, Kind::centre)); }, ErrorCode::invalid_input, "no such");
    fails([&] { (void)h.position(site(1, 2, Kind::centre), 1); }, ErrorCode::invalid_input, "first level");
    fails([&] { (void)h.position(site(1, 2, Kind::centre), 99); }, ErrorCode::invalid_input, "99");
    class Any final : public ErrorEstimator {
        void estimate(std::span<const CellTriangle>, std::span<double>) const override {}
    };
    fails([&] { h.refine_where(Any(), 0.1, 5); }, ErrorCode::unsupported, "estimate_sqrt3");
    // The deepest triangles.
    Hierarchy deep = make_hierarchy(mesh, "sqrt3");
    const int most = deep.tree().max_depth;
    CHECK(most >= 50);
    HierarchyNode deepest{1, 0, 0};
    for (int d = 0; d < most; ++d) deepest = deep.tree().child(deepest, d % 2 == 0 ? d / 2 % 3 : 0);
    CHECK(deep.tree().is_valid(deepest));
    deep.refine_where(each_leaf([&](const LeafView& leaf) { return deep.tree().is_ancestor(leaf.node, deepest); }),
                      most);
    REQUIRE(deep.find(deepest).has_value());
    const std::uint32_t count = deep.leaf_count();
    CHECK_THROWS_WITH_AS(deep.refine(*deep.find(deepest)), doctest::Contains("deepest"), Error);
    CHECK(deep.leaf_count() == count);
    CHECK(deep.children(deepest).empty());
    CHECK(!deep.check());
    deep.shrink();
    CHECK(deep.memory_bytes() < 80 * std::uint64_t{count} + 8192);
}

TEST_CASE("sqrt3 leaves come control face by control face, whichever edges are flipped or kept") {
    for (const std::uint64_t seed : test::seeds(12)) {
        CAPTURE(seed);
        const ControlMesh mesh = test::random_sqrt3_mesh(seed);
        Hierarchy h = make_hierarchy(mesh, "sqrt3");
        const std::uint32_t roots = h.leaf_count();
        // Two steps cut a face in nine and its sides in three.
        std::uint32_t in_root = 9, sides = 9;
        for (int pairs = 1; pairs <= 2; ++pairs, in_root *= 9, sides *= 3) {
            CAPTURE(pairs);
            h.refine_where(each_leaf([](const LeafView&) { return true; }), 4 * pairs);
            REQUIRE(h.leaf_count() == roots * in_root);
            const std::vector<LeafHandle> leaves = test::leaves_of(h);
            std::map<LeafHandle, std::size_t> root_of;
            for (std::size_t i = 0; i < leaves.size(); ++i) root_of[leaves[i]] = i / in_root;
            std::vector<std::uint32_t> outside(roots, 0);
            for (const auto& [leaf, root] : root_of)
                for (int side = 0; side < 3; ++side) {
                    const LeafNeighbours beyond = h.neighbours(leaf, side);
                    if (beyond.count == 0 || root_of.at(beyond.leaf[0]) != root) ++outside[root];
                }
            CHECK(std::count(outside.begin(), outside.end(), sides) == static_cast<std::ptrdiff_t>(roots));
        }
    }
}

TEST_CASE("sqrt3 leaves are in order and found down to the largest depth") {
    for (const std::uint64_t seed : test::seeds(6)) {
        CAPTURE(seed);
        const ControlMesh mesh = test::random_sqrt3_mesh(seed);
        Hierarchy h = make_hierarchy(mesh, "sqrt3");
        LeafHandle at = h.leaves().front();
        while (h.node(at).depth < h.tree().max_depth) {
            const std::vector<LeafHandle> created = h.refine(at);
            at = *std::max_element(created.begin(), created.end(),
                                   [&](LeafHandle a, LeafHandle b) { return h.node(a).depth < h.node(b).depth; });
        }
        CHECK(h.check().value_or("") == "");
        for (const LeafHandle leaf : h.leaves()) {
            const HierarchyNode node = h.node(leaf);
            CHECK(h.find(node) == leaf);
            if (node.depth > 0) CHECK(!h.find(*h.parent(node)));
        }
    }
}

TEST_CASE("[bad-input] sqrt3 slots refuse stale handles, and coarsen after their spare room is given back") {
    const ControlMesh mesh = test::random_sqrt3_mesh(1);
    Sqrt3Slots slots(mesh);
    std::vector<LeafId> created, ignored;
    Sqrt3Slots::Changed removed;
    const LeafId root(4);
    slots.refine({&root, 1}, created, &removed);
    const std::vector<LeafId> children(created.begin(), created.begin() + 3);
    const std::vector<LeafId> before = slots.ordered_leaves();
    for (const LeafId stale : {root, LeafId(1'000'000), LeafId{}}) {
        const std::vector<LeafId> marked{children[0], stale};
        CHECK_THROWS_AS(slots.refine(marked, ignored, nullptr), Error);
        CHECK_THROWS_AS(slots.coarsen(marked, ignored, removed), Error);
    }
    CHECK(slots.ordered_leaves() == before);
    slots.shrink();
    slots.coarsen(children, created, removed);
    CHECK(slots.is_leaf(root));
    CHECK(!slots.check());
    // Its slots are dead now.
    CHECK_THROWS_AS(slots.refine({&children[0], 1}, created, nullptr), Error);
    CHECK_THROWS_AS(slots.coarsen({&children[0], 1}, created, removed), Error);
    CHECK(!slots.check());
}

TEST_CASE("an estimator of sqrt3 triangles drives refinement to the smallest set within the tolerance, and back") {
    /// The size of a triangle, larger over one control face: known without a surface.
    class Size final : public ErrorEstimator {
      public:
        explicit Size(FaceId fine) : fine_(fine) {}
        void estimate(std::span<const CellTriangle>, std::span<double>) const override { FAIL("no such triangles"); }
        void estimate_sqrt3(std::span<const Sqrt3Leaf> triangles, std::span<double> errors) const override {
            for (std::size_t i = 0; i < triangles.size(); ++i) {
                const int level = triangles[i].level + (triangles[i].half ? 1 : 0);
                errors[i] = (triangles[i].control_face == fine_ ? 8.0 : 1.0) / static_cast<double>(1u << level);
            }
        }

      private:
        FaceId fine_;
    };
    /// Keeps what it is asked about.
    class Listener final : public ErrorEstimator {
      public:
        void estimate(std::span<const CellTriangle>, std::span<double>) const override { FAIL("no such triangles"); }
        void estimate_sqrt3(std::span<const Sqrt3Leaf> triangles, std::span<double> errors) const override {
            seen.insert(seen.end(), triangles.begin(), triangles.end());
            std::fill(errors.begin(), errors.end(), 0.0);
        }
        mutable std::vector<Sqrt3Leaf> seen;
    };
    for (const std::uint64_t seed : test::seeds(4)) {
        CAPTURE(seed);
        const ControlMesh mesh = test::random_sqrt3_mesh(seed);
        Hierarchy h = make_hierarchy(mesh, "sqrt3");
        const Size size(h.view(h.leaves()[h.leaf_count() / 2]).face);
        h.refine_where(size, 0.5, 20);
        CHECK(h.check().value_or("") == "");
        const std::set<HierarchyNode> wanted = test::nodes_of(h);
        int deepest = 0;
        for (const HierarchyNode& node : wanted) deepest = std::max<int>(deepest, node.depth);
        // 8 / 2^4 = 0.5: simple step 4, the other faces at 1 away from it.
        CHECK((deepest == 7 || deepest == 8));  // half triangles, or whole ones
        CHECK(h.refine_where(size, 0.5, 20) == 0);

        // What an estimator is told of leaves is what the forest says of them.
        const Listener listener;
        CHECK(h.refine_where(listener, 0.0, 20) == 0);
        const std::vector<Sqrt3Leaf> leaves = forest_of(h).leaves();
        REQUIRE(listener.seen.size() == leaves.size());
        for (std::size_t i = 0; i < leaves.size(); ++i) {
            const Sqrt3Leaf &a = listener.seen[i], &b = leaves[i];
            CHECK((a.level == b.level && a.half == b.half && a.face == b.face && a.control_face == b.control_face));
            CHECK(a.vertex == b.vertex);
            CHECK((a.vertex_level == b.vertex_level && a.leaving == b.leaving));
        }

        h.refine_where(each_leaf([](const LeafView&) { return true; }), deepest);
        h.coarsen_where(size, 0.5);
        CHECK(!h.check());
        CHECK(test::nodes_of(h) == wanted);
        CHECK_THROWS_AS(h.refine_where(size, std::nan(""), 20), Error);
        CHECK_THROWS_AS(h.coarsen_where(size, -1), Error);
    }
}

TEST_CASE("sqrt3: what neighbours have been found by is counted, and given back") {
    const ControlMesh mesh = test::random_sqrt3_mesh(2);  // with creases and a boundary
    Hierarchy h = make_hierarchy(mesh, "sqrt3");
    h.refine_where(each_leaf([](const LeafView&) { return true; }), 8);
    h.shrink();
    const std::vector<LeafHandle> leaves = test::leaves_of(h);  // a list that counts, too
    const std::uint64_t before = h.memory_bytes();
    for (const LeafHandle leaf : leaves)
        for (int side = 0; side < 3; ++side) CHECK(h.neighbours(leaf, side).count <= 1);
    CHECK(h.memory_bytes() > before + 1000);
    h.shrink();
    CHECK(test::leaves_of(h) == leaves);
    CHECK(h.memory_bytes() <= before);
}

TEST_CASE("sqrt3: a crease that ends between two triangles has no limit there, and it says where") {
    ControlMeshData data;
    data.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0.3}};
    data.face_offsets = {0, 3, 6};
    data.face_vertices = {0, 1, 2, 0, 2, 1};
    for (const float sharpness : {2.0f, k_sharpness_infinity}) {
        data.creases = {{0, 1, sharpness}};
        const ControlMesh mesh = ControlMesh::build(data);
        Hierarchy h = make_hierarchy(mesh, "sqrt3");
        h.refine_where(each_leaf([](const LeafView&) { return true; }), 6);
        CHECK(h.to_mesh({.positions = MeshPositions::finest}).mesh.face_count() == h.leaf_count());
        const Site site = sqrt3_site({0, 0, Sqrt3Vertex::Kind::control});
        if (sharpness < k_sharpness_infinity) {
            const HierarchyMesh out = h.to_mesh();
            CHECK(out.mesh.face_count() == h.leaf_count());
            const auto at = std::find(out.sites.begin(), out.sites.end(), site);
            REQUIRE(at != out.sites.end());
            CHECK(out.mesh.positions[static_cast<std::size_t>(at - out.sites.begin())] == h.limit(site).position);
            continue;
        }
        CHECK_THROWS_AS(h.limit(site), Error);
        try {
            h.to_mesh();
            FAIL("not refused");
        } catch (const Error& e) {
            CHECK(e.code() == ErrorCode::unsupported);
            CHECK(std::string(e.what()).find("vertex 0") != std::string::npos);
        }
    }
}

TEST_CASE("[slow] [inv10] sqrt3: points are the same bytes whatever part of their surroundings is raised at once") {
    for (const std::uint64_t seed : test::seeds(2)) {
        CAPTURE(seed);
        const ControlMesh mesh = test::random_sqrt3_mesh(seed);
        Hierarchy h = make_hierarchy(mesh, "sqrt3");
        Random random(seed);
        test::random_changes(h, 20, 6, random, [] {});
        for (int zoom = 0; zoom < 12; ++zoom) {
            LeafHandle at = h.leaves()[random.below(static_cast<std::uint32_t>(h.leaf_count()))];
            while (h.node(at).depth < 40) {
                const std::vector<LeafHandle> created = h.refine(at);
                at = created[random.below(static_cast<std::uint32_t>(created.size()))];
            }
        }
        const Sqrt3Forest forest = forest_of(h);
        const Sqrt3Levels levels(forest.lattice(), forest.split(), 3, true);
        const std::uint64_t whole = levels.memory_bytes() + levels.vertices.size() * 2 * sizeof(Vec3d);
        for (const bool limit : {true, false})
            for (const bool normals : {true, false}) {
                CAPTURE(limit);
                CAPTURE(normals);
                Sqrt3MeshOptions options{.limit = limit, .normals = normals, .halves_are_finer = seed % 2 == 0};
                const Sqrt3Mesh expected = sqrt3_mesh(forest, options);
                bool refused = false;
                std::uint64_t least = 0;
                for (std::uint64_t most = 2 * whole; !refused; most /= 2) {
                    options.context.max_memory_bytes = most;
                    try {
                        const Sqrt3Mesh out = sqrt3_mesh(forest, options);
                        REQUIRE(out.mesh.face_vertices == expected.mesh.face_vertices);
                        REQUIRE(test::same_bytes(out.mesh.positions, expected.mesh.positions));
                        REQUIRE(test::same_bytes(out.mesh.normals, expected.mesh.normals));
                        REQUIRE(out.levels == expected.levels);
                        least = most;
                    } catch (const Error& e) {
                        refused = e.code() == ErrorCode::memory_limit;
                        REQUIRE(refused);
                    }
                }
                CHECK(least < whole / 3);
            }
    }
}

TEST_CASE("sqrt3: a mesh whose levels take more memory than allowed is refused, and can be cancelled") {
    const ControlMesh mesh = test::random_sqrt3_mesh(2);
    Hierarchy h = make_hierarchy(mesh, "sqrt3");
    // Zooms far from each other, which need much around them for little.
    for (std::uint32_t root = 0; root < mesh.face_count(); root += 3) {
        if (mesh.is_hole(FaceId(root))) continue;
        HierarchyNode spot{root, 0, 0};
        for (int depth = 0; depth < 24; ++depth) spot = h.tree().child(spot, 0);
        h.refine_where(each_leaf([&](const LeafView& leaf) { return h.tree().is_ancestor(leaf.node, spot); }), 24);
    }
    ToMeshOptions options;
    const HierarchyMesh free = h.to_mesh(options);
    options.context.max_memory_bytes = 200 * free.sites.size();
    try {
        h.to_mesh(options);
        FAIL("not refused");
    } catch (const Error& e) {
        CHECK(e.code() == ErrorCode::memory_limit);
    }
    options.context.max_memory_bytes = 40'000 * free.sites.size();
    CHECK(h.to_mesh(options).mesh.positions == free.mesh.positions);
    int calls = 0;
    options.context.progress = [&](std::string_view, double) { return ++calls < 5; };
    try {
        h.to_mesh(options);
        FAIL("not cancelled");
    } catch (const Error& e) {
        CHECK(e.code() == ErrorCode::cancelled);
    }
}

TEST_SUITE_END();
