#include "../../refine/adaptive/hierarchy.hpp"

#include "../kit/hierarchy_helpers.hpp"
#include "../kit/surface_topology.hpp"
#include "../kit/uniform_sites.hpp"

#include "../../hier/base/error.hpp"
#include "../../hier/base/parallel.hpp"
#include "../../hier/forest/corner_cell.hpp"
#include "../../hier/forest/triangle_cell.hpp"
#include "../../refine/adaptive/hierarchy_view.hpp"
#include "../../refine/uniform/refine.hpp"
#include "../../refine/uniform/uniform.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

using namespace tetrakis;
using test::Random;

namespace {

constexpr std::string_view k_schemes[] = {"catmull-clark", "bilinear", "loop", "midpoint"};
/// One or two of each family whose leaves are triangles.
constexpr std::string_view k_all_families[] = {"catmull-clark", "bilinear", "loop", "midpoint", "sqrt3"};
constexpr std::string_view k_each_family[] = {"catmull-clark", "loop", "sqrt3"};
constexpr std::string_view k_with_dual[] = {"catmull-clark", "loop", "doo-sabin", "sqrt3"};

void check_sound(const Hierarchy& h) {
    const auto fault = h.check();
    CHECK_MESSAGE(!fault, fault.value_or(""));
}

bool is_triangles(const Hierarchy& h) { return h.family() == "triangles"; }
/// Whether a split makes four of one, so that a depth is a level.
bool is_quaternary(const Hierarchy& h) { return h.tree().child_count == 4; }

// Undoes what was split since the leaves were these, one diamond at a time, the deepest first.
void undo_splits(Hierarchy& h, const std::set<HierarchyNode>& before) {
    const auto was_split = [&](const HierarchyNode& node) {
        const auto next = before.upper_bound(node);
        return next != before.end() && h.tree().is_ancestor(node, *next);
    };
    const auto undo_one = [&] {
        std::vector<LeafHandle> leaves = test::leaves_of(h);
        std::stable_sort(leaves.begin(), leaves.end(),
                         [&](LeafHandle a, LeafHandle b) { return h.node(a).depth > h.node(b).depth; });
        for (const LeafHandle leaf : leaves) {
            std::optional<HierarchyNode> split = h.parent(h.node(leaf));
            if (split && h.tree().halves && split->depth % 2 != 0) split = h.parent(*split);
            if (!split || was_split(*split) || !h.can_coarsen(leaf)) continue;
            h.coarsen(leaf);
            return true;
        }
        return false;
    };
    while (undo_one()) {
    }
}

// Sites of all vertices of a uniform level, with their numbers in its mesh.
std::map<Site, std::uint32_t> sites_of_level(const ControlMesh& mesh, const PolygonMesh& level, bool triangles,
                                             int levels) {
    const SchemeKind kind = triangles ? SchemeKind::loop : SchemeKind::catmull_clark;
    const std::vector<Site> corners = test::uniform_sites(mesh, kind, levels);
    REQUIRE(corners.size() == level.face_vertices.size());
    std::map<Site, std::uint32_t> result;
    for (std::size_t i = 0; i < corners.size(); ++i)
        result[triangles ? canonical_triangle_site(mesh, corners[i]) : canonical(mesh, corners[i])] =
            level.face_vertices[i];
    return result;
}

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

TEST_CASE(
    "[inv1] every vertex of a hierarchy is where uniform refinement has it: at levels, in the limit, at its finest") {
    for (const std::string_view scheme : k_schemes)
        for (const std::uint64_t seed : test::seeds(6)) {
            CAPTURE(scheme);
            CAPTURE(seed);
            const ControlMesh mesh = test::hierarchy_mesh(scheme, seed);
            if (mesh.halfedge_count() == 0) continue;
            const double size = bounding_box(mesh.positions()).diagonal(), tolerance = 1e-12 * size;
            Hierarchy h = make_hierarchy(mesh, scheme);
            const bool triangles = is_triangles(h), smooth = scheme == "catmull-clark" || scheme == "loop";
            constexpr int k_levels = 4;
            Random random(seed);
            for (int pass = 0; pass < 3; ++pass) {
                auto some = test::random_subset(test::leaves_of(h), 0.3, random);
                std::erase_if(some, [&](LeafHandle leaf) { return h.view(leaf).level >= k_levels - 1; });
                h.refine(some);
            }
            // Finest levels by brute force.
            const HierarchyMesh shape = h.to_mesh();
            if (shape.mesh.face_count() == 0) continue;
            std::vector<int> finest(shape.sites.size(), 0);
            for (std::uint32_t f = 0; f < shape.mesh.face_count(); ++f)
                for (std::uint32_t i = shape.mesh.face_offsets[f]; i < shape.mesh.face_offsets[f + 1]; ++i) {
                    int& l = finest[shape.mesh.face_vertices[i]];
                    l = std::max(l, static_cast<int>(h.view(shape.leaves[f]).level));
                }
            const HierarchyMesh at_finest = h.to_mesh({.positions = MeshPositions::finest});
            CHECK(at_finest.sites == shape.sites);
            int compared = 0;
            for (int level = 1; level <= k_levels; ++level) {
                CAPTURE(level);
                const PolygonMesh uniform = refine(mesh, scheme, level);
                const auto numbers = sites_of_level(mesh, uniform, triangles, level);
                const std::vector<Vec3d> normals = area_normals(uniform);
                const HierarchyMesh out =
                    h.to_mesh({.positions = MeshPositions::level, .level = level, .normals = true});
                for (std::size_t v = 0; v < shape.sites.size(); ++v) {
                    if (h.first_level(shape.sites[v]) > level) continue;
                    const std::uint32_t number = numbers.at(shape.sites[v]);
                    REQUIRE(glm::length(out.mesh.positions[v] - uniform.positions[number]) <= tolerance);
                    REQUIRE(out.mesh.positions[v] == h.position(shape.sites[v], level));
                    // Holes count as faces around a vertex for the rules, but are not in the uniform mesh.
                    const double length = glm::length(normals[number]);
                    if (mesh.data().holes.empty() && mesh.boundary_rule() != BoundaryRule::none &&
                        length > 1e-6 * size * size / std::pow(4.0, level))
                        REQUIRE(glm::length(out.mesh.normals[v] - normals[number] / length) < 1e-6);
                    if (finest[v] != level) continue;
                    ++compared;
                    REQUIRE(glm::length(at_finest.mesh.positions[v] - uniform.positions[number]) <= tolerance);
                }
            }
            CHECK(compared > 0);
            const bool with_normals = smooth;
            const PolygonMesh limit = refine(mesh, scheme, k_levels, {.limit = true, .normals = with_normals});
            const auto numbers = sites_of_level(mesh, limit, triangles, k_levels);
            const HierarchyMesh out = h.to_mesh({.normals = true});
            for (std::size_t v = 0; v < out.sites.size(); ++v) {
                const std::uint32_t number = numbers.at(out.sites[v]);
                REQUIRE(glm::length(out.mesh.positions[v] - limit.positions[number]) <= tolerance);
                const LimitPoint point = h.limit(out.sites[v]);
                CHECK(point.has_tangent_plane <= smooth);
                if (!point.has_tangent_plane) continue;
                REQUIRE(glm::length(out.mesh.normals[v] - limit.normals[number]) < 1e-8);
                const auto [t1, t2] = h.tangents(out.sites[v]);
                REQUIRE(glm::length(glm::normalize(glm::cross(t1, t2)) - point.normal) < 1e-9);
            }
        }
}

TEST_CASE("[inv1] level 0 is the control mesh") {
    for (const std::string_view scheme : k_schemes) {
        CAPTURE(scheme);
        const ControlMesh mesh = test::hierarchy_mesh(scheme, 3);
        const Hierarchy h = make_hierarchy(mesh, scheme);
        for (std::uint32_t i = 0; i < mesh.halfedge_count(); ++i) {
            const HalfedgeId corner(i);
            if (is_triangles(h) && mesh.face_halfedge(mesh.face(corner)) != corner) continue;
            const Site site{corner, {0, 0}, 0};
            CHECK(h.first_level(site) == 0);
            CHECK(h.position(site, 0) == mesh.position(mesh.origin(corner)));
            // The plane across the normal holds the mean of the triangles around: no face turns against it much.
            const LimitPoint frame = h.frame(site, 0);
            CHECK(frame.position == mesh.position(mesh.origin(corner)));
            if (frame.has_tangent_plane) {
                CHECK(std::abs(glm::length(frame.normal) - 1) < 1e-12);
                CHECK(std::abs(glm::dot(frame.normal, frame.tangent1)) <= 1e-9 * glm::length(frame.tangent1));
                CHECK(glm::dot(glm::cross(frame.tangent1, frame.tangent2), frame.normal) >= 0);
            }
        }
    }
}

TEST_CASE(
    "[inv2] [inv5] thousands of changes: the same leaves give the same bytes, refined up to or coarsened down to") {
    for (const std::string_view scheme : k_with_dual)
        for (const std::uint64_t seed : test::seeds(5)) {
            CAPTURE(scheme);
            CAPTURE(seed);
            const ControlMesh mesh = test::hierarchy_mesh(scheme, seed);
            Hierarchy h = make_hierarchy(mesh, scheme);
            if (h.leaf_count() == 0) continue;
            Random random(seed);
            const int depth = is_quaternary(h) ? 4 : 7;
            int round = 0;
            test::random_changes(h, 120, depth, random, [&] {
                if (++round % 30 == 0) check_sound(h);
            });
            const std::set<HierarchyNode> target = test::nodes_of(h);
            const HierarchyMesh expected = h.to_mesh({.normals = true});
            // Up from the roots.
            Hierarchy up = make_hierarchy(mesh, scheme);
            up.refine_where(each_leaf([&](const LeafView& leaf) { return target.count(leaf.node) == 0; }),
                            up.tree().max_depth);
            CHECK(test::nodes_of(up) == target);
            check_sound(up);
            CHECK(test::same_mesh(up.to_mesh({.normals = true}), expected));
            // Down from a finer mesh: what lies below a target node may be merged.
            Hierarchy down = make_hierarchy(mesh, scheme);
            int deepest = 0;
            for (const HierarchyNode& node : target) deepest = std::max<int>(deepest, node.depth);
            down.refine_where(each_leaf([](const LeafView&) { return true; }), deepest);
            // sqrt3: a whole triangle whose half is wanted becomes that by a merge beyond its edge.
            const auto stays = [&](const HierarchyNode& node) {
                return target.count(node) != 0 || (scheme == "sqrt3" && node.depth > 0 && node.depth % 2 == 0 &&
                                                   target.count(down.tree().parent(node)) != 0);
            };
            down.coarsen_where(each_leaf([&](const LeafView& leaf) { return !stays(leaf.node); }));
            CHECK(test::nodes_of(down) == target);
            check_sound(down);
            CHECK(test::same_mesh(down.to_mesh({.normals = true}), expected));
            // To the roots.
            h.coarsen_where(each_leaf([](const LeafView&) { return true; }));
            check_sound(h);
            CHECK(test::same_mesh(h.to_mesh(), make_hierarchy(mesh, scheme).to_mesh()));
        }
}

TEST_CASE(
    "[inv2] [inv5] [inv10] [slow] thousands of changes by any number of threads: the same handles, and the roots") {
    constexpr std::uint64_t k_seed = 12;
    for (const std::string_view scheme :
         {"catmull-clark", "kobbelt", "4-8", "loop", "butterfly", "doo-sabin", "midedge", "biquartic", "sqrt3"}) {
        CAPTURE(scheme);
        const ControlMesh mesh = test::hierarchy_mesh(scheme, k_seed);
        std::vector<std::vector<LeafHandle>> expected;
        for (const int threads : {1, 2, 4}) {
            CAPTURE(threads);
            Hierarchy h = make_hierarchy(mesh, scheme);
            const std::uint32_t roots = h.leaf_count();
            REQUIRE(roots > 0);
            std::vector<std::vector<LeafHandle>> states;
            std::uint32_t round = 0, before = roots, changes = 0;
            Random random(k_seed);
            RunContext context;
            context.threads = threads;
            with_threads(context, [&] {
                test::random_changes(h, 400, is_quaternary(h) ? 4 : 7, random, [&] {
                    const std::uint32_t now = h.leaf_count();
                    changes += std::max(now, before) - std::min(now, before);
                    before = now;
                    if (++round % 40 != 0) return;
                    check_sound(h);
                    states.push_back(test::leaves_of(h));
                });
                CHECK(changes > 2000);
                h.coarsen_where(each_leaf([](const LeafView&) { return true; }));
            });
            CHECK(h.leaf_count() == roots);
            if (expected.empty()) expected = states;
            CHECK(states == expected);
        }
    }
}

TEST_CASE("equal parts of the leaves are compact") {
    for (const std::string_view scheme : {"catmull-clark", "loop", "doo-sabin", "sqrt3"}) {
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

TEST_CASE("[inv5] coarsening diamonds one by one undoes any refinement of a leaf") {
    for (const std::string_view scheme : {"catmull-clark", "bilinear", "loop", "midpoint", "doo-sabin", "sqrt3"})
        for (const std::uint64_t seed : test::seeds(3)) {
            CAPTURE(scheme);
            CAPTURE(seed);
            const ControlMesh mesh = test::hierarchy_mesh(scheme, seed);
            Hierarchy h = make_hierarchy(mesh, scheme);
            Random random(seed);
            test::random_changes(h, 20, 4, random, [] {});
            for (int trial = 0; trial < 10 && h.leaf_count() > 0; ++trial) {
                const auto all = test::leaves_of(h);
                const LeafHandle leaf = all[random.below(static_cast<std::uint32_t>(all.size()))];
                const std::set<HierarchyNode> before = test::nodes_of(h);
                const HierarchyMesh mesh_before = h.to_mesh();
                h.refine(leaf);
                CHECK(!h.is_leaf(leaf));
                undo_splits(h, before);
                REQUIRE(test::nodes_of(h) == before);
                CHECK(test::same_mesh(h.to_mesh(), mesh_before));
            }
            check_sound(h);
        }
}

TEST_CASE("[inv5] an evenly refined hierarchy of any family is merged to its roots one diamond at a time") {
    for (const std::string_view scheme : {"catmull-clark", "4-8", "loop", "butterfly", "doo-sabin", "sqrt3"}) {
        CAPTURE(scheme);
        const ControlMesh mesh = test::hierarchy_mesh(scheme, 2);
        Hierarchy h = make_hierarchy(mesh, scheme);
        const HierarchyMesh roots = h.to_mesh();
        const int depth = is_quaternary(h) ? 2 : 4;
        h.refine_where(each_leaf([](const LeafView&) { return true; }), depth);
        if (h.family() == "triangles")
            for (LeafHandle leaf : h.leaves()) CHECK(h.can_coarsen(leaf));
        Random random(7);
        std::size_t merges = 1;
        for (int pass = 0; merges > 0; ++pass) {
            REQUIRE(pass < 100);
            merges = 0;
            for (LeafHandle leaf : test::random_subset(test::leaves_of(h), 0.7, random))
                if (h.is_leaf(leaf) && h.can_coarsen(leaf)) {
                    h.coarsen(leaf);
                    ++merges;
                }
            if (pass < 3) check_sound(h);
            // A pass may have left out the last ones.
            if (merges == 0)
                for (LeafHandle leaf : h.leaves()) merges += h.can_coarsen(leaf);
        }
        check_sound(h);
        CHECK(test::same_mesh(h.to_mesh(), roots));
    }
}

TEST_CASE("the adaptive engine splits triangles between split ones, which leaves the mesh as it is") {
    for (const std::uint64_t seed : test::seeds(6)) {
        CAPTURE(seed);
        const ControlMesh mesh = test::hierarchy_mesh("loop", seed);
        TriangleHierarchy h(mesh);
        Random random(seed);
        std::vector<LeafId> fresh, created, changed;
        std::uint32_t between = 0;
        for (int round = 0; round < 8; ++round) {
            std::vector<LeafId> marked;
            h.initial_leaves(marked);
            std::erase_if(marked, [&](LeafId leaf) { return h.level(leaf) > 5 || !random.chance(0.3); });
            TriangleForest plain = h.forest();
            plain.refine(marked, created, changed);
            fresh.clear();
            h.refine(marked, fresh);
            between += h.forest().leaf_count() - plain.leaf_count();
            const ExportedTriangles out = h.forest().exported(), expected = plain.exported();
            CHECK(out.triangles == expected.triangles);
            CHECK(out.sites == expected.sites);
            CHECK(out.triangles.size() == h.triangle_count());
            for (LeafId leaf : out.leaves) REQUIRE(h.forest().green_triangles(leaf).count <= 3);
            for (LeafId leaf : fresh) REQUIRE(h.is_leaf(leaf));
            CHECK(std::set<LeafId>(fresh.begin(), fresh.end()).size() == fresh.size());
        }
        CHECK((h.forest().leaf_count() == 0 || between > 0));
    }
}

TEST_CASE("an estimator is asked for all four triangles of a leaf between split ones") {
    // Only one of the triangles that the leaf's split would make is off.
    class OneOff final : public ErrorEstimator {
      public:
        explicit OneOff(const CellTriangle& off) : off_(off) {}
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
        h.refine_where(each_leaf([](const LeafView&) { return true; }), 2);
        const HierarchyNode parent{h.node(h.leaves().front()).root, 3ull << 62, 1};
        h.coarsen(*h.find(h.tree().child(parent, 0)));
        REQUIRE(h.find(parent).has_value());
        const OneOff off({mesh.face_halfedge(FaceId(parent.root)), 2, corners[k]});
        CHECK(h.refine_where(off, 0.5, 2) == 4);
        CHECK_FALSE(h.find(parent).has_value());
    }
}

TEST_CASE("[inv3] [inv4] meshes are conforming with the control mesh's topology, neighbours one level apart at most") {
    for (const std::string_view scheme : k_all_families)
        for (const std::uint64_t seed : test::seeds(8)) {
            CAPTURE(scheme);
            CAPTURE(seed);
            const ControlMesh mesh = test::hierarchy_mesh(scheme, seed);
            Hierarchy h = make_hierarchy(mesh, scheme);
            const auto expected = test::surface_topology(mesh);
            Random random(seed);
            test::random_changes(h, 25, is_triangles(h) ? 5 : 9, random, [] {});
            const auto found = test::topology(test::faces_of(h.to_mesh().mesh));
            CHECK(found.fault.empty());
            CHECK(found.euler == expected.euler);
            CHECK(found.boundary_loops == expected.boundary_loops);
            for (LeafHandle leaf : h.leaves())
                for (int side = 0; side < h.view(leaf).corner_count; ++side)
                    for (LeafHandle across : h.neighbours(leaf, side)) {
                        // sqrt3: a half triangle beside one of the next level, which is whole over a crease at once.
                        REQUIRE(std::abs(h.node(across).depth - h.node(leaf).depth) <= (scheme == "sqrt3" ? 3 : 1));
                        REQUIRE(std::abs(h.view(across).level - h.view(leaf).level) <= 1);
                        bool back = false;
                        for (int k = 0; k < 3; ++k)
                            for (LeafHandle other : h.neighbours(across, k)) back |= other == leaf;
                        REQUIRE(back);
                    }
        }
}

TEST_CASE("[inv4] neighbours are the leaves that share the side's vertices in the mesh") {
    for (const std::string_view scheme : k_each_family) {
        CAPTURE(scheme);
        const ControlMesh mesh = test::hierarchy_mesh(scheme, 1);
        Hierarchy h = make_hierarchy(mesh, scheme);
        Random random(7);
        test::random_changes(h, 15, 4, random, [] {});
        const HierarchyMesh out = h.to_mesh();
        std::map<std::pair<std::uint32_t, std::uint32_t>, LeafHandle> owner;  // by directed edge
        const auto faces = test::faces_of(out.mesh);
        for (std::size_t f = 0; f < faces.size(); ++f)
            for (std::size_t i = 0; i < 3; ++i) owner[{faces[f][i], faces[f][(i + 1) % 3]}] = out.leaves[f];
        // The leaves beyond the edges of a leaf's faces, other than itself.
        std::map<LeafHandle, std::set<LeafHandle>> expected, found;
        for (const auto& [edge, leaf] : owner) {
            const auto twin = owner.find({edge.second, edge.first});
            if (twin != owner.end() && twin->second != leaf) expected[leaf].insert(twin->second);
        }
        for (LeafHandle leaf : h.leaves())
            for (int side = 0; side < 3; ++side)
                for (LeafHandle across : h.neighbours(leaf, side)) found[leaf].insert(across);
        CHECK(found == expected);
    }
}

TEST_CASE("leaves come along the curve, and nodes know their parents, children and leaves") {
    for (const std::string_view scheme : k_all_families) {
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

TEST_CASE("[inv7] meshes of hierarchies commute with affine maps") {
    const auto map = [](const Vec3d& p) {
        return Vec3d(2 * p.x - p.y + 0.5 * p.z + 3, 0.3 * p.x + p.y - 7, p.x + 0.2 * p.y - 1.5 * p.z);
    };
    for (const std::string_view scheme : k_with_dual)
        for (const std::uint64_t seed : test::seeds(3)) {
            CAPTURE(scheme);
            CAPTURE(seed);
            const ControlMesh mesh = test::hierarchy_mesh(scheme, seed);
            ControlMeshData data = mesh.data();
            for (Vec3d& p : data.positions) p = map(p);
            const ControlMesh mapped = ControlMesh::build(std::move(data));
            Hierarchy a = make_hierarchy(mesh, scheme), b = make_hierarchy(mapped, scheme);
            Random random(seed);
            test::random_changes(a, 12, 5, random, [] {});
            b.refine_where(each_leaf([&](const LeafView& leaf) { return !a.find(leaf.node); }), b.tree().max_depth);
            REQUIRE(test::nodes_of(a) == test::nodes_of(b));
            const double tolerance = 1e-12 * bounding_box(mapped.positions()).diagonal();
            for (const MeshPositions positions : {MeshPositions::limit, MeshPositions::finest}) {
                const HierarchyMesh here = a.to_mesh({.positions = positions}),
                                    there = b.to_mesh({.positions = positions});
                REQUIRE(here.sites == there.sites);
                for (std::size_t v = 0; v < here.sites.size(); ++v)
                    REQUIRE(glm::length(map(here.mesh.positions[v]) - there.mesh.positions[v]) <= tolerance);
            }
        }
}

TEST_CASE("[inv10] refinement, order and meshes are the same for 1, 2 and 4 threads") {
    for (const std::string_view scheme : k_with_dual) {
        CAPTURE(scheme);
        const ControlMesh mesh = test::hierarchy_mesh(scheme, 5);
        const auto run = [&](int threads) {
            RunContext context;
            context.threads = threads;
            Hierarchy h = make_hierarchy(mesh, scheme);
            const auto wanted = each_leaf([](const LeafView& leaf) {
                return (leaf.node.root * 7 + leaf.node.depth) % 3 != 0 || leaf.node.depth < 2;
            });
            h.refine_where(wanted, is_quaternary(h) ? 4 : 8, context);
            h.coarsen_where(each_leaf([](const LeafView& leaf) { return leaf.node.root % 5 == 0; }), context);
            HierarchyMesh out = h.to_mesh({.normals = true, .context = context});
            return std::pair(std::move(out), test::leaves_of(h));
        };
        const auto one = run(1);
        for (int threads : {2, 4}) {
            const auto other = run(threads);
            CHECK(test::same_mesh(other.first, one.first));
            CHECK(other.second == one.second);
            CHECK(other.first.points == one.first.points);
        }
    }
}

TEST_CASE("leaves take few bytes once working memory is given back, and nothing else changes") {
    for (const std::string_view scheme : {"catmull-clark", "loop", "doo-sabin", "sqrt3"}) {
        CAPTURE(scheme);
        test::RandomMeshOptions closed{.topology = test::Topology::torus,
                                       .split = 0,
                                       .merge = 0,
                                       .edge_vertices = 0,
                                       .removed_faces = 0,
                                       .hole = 0,
                                       .crease = 0,
                                       .corner = 0};
        closed.triangles_only = find_scheme(scheme)->family == MeshFamily::triangles;
        const ControlMesh mesh = test::random_mesh(3, closed);
        Hierarchy h = make_hierarchy(mesh, scheme);
        const auto all = each_leaf([](const LeafView&) { return true; });
        while (h.leaf_count() < 50'000) h.refine_where(all, h.view(h.leaves().front()).node.depth + 1);
        const HierarchyMesh before = h.to_mesh();
        h.shrink();
        const double leaves = h.leaf_count(), points = static_cast<double>(before.mesh.positions.size());
        const bool has_sites = scheme == "catmull-clark" || scheme == "loop";
        const double bytes = (static_cast<double>(h.memory_bytes()) - (has_sites ? 16 * points : 0)) / leaves;
        const double most = scheme == "catmull-clark" ? 52 : scheme == "loop" ? 31 : scheme == "doo-sabin" ? 26 : 39;
        CHECK(bytes < most + 1);  // and what the control mesh has
        check_sound(h);
        CHECK(h.to_mesh().mesh.positions == before.mesh.positions);
        const LeafHandle leaf = h.leaves()[1234];
        h.refine(leaf);
        check_sound(h);
        CHECK_FALSE(h.is_leaf(leaf));
    }
}

TEST_CASE("a zoom of 25 levels into one spot costs leaves by the level, not by the area") {
    for (const std::string_view scheme : k_each_family) {
        CAPTURE(scheme);
        const ControlMesh mesh = test::hierarchy_mesh(scheme, 4);
        Hierarchy h = make_hierarchy(mesh, scheme);
        const int per_level = is_triangles(h) ? 1 : 2, depth = 25 * per_level;
        // A point inside a root: an endless path that stays off its corners.
        const std::uint32_t root = h.node(h.leaves()[h.leaf_count() / 2]).root;
        HierarchyNode deepest{root, 0, 0};
        for (int d = 0; d < depth; ++d) deepest = h.tree().child(deepest, d / per_level % 2);
        const std::uint32_t roots = h.leaf_count();
        const std::size_t created = h.refine_where(
            each_leaf([&](const LeafView& leaf) { return h.tree().is_ancestor(leaf.node, deepest); }), depth);
        CHECK(h.find(deepest).has_value());
        check_sound(h);
        // Rings of a bounded number of leaves around the spot, one a level; splits of a leaf count its parts.
        const std::uint32_t leaves = h.leaf_count() - roots;
        CHECK(leaves > 25);
        CHECK(leaves < 25 * 64);
        CHECK(created < 25 * 128);
        CHECK(h.memory_bytes() < 512 * (roots + std::uint64_t{leaves}) + 65536);
        const HierarchyMesh out = h.to_mesh({.normals = true});
        const auto topology = test::topology(test::faces_of(out.mesh));
        CHECK(topology.fault.empty());
        CHECK(topology.euler == test::surface_topology(mesh).euler);
        for (const Vec3d& p : out.mesh.positions) REQUIRE(std::isfinite(p.x + p.y + p.z));
        // The spot's corners are apart by about 2^-25 of the root, and distinct.
        const NodeView view = h.view(deepest);
        const double edge = glm::length(h.limit(view.corner[0]).position - h.limit(view.corner[1]).position);
        CHECK(edge > 0);
        CHECK(edge < 1e-5);
        h.coarsen_where(each_leaf([](const LeafView&) { return true; }));
        CHECK(h.leaf_count() == roots);
    }
}

TEST_CASE("an estimator drives refinement to the smallest set within the tolerance, and coarsening back") {
    /// The size of a triangle in the lattice, larger in one root: known without a surface.
    class Size final : public ErrorEstimator {
      public:
        explicit Size(HalfedgeId fine) : fine_(fine) {}
        void estimate(std::span<const CellTriangle> triangles, std::span<double> errors) const override {
            for (std::size_t i = 0; i < triangles.size(); ++i)
                errors[i] = (triangles[i].root == fine_ ? 8.0 : 1.0) / static_cast<double>(1u << triangles[i].level);
        }

      private:
        HalfedgeId fine_;
    };
    for (const std::string_view scheme : k_schemes) {
        CAPTURE(scheme);
        const ControlMesh mesh = test::hierarchy_mesh(scheme, 1);
        Hierarchy h = make_hierarchy(mesh, scheme);
        const LeafView middle = h.view(h.leaves()[h.leaf_count() / 2]);
        const Size size(is_triangles(h) ? mesh.face_halfedge(middle.face) : HalfedgeId(middle.node.root));
        const int deep = is_triangles(h) ? 12 : 24;
        h.refine_where(size, 0.5, deep);
        check_sound(h);
        const std::set<HierarchyNode> wanted = test::nodes_of(h);
        int deepest = 0;
        for (const HierarchyNode& node : wanted) deepest = std::max<int>(deepest, node.depth);
        // 8 / 2^4 = 0.5: lattice level 4, the other roots at 1 away from it.
        CHECK(deepest == (is_triangles(h) ? 4 : 8));
        CHECK(h.refine_where(size, 0.5, deep) == 0);
        h.refine_where(each_leaf([](const LeafView&) { return true; }), deepest);
        h.coarsen_where(size, 0.5);
        check_sound(h);
        CHECK(test::nodes_of(h) == wanted);
        CHECK_THROWS_AS(h.refine_where(size, std::nan(""), deep), Error);
        CHECK_THROWS_AS(h.coarsen_where(size, -1), Error);
    }
}

TEST_CASE(
    "[bad-input] stale handles, diamonds that are none, depths, sites and levels that do not exist: named, nothing "
    "changes") {
    for (const std::string_view scheme : {"catmull-clark", "loop"}) {
        CAPTURE(scheme);
        const ControlMesh mesh = test::hierarchy_mesh(scheme, 2);
        Hierarchy h = make_hierarchy(mesh, scheme);
        const std::vector<LeafHandle> roots = test::leaves_of(h);
        const auto first = h.refine(roots[0]);
        h.refine(first.front());
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
            check_sound(h);
            CHECK(test::same_mesh(h.to_mesh(), before));
        };
        // Refining twice.
        fails([&] { h.refine(roots[0]); }, ErrorCode::invalid_input, "split or merged");
        fails([&] { h.coarsen(roots[0]); }, ErrorCode::invalid_input, "split or merged");
        fails([&] { (void)h.view(first.front()); }, ErrorCode::invalid_input, "split or merged");
        const std::vector<LeafHandle> mixed{h.leaves().back(), roots[0]};
        fails([&] { h.refine(mixed); }, ErrorCode::invalid_input, "generation 0");
        fails([&] { h.coarsen(mixed); }, ErrorCode::invalid_input, "generation 0");
        fails([&] { h.refine(LeafHandle{LeafId(1u << 30), 0}); }, ErrorCode::invalid_input, "does not exist");
        fails([&] { h.refine(LeafHandle{}); }, ErrorCode::invalid_input, "does not exist");
        // A root, and a leaf beside finer ones.
        LeafHandle root, blocked;
        for (LeafHandle leaf : h.leaves())
            if (!h.can_coarsen(leaf)) (h.node(leaf).depth == 0 ? root : blocked) = leaf;
        REQUIRE(root.slot.valid());
        REQUIRE(blocked.slot.valid());
        fails([&] { h.coarsen(root); }, ErrorCode::invalid_input, "diamond");
        fails([&] { h.coarsen(blocked); }, ErrorCode::invalid_input, "diamond");
        // Nodes, sides, sites, levels, depths.
        fails([&] { (void)h.neighbours(h.leaves()[0], 3); }, ErrorCode::invalid_input, "side 3");
        fails([&] { (void)h.neighbours(h.leaves()[0], -1); }, ErrorCode::invalid_input, "side -1");
        fails([&] { (void)h.view(HierarchyNode{h.tree().root_bound, 0, 0}); }, ErrorCode::invalid_input, "node");
        fails([&] { (void)h.find(HierarchyNode{0, 1, 1}); }, ErrorCode::invalid_input, "node");
        fails(
            [&] {
                (void)h.limit(Site{HalfedgeId(mesh.halfedge_count()), {0, 0}, 0});
            },
            ErrorCode::invalid_input, "root");
        fails([&] { (void)h.limit(Site{HalfedgeId(0), {3, 0}, 1}); }, ErrorCode::invalid_input, "coordinates");
        fails([&] { (void)h.limit(Site{HalfedgeId(0), {0, 0}, 31}); }, ErrorCode::invalid_input, "level");
        fails([&] { (void)h.position(Site{HalfedgeId(0), {1, 0}, 3}, 1); }, ErrorCode::invalid_input, "first level");
        fails([&] { (void)h.position(Site{HalfedgeId(0), {0, 0}, 0}, 99); }, ErrorCode::invalid_input, "99");
        fails([&] { (void)h.position(Site{HalfedgeId(0), {0, 0}, 0}, -1); }, ErrorCode::invalid_input, "-1");
        std::vector<Vec3d> too_few;
        const Site site{HalfedgeId(0), {0, 0}, 0};
        fails([&] { h.limit_positions({&site, 1}, too_few); }, ErrorCode::invalid_input, "room");
        fails([&] { (void)h.to_mesh({.positions = MeshPositions::level, .level = -1}); }, ErrorCode::invalid_input,
              "-1");
        const auto all = each_leaf([](const LeafView&) { return true; });
        fails([&] { h.refine_where(all, 1000); }, ErrorCode::invalid_input, "1000");
    }
}

TEST_CASE("[bad-input] a slot that is used again does not revive the handles of its earlier leaves") {
    for (const std::string_view scheme : k_with_dual) {
        CAPTURE(scheme);
        const ControlMesh mesh = test::hierarchy_mesh(scheme, 2);
        Hierarchy h = make_hierarchy(mesh, scheme);
        const LeafHandle root = h.leaves()[0];
        std::set<LeafHandle> earlier{root};
        for (int i = 0; i < 5; ++i) {
            const LeafHandle leaf = *h.find(HierarchyNode{0, 0, 0});
            const auto created = h.refine(leaf);
            for (LeafHandle c : created) CHECK(earlier.insert(c).second);
            for (LeafHandle c : h.coarsen(created.front())) CHECK(earlier.insert(c).second);
        }
        CHECK(!h.is_leaf(root));
        int live = 0;
        for (LeafHandle leaf : earlier) live += h.is_leaf(leaf);
        CHECK(live <= 2);
        CHECK(test::nodes_of(h) == test::nodes_of(make_hierarchy(mesh, scheme)));
    }
}

TEST_CASE("[bad-input] the deepest leaves cannot be split") {
    for (const std::string_view scheme : {"catmull-clark", "loop", "doo-sabin"}) {
        CAPTURE(scheme);
        const ControlMesh mesh = test::hierarchy_mesh(scheme, 2);
        Hierarchy h = make_hierarchy(mesh, scheme);
        LeafHandle deepest = h.leaves()[0];
        while (h.node(deepest).depth < h.tree().max_depth) {
            const HierarchyNode child = h.tree().child(h.node(deepest), 0);
            h.refine(deepest);
            deepest = *h.find(child);
        }
        const auto before = test::nodes_of(h);
        try {
            h.refine(deepest);
            FAIL("no error");
        } catch (const Error& e) {
            CHECK(e.code() == ErrorCode::unsupported);
            CHECK(std::string(e.what()).find("depth " + std::to_string(h.tree().max_depth)) != std::string::npos);
        }
        CHECK(h.children(h.node(deepest)).empty());
        check_sound(h);
        CHECK(test::nodes_of(h) == before);
        CHECK(h.to_mesh().mesh.face_count() > before.size() / 2);
    }
}

TEST_CASE("[bad-input] schemes without hierarchy, meshes and choices that a scheme does not have are refused") {
    const ControlMesh quads = test::hierarchy_mesh("catmull-clark", 1);
    const auto code = [&](auto&& call) {
        try {
            call();
        } catch (const Error& e) {
            return e.code();
        }
        return ErrorCode::io;
    };
    CHECK(code([&] { make_hierarchy(quads, "catmull-klark"); }) == ErrorCode::invalid_input);
    CHECK(code([&] { make_hierarchy(quads, "loop"); }) == ErrorCode::invalid_input);
    CHECK(code([&] { make_hierarchy(quads, "honeycomb"); }) == ErrorCode::unsupported);
    HierarchyOptions options;
    options.rules.averaging_steps = 2;
    options.rules.averaging_boundary = AveragingBoundary::recede;
    const ControlMesh open = test::random_mesh(1, {.removed_faces = 2});
    CHECK(code([&] { make_hierarchy(open, "averaging", options); }) == ErrorCode::unsupported);
}

TEST_CASE("cancelled calls leave a sound hierarchy") {
    const ControlMesh mesh = test::hierarchy_mesh("catmull-clark", 1);
    Hierarchy h = make_hierarchy(mesh, "catmull-clark");
    RunContext context;
    int reports = 0;
    context.progress = [&](std::string_view, double fraction) {
        CHECK(fraction >= 0);
        CHECK(fraction <= 1);
        return ++reports < 3;
    };
    const auto all = each_leaf([](const LeafView&) { return true; });
    CHECK_THROWS_AS(h.refine_where(all, 10, context), Error);
    check_sound(h);
    CHECK(h.leaf_count() > 0);
    reports = 2;
    CHECK_THROWS_AS(h.to_mesh({.context = context}), Error);
}

TEST_SUITE_END();
