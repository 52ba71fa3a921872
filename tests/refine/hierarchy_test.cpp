#include "../../refine/adaptive/hierarchy.hpp"

#include "../kit/hierarchy_helpers.hpp"
#include "../kit/input_helpers.hpp"
#include "../kit/nearest.hpp"
#include "../kit/random_mesh.hpp"
#include "../kit/surface_topology.hpp"

#include "../../eval/patches/quad_patches.hpp"
#include "../../hier/base/error.hpp"
#include "../../hier/forest/corner_cell.hpp"
#include "../../hier/obj/obj_reader.hpp"
#include "../../hier/trees/sqrt3_lattice.hpp"
#include "../../refine/uniform/refine.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <string>

// Hierarchies of all four families by the same tests. Random histories are in tests/contract/hierarchy_test.cpp.

using namespace tetrakis;
using test::contains;
using test::error_of;
using test::everything;
using test::Random;

namespace {

/// Back to back.
ControlMeshData two_triangles() { return test::mesh_data({{0, 0, 0}, {1, 0, 0}, {0, 1, 0.3}}, {{0, 1, 2}, {0, 2, 1}}); }

bool is_dual(const Hierarchy& h) { return h.family() == "vertices"; }

// Mean normals by area, face by face.
std::vector<Vec3d> area_normals(const PolygonMesh& mesh) {
    std::vector<Vec3d> normals(mesh.positions.size(), Vec3d(0));
    for (const auto& face : test::faces_of(mesh)) {
        Vec3d area(0);
        for (std::size_t i = 1; i + 1 < face.size(); ++i)
            area += glm::cross(mesh.positions[face[i]] - mesh.positions[face[0]],
                               mesh.positions[face[i + 1]] - mesh.positions[face[0]]);
        for (std::uint32_t v : face) normals[v] += area;
    }
    return normals;
}

}  // namespace

TEST_SUITE_BEGIN("refine");

TEST_CASE("[inv1] normals are those of uniform refinement: of the net on a level, of the surface in the limit") {
    for (const std::string_view scheme : {"catmull-clark", "loop", "kobbelt", "4-8", "tuned-loop", "butterfly"})
        for (const std::uint64_t seed : test::seeds(2)) {
            CAPTURE(scheme);
            CAPTURE(seed);
            test::RandomMeshOptions mesh_options = test::random_options(seed);
            mesh_options.columns = mesh_options.rows = 3;
            mesh_options.hole = 0;  // faces around a vertex for the frame, but none of the uniform net
            mesh_options.boundary_rule = BoundaryRule::edge_and_corner;
            mesh_options.triangles_only = find_scheme(scheme)->family == MeshFamily::triangles;
            const ControlMesh mesh = test::random_mesh(seed, mesh_options);
            Hierarchy h = make_hierarchy(mesh, scheme);
            Random random(seed);
            h.refine(test::random_subset(test::leaves_of(h), 0.5, random));
            const double size = mesh.bounding_box().diagonal();
            int compared = 0;
            for (int level = 1; level <= 2; ++level) {
                CAPTURE(level);
                const PolygonMesh net = refine(mesh, scheme, level);
                const std::vector<Vec3d> area = area_normals(net);
                const PointMatch match(net.positions);
                const HierarchyMesh out =
                    h.to_mesh({.positions = MeshPositions::level, .level = level, .normals = true});
                for (std::size_t v = 0; v < out.sites.size(); ++v) {
                    if (h.first_level(out.sites[v]) > level) continue;
                    const LimitPoint frame = h.frame(out.sites[v], level);
                    REQUIRE(frame.position == h.position(out.sites[v], level));
                    REQUIRE(frame.position == out.mesh.positions[v]);
                    REQUIRE(frame.normal == out.mesh.normals[v]);
                    const std::uint32_t nearest = match.nearest(frame.position);
                    REQUIRE(glm::length(net.positions[nearest] - frame.position) <= 1e-12 * size);
                    const double length = glm::length(area[nearest]);
                    // Where the faces around cancel out, rounding chooses the normal.
                    if (!(length > 1e-6 * size * size)) continue;
                    ++compared;
                    REQUIRE(glm::length(frame.normal - area[nearest] / length) < 1e-6);
                    const auto [t1, t2] = h.tangents(out.sites[v], level);
                    CHECK(std::abs(glm::dot(t1, frame.normal)) <= 1e-9 * glm::length(t1));
                    CHECK(glm::dot(glm::cross(t1, t2), frame.normal) > 0);
                }
            }
            CHECK(compared > 10);
            if (scheme != "catmull-clark" && scheme != "loop") continue;
            const PolygonMesh limit = refine(mesh, scheme, 3, {.limit = true, .normals = true});
            const PointMatch match(limit.positions);
            const HierarchyMesh out = h.to_mesh({.normals = true});
            for (std::size_t v = 0; v < out.sites.size(); ++v) {
                const LimitPoint point = h.limit(out.sites[v]);
                if (!point.has_tangent_plane) continue;
                const std::uint32_t nearest = match.nearest(point.position);
                REQUIRE(glm::length(out.mesh.normals[v] - limit.normals[nearest]) < 1e-8);
                const auto [t1, t2] = h.tangents(out.sites[v]);
                REQUIRE(glm::length(glm::normalize(glm::cross(t1, t2)) - point.normal) < 1e-9);
            }
        }
}

TEST_CASE("tangents lie across the normal where an edge of the net is along it") {
    // The faces around vertex 0 add up to a normal downwards; its neighbour 1 is above it.
    for (std::uint32_t first = 0; first < 4; ++first) {
        const auto ring = [&](std::uint32_t i) { return 1 + (first + i) % 4; };
        const ControlMesh mesh = ControlMesh::build(test::mesh_data(
            {{0, 0, 0}, {0, 0, 1}, {0, 1, 0.5}, {1, 0, 1}, {0, -1, 0.5}},
            {{0, ring(0), ring(1)}, {0, ring(1), ring(2)}, {0, ring(2), ring(3)}, {0, ring(3), ring(0)}}));
        const Hierarchy h = make_hierarchy(mesh, "loop");
        const LimitPoint frame = h.frame({mesh.vertex_halfedge(VertexId(0)), {0, 0}, 0}, 0);
        REQUIRE(std::abs(frame.normal.z) == doctest::Approx(1));
        CHECK(glm::length(frame.tangent1) > 0.1);
        CHECK(std::abs(glm::dot(frame.tangent1, frame.normal)) < 1e-12);
        CHECK(glm::dot(glm::cross(frame.tangent1, frame.tangent2), frame.normal) > 0);
    }
}

TEST_CASE("limits where a crease ends at an inner vertex of valence 2 are those of levels far down") {
    const ControlMesh mesh =
        ControlMesh::build(parse_obj("v 0.1 0 1\nv 2 0 0.3\nv 0 2 -0.3\nv -2 0 0.3\nv 0 -2 -0.3\nv 0 0.2 -1\n"
                                     "f 1 2 3 4\nf 6 5 4 3\nf 1 4 5 2\nf 6 3 2 5\nt crease 2/1/0 0 1 10\n",
                                     "test.obj"));
    for (const std::string_view scheme : {"4-8", "kobbelt", "catmull-clark"}) {
        CAPTURE(scheme);
        const Hierarchy h = make_hierarchy(mesh, scheme);
        const Site site = canonical(mesh, {mesh.vertex_halfedge(VertexId(0)), {0, 0}, 0});
        // What is left shrinks by 0.5 at most (kobbelt; 4-8: 0.317) from level to level.
        const Vec3d far = h.position(site, 24), limit = h.limit(site).position;
        CHECK(glm::length(far - limit) < 1e-6);
        if (scheme == "4-8") CHECK(glm::length(far - limit) < 1e-11);
        const PolygonMesh level = refine(mesh, scheme, 2, {.limit = true, .normals = true});
        CHECK(level.normals.size() == level.positions.size());
        double nearest = 1;
        for (const Vec3d& p : level.positions) nearest = std::min(nearest, glm::length(p - limit));
        CHECK(nearest < 1e-12);
    }
}

TEST_CASE("limits by repeated rows are those of single sites, at any level") {
    for (const char* name : {"kobbelt", "4-8", "tuned-loop", "modified-butterfly", "doo-sabin", "biquartic"}) {
        CAPTURE(name);
        const bool triangles = find_scheme(name)->family == MeshFamily::triangles;
        for (std::uint64_t seed = 1; seed <= 4; ++seed) {
            CAPTURE(seed);
            test::RandomMeshOptions options = test::random_options(seed);
            options.triangles_only = triangles;
            options.hole = options.edge_vertices = options.merge = 0;  // vertices of two faces have no quadtrees
            const ControlMesh mesh = test::random_mesh(seed, options);
            Hierarchy single = make_hierarchy(mesh, name);
            const Hierarchy whole = make_hierarchy(mesh, name, {.whole_levels = true});
            const int level = single.tree().child_count == 4 ? 1 : 2;
            single.refine_where(everything(), 2 * level);
            single.refine_where(each_leaf([](const LeafView& view) { return view.face.value == 0; }), 4 * level);
            const std::vector<Site> sites = single.to_mesh().sites;
            std::vector<Vec3d> expected(sites.size()), found(sites.size());
            single.limit_positions(sites, expected);
            whole.limit_positions(sites, found);
            for (std::size_t i = 0; i < sites.size(); ++i) CHECK(glm::length(found[i] - expected[i]) < 1e-11);
            single.normals(sites, expected);
            whole.normals(sites, found);
            for (std::size_t i = 0; i < sites.size(); ++i) CHECK(glm::length(found[i] - expected[i]) < 1e-8);
        }
    }
}

TEST_CASE("a dual scheme's vertex is one of its own level only, with rows and without") {
    test::RandomMeshOptions options = test::random_options(1);
    options.hole = options.edge_vertices = options.merge = 0;  // vertices of two faces have no quadtrees
    const ControlMesh mesh = test::random_mesh(1, options);
    for (const bool whole : {false, true}) {
        const Hierarchy h = make_hierarchy(mesh, "doo-sabin", {.whole_levels = whole});
        const Site site = h.to_mesh().sites.front();
        CHECK_NOTHROW(h.position(site, site.level + 1));
        CHECK(error_of([&] { h.position(site, 4); }).code() == ErrorCode::unsupported);
    }
}

TEST_CASE("long Chaikin creases: sites of first levels have limits, and too deep ones are refused with advice") {
    ControlMeshData data = test::random_mesh(2, test::random_options(2)).data();
    data.crease_method = CreaseMethod::chaikin;
    REQUIRE(!data.creases.empty());
    for (auto& crease : data.creases) crease.sharpness = 9;
    const ControlMesh mesh = ControlMesh::build(data);
    const Hierarchy h = make_hierarchy(mesh, "catmull-clark");
    const Site site{HalfedgeId(0), {1, 1}, 1};
    Vec3d limit;
    h.limit_positions({&site, 1}, {&limit, 1});
    CHECK(glm::length(limit - QuadPatches(mesh).limit(site.root, site.at, site.level)) <
          1e-12 * mesh.bounding_box().diagonal());
    const Site deep{HalfedgeId(0), {1, 1}, 20};
    const Error error = error_of([&] { h.position(deep, 21); });
    CHECK(error.code() == ErrorCode::unsupported);
    CHECK(contains(error.what(), "Chaikin's"));
}

TEST_CASE("points of any depth around vertices of two triangles") {
    const ControlMesh mesh = ControlMesh::build(two_triangles());
    const Hierarchy h = make_hierarchy(mesh, "loop");
    const Site site{HalfedgeId(0), {1, 0}, 1};
    CHECK(glm::length(h.position(site, 25) - h.limit(site).position) < 1e-6);
}

TEST_CASE("[bad-input] a hierarchy's memory limit holds for the levels that its points need") {
    HierarchyOptions options;
    options.context.max_memory_bytes = std::uint64_t{1} << 16;
    const ControlMesh mesh = test::random_mesh(1, test::random_options(1));
    const Hierarchy h = make_hierarchy(mesh, "kobbelt", options);
    const Site site{HalfedgeId(0), {1, 1}, 3};
    CHECK(error_of([&] { h.limit(site); }).code() == ErrorCode::memory_limit);
}

TEST_CASE("sqrt3: a crease that ends between two triangles has no limit there, and it says where") {
    ControlMeshData data = two_triangles();
    for (const float sharpness : {2.0f, k_sharpness_infinity}) {
        data.creases = {{0, 1, sharpness}};
        const ControlMesh mesh = ControlMesh::build(data);
        Hierarchy h = make_hierarchy(mesh, "sqrt3");
        h.refine_where(everything(), 6);
        CHECK(h.to_mesh({.positions = MeshPositions::finest}).mesh.face_count() == h.leaf_count());
        const Site site{HalfedgeId(0), {0, 0}, 0};
        if (sharpness < k_sharpness_infinity) {
            const HierarchyMesh out = h.to_mesh();
            CHECK(out.mesh.face_count() == h.leaf_count());
            const auto at = std::find(out.sites.begin(), out.sites.end(), site);
            REQUIRE(at != out.sites.end());
            CHECK(out.mesh.positions[static_cast<std::size_t>(at - out.sites.begin())] == h.limit(site).position);
            continue;
        }
        CHECK_THROWS_AS(h.limit(site), Error);
        const Error error = error_of([&] { h.to_mesh(); });
        CHECK(error.code() == ErrorCode::unsupported);
        CHECK(test::contains(error.what(), "vertex 0"));
    }
}

TEST_CASE("equal parts of the leaves are compact") {
    for (const std::string_view scheme : test::k_each_family) {
        CAPTURE(scheme);
        const ControlMesh mesh = test::hierarchy_mesh(scheme, 3);
        Hierarchy h = make_hierarchy(mesh, scheme);
        while (h.leaf_count() < 3000) {
            int i = 0;
            const int deepest = h.node(h.leaves().front()).depth + 1;
            // A part of them one level deeper.
            h.refine_where(each_leaf([&](const LeafView&) { return ++i % 9 != 0; }), deepest);
        }
        const std::vector<LeafHandle> leaves = test::leaves_of(h);
        REQUIRE(leaves.size() == h.leaf_count());
        // They are in this order whatever the history.
        Hierarchy loaded = make_hierarchy(mesh, scheme);
        loaded.load(h.saved());
        const std::vector<LeafHandle> same = test::leaves_of(loaded);
        CHECK(std::equal(leaves.begin(), leaves.end(), same.begin(), same.end(),
                         [&](LeafHandle a, LeafHandle b) { return h.node(a) == loaded.node(b); }));
        constexpr std::size_t k_parts = 4;
        std::map<std::uint32_t, std::size_t> part;
        for (std::size_t i = 0; i < leaves.size(); ++i) part[leaves[i].slot.value] = i * k_parts / leaves.size();
        REQUIRE(part.size() == leaves.size());
        int all = 0, cut = 0;
        for (const LeafHandle leaf : leaves)
            for (int side = 0; side < (scheme == "doo-sabin" ? 4 : 3); ++side)
                for (const LeafHandle beyond : h.neighbours(leaf, side)) {
                    ++all;
                    cut += part.at(leaf.slot.value) != part.at(beyond.slot.value) ? 1 : 0;
                }
        CHECK(cut < all / 5);
    }
}

TEST_CASE("leaves come along the curve, and nodes know their parents, children and leaves") {
    for (const std::string_view scheme : {"catmull-clark", "bilinear", "loop", "midpoint", "sqrt3"}) {
        CAPTURE(scheme);
        const ControlMesh mesh = test::hierarchy_mesh(scheme, 2);
        Hierarchy h = make_hierarchy(mesh, scheme);
        Random random(2);
        test::random_changes(h, 30, 6, random, [] {});
        const auto all = test::leaves_of(h);
        REQUIRE(all.size() == h.leaf_count());
        const std::set<HierarchyNode> nodes = test::nodes_of(h);
        REQUIRE(nodes.size() == all.size());
        std::size_t i = 0;
        for (const HierarchyNode& node : nodes) {
            const std::optional<LeafHandle> leaf = h.find(node);
            REQUIRE(leaf.has_value());
            REQUIRE(h.node(*leaf) == node);
            // A set is sorted. Those of sqrt3 have a curve of their own.
            if (scheme != "sqrt3") REQUIRE(leaf == all[i]);
            const LeafView view = h.view(*leaf);
            const NodeView same = h.view(node);
            CHECK(view.corner == same.corner);
            CHECK(view.face == same.face);
            CHECK(view.level == same.level);
            CHECK(!mesh.is_hole(view.face));
            for (const HierarchyNode& child : h.children(node)) {
                REQUIRE(h.parent(child) == node);
                REQUIRE(!h.find(child));
            }
            if (const auto parent = h.parent(node)) {
                const auto siblings = h.children(*parent);
                REQUIRE(std::count(siblings.begin(), siblings.end(), node) == 1);
                REQUIRE(!h.find(*parent));
            } else {
                CHECK(node.depth == 0);
            }
            ++i;
        }
        // The children of a node cover its corners, each with one of its own.
        HierarchyNode node = h.node(all.front());
        if (scheme == "sqrt3" && node.depth % 2 != 0) node = *h.parent(node);  // not of a half triangle: it moves on
        std::set<Site> corners;
        for (const HierarchyNode& child : h.children(node)) {
            const NodeView view = h.view(child);
            corners.insert(view.corner.begin(), view.corner.begin() + view.corner_count);
        }
        const NodeView view = h.view(node);
        for (int k = 0; k < view.corner_count; ++k) CHECK(corners.count(view.corner[static_cast<std::size_t>(k)]) == 1);
    }
}

TEST_CASE("meshes as triangles: dual faces are cut into triangles of the same leaf, others are as they are") {
    for (const std::uint64_t seed : test::seeds(4)) {
        CAPTURE(seed);
        const ControlMesh mesh = test::random_dual_mesh(seed);
        Hierarchy h = make_hierarchy(mesh, "doo-sabin");
        Random random(seed);
        test::random_changes(h, 10, 3, random, [] {});
        const HierarchyMesh polygons = h.to_mesh(), cut = h.to_mesh({.triangles = true});
        CHECK(test::same_bytes(cut.mesh.positions, polygons.mesh.positions));
        REQUIRE(cut.leaves.size() == cut.mesh.face_count());
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

TEST_CASE("an estimator is asked for all four triangles of a leaf between split ones") {
    // Only one of the triangles that the leaf's split would make is off.
    class OneOff final : public ErrorEstimator {
      public:
        explicit OneOff(const CellTriangle& off) : off_(off) {}
        using ErrorEstimator::estimate;
        void estimate(std::span<const CellTriangle> triangles, std::span<double> errors) const override {
            for (std::size_t i = 0; i < triangles.size(); ++i)
                errors[i] = triangles[i].root == off_.root && triangles[i].level == off_.level &&
                            triangles[i].corner == off_.corner;
        }

      private:
        CellTriangle off_;
    };
    const ControlMesh mesh = test::hierarchy_mesh("loop", 2);
    // The children of a root's middle triangle, which is turned over; the last of them is not.
    const std::array<std::array<LatticePoint, 3>, 4> corners{{{{{2, 2}, {1, 2}, {2, 1}}},
                                                              {{{1, 2}, {0, 2}, {1, 1}}},
                                                              {{{2, 1}, {1, 1}, {2, 0}}},
                                                              {{{1, 1}, {2, 1}, {1, 2}}}}};
    for (std::size_t k = 0; k < 4; ++k) {
        CAPTURE(k);
        Hierarchy h = make_hierarchy(mesh, "loop");
        h.refine_where(everything(), 2);
        const HierarchyNode parent{h.node(h.leaves().front()).root, 3ull << 62, 1};
        h.coarsen(*h.find(h.tree().child(parent, 0)));
        REQUIRE(h.find(parent).has_value());
        const OneOff off({mesh.face_halfedge(FaceId(parent.root)), 2, corners[k]});
        CHECK(h.refine_where(off, 0.5, 2) == 4);
        CHECK_FALSE(h.find(parent).has_value());
    }
}

TEST_CASE("[bad-input] handles, diamonds, nodes, sides, sites, levels and depths that are none: nothing changes") {
    for (const std::string_view scheme : test::k_each_family) {
        CAPTURE(scheme);
        const ControlMesh mesh = test::hierarchy_mesh(scheme, 2);
        Hierarchy h = make_hierarchy(mesh, scheme);
        const std::vector<LeafHandle> roots = test::leaves_of(h);
        const auto first = h.refine(roots[0]);
        h.refine(first);
        const HierarchyMesh before = h.to_mesh();
        const auto fails = [&](auto&& call, std::string_view text) {
            const Error error = error_of(call);
            CHECK(error.code() == ErrorCode::invalid_input);
            const std::string message = error.what();
            CAPTURE(message);
            CHECK(message.find(text) != std::string::npos);
            test::check_sound(h);
            CHECK(test::same_mesh(h.to_mesh(), before));
        };
        fails([&] { h.refine(roots[0]); }, "split or merged");
        fails([&] { h.refine(LeafHandle{LeafId(1u << 30), 0}); }, "does not exist");
        fails([&] { h.refine(LeafHandle{}); }, "does not exist");
        // Roots, and leaves beside finer ones.
        int blocked = 0;
        for (const LeafHandle leaf : test::leaves_of(h))
            if (!h.can_coarsen(leaf) && ++blocked <= 5) fails([&] { h.coarsen(leaf); }, "diamond");
        CHECK(blocked > 1);
        fails([&] { (void)h.neighbours(h.leaves()[0], is_dual(h) ? 4 : 3); }, "side");
        fails([&] { (void)h.neighbours(h.leaves()[0], -1); }, "side -1");
        fails([&] { (void)h.view(HierarchyNode{h.tree().root_bound, 0, 0}); }, "node");
        fails([&] { (void)h.find(HierarchyNode{0, 1, 1}); }, "node");
        fails([&] { (void)h.to_mesh({.positions = MeshPositions::level, .level = -1}); }, "-1");
        fails([&] { h.refine_where(everything(), 1000); }, "1000");
        const Site site = h.view(h.leaves()[0]).corner[0];
        std::vector<Vec3d> too_few;
        fails([&] { h.limit_positions({&site, 1}, too_few); }, "room");
        const std::uint32_t bound = h.tree().root_bound;
        if (scheme == "sqrt3") {
            fails([&] { (void)h.limit(Site{HalfedgeId(4), {0, 0}, 0}); }, "root");
            fails([&] { (void)h.limit(Site{HalfedgeId(0), {1, 1}, 60}); }, "above");
            fails([&] { (void)h.limit(Site{HalfedgeId(0), {3, 1}, 1}); }, "coordinates");
            fails([&] { (void)h.limit(Site{HalfedgeId(0), {3, 3}, 2}); }, "canonical");
            fails([&] { (void)h.position(Site{HalfedgeId(0), {1, 1}, 1}, 0); }, "first level");
            fails([&] { (void)h.position(Site{HalfedgeId(0), {1, 1}, 1}, 99); }, "99");
        } else if (is_dual(h)) {
            fails([&] { (void)h.limit(Site{HalfedgeId(bound), {0, 0}, 0}); }, "root");
        } else {
            fails([&] { (void)h.limit(Site{HalfedgeId(mesh.halfedge_count()), {0, 0}, 0}); }, "root");
            fails([&] { (void)h.limit(Site{HalfedgeId(0), {3, 0}, 1}); }, "coordinates");
            fails([&] { (void)h.limit(Site{HalfedgeId(0), {0, 0}, 31}); }, "level");
            fails([&] { (void)h.position(Site{HalfedgeId(0), {1, 0}, 3}, 1); }, "first level");
            fails([&] { (void)h.position(Site{HalfedgeId(0), {0, 0}, 0}, 99); }, "99");
        }
    }
}

TEST_CASE("[bad-input] the deepest leaves are found, in order, and cannot be split") {
    for (const std::string_view scheme : test::k_each_family) {
        CAPTURE(scheme);
        const ControlMesh mesh = test::hierarchy_mesh(scheme, 2);
        Hierarchy h = make_hierarchy(mesh, scheme);
        LeafHandle deepest = h.leaves()[0];
        const auto depth = [&](LeafHandle leaf) { return h.node(leaf).depth; };
        const std::size_t roots = h.leaf_count();
        while (depth(deepest) < h.tree().max_depth) {
            const std::size_t before = h.leaf_count();
            const auto created = h.refine(deepest);
            CHECK(h.leaf_count() - before < 40 + 4 * roots);
            deepest = *std::ranges::max_element(created, {}, depth);
        }
        const auto before = test::nodes_of(h);
        CHECK(error_of([&] { h.refine(deepest); }).code() == ErrorCode::unsupported);
        CHECK(h.children(h.node(deepest)).empty());
        test::check_sound(h);
        CHECK(test::nodes_of(h) == before);
        for (const LeafHandle leaf : h.leaves()) CHECK(h.find(h.node(leaf)) == leaf);
        const HierarchyMesh out = h.to_mesh({.normals = true});
        CHECK(out.mesh.face_count() > before.size() / 2);
        for (const Vec3d& n : out.mesh.normals) CHECK(glm::length(n) == doctest::Approx(1));
        CHECK(test::topology(test::faces_of(out.mesh)).fault.empty());
        h.shrink();
        CHECK(h.memory_bytes() < 160 * before.size() + 65536);
    }
}

TEST_SUITE_END();
