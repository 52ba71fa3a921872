#include "../kit/dual_mesh.hpp"
#include "../kit/hierarchy_helpers.hpp"
#include "../kit/scheme_meshes.hpp"

#include "../../eval/distance/hausdorff.hpp"
#include "../../eval/tessellate/hierarchy_estimator.hpp"
#include "../../eval/tessellate/tessellate.hpp"
#include "../../hier/base/error.hpp"
#include "../../hier/mesh/obj_reader.hpp"
#include "../../hier/mesh/triangulate.hpp"
#include "../../refine/uniform/refine.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

using namespace tetrakis;
using test::Random;
using test::triangles_of;

namespace {

/// One of each family at least, and all that are dual.
constexpr std::string_view k_estimated[] = {"catmull-clark", "kobbelt", "loop",      "butterfly",
                                            "sqrt3",         "midedge", "doo-sabin", "biquartic"};

/// Those whose mesh tessellate() does not start from fans.
constexpr std::string_view k_structured[] = {"sqrt3", "doo-sabin", "midedge", "biquartic"};

bool is_steps(std::string_view scheme) { return scheme == "sqrt3"; }

/// Depths of the family's trees that halve a leaf's size, about.
int depths_a_level(std::string_view scheme) {
    if (is_steps(scheme)) return 4;  // two simple steps make thirds
    return find_scheme(scheme)->family == MeshFamily::triangles || scheme == "midedge" || scheme == "doo-sabin" ||
                   scheme == "biquartic"
               ? 1
               : 2;
}

ControlMesh estimated_mesh(std::string_view scheme, const std::string& text) {
    const bool triangles = find_scheme(scheme)->family == MeshFamily::triangles || is_steps(scheme);
    ControlMesh mesh = ControlMesh::build(parse_obj(text, "test.obj"));
    return triangles && !mesh.all_triangles() ? triangulate(mesh) : ControlMesh::build(mesh.data());
}

constexpr int k_side = 12;  ///< quads a side of hill()

/// A flat sheet of quads with a hill in the middle.
ControlMesh hill(std::string_view scheme) {
    std::string text;
    for (int y = 0; y <= k_side; ++y)
        for (int x = 0; x <= k_side; ++x)
            text += "v " + std::to_string(x) + ' ' + std::to_string(y) +
                    (x == k_side / 2 && y == k_side / 2 ? " 1.5\n" : " 0\n");
    for (int y = 0; y < k_side; ++y)
        for (int x = 0; x < k_side; ++x) {
            const int v = y * (k_side + 1) + x + 1;
            text += "f " + std::to_string(v) + ' ' + std::to_string(v + 1) + ' ' + std::to_string(v + k_side + 2) +
                    ' ' + std::to_string(v + k_side + 1) + '\n';
        }
    return estimated_mesh(scheme, text);
}

/// Limit points of uniform refinement, far finer than what is compared with it.
TriangleMesh dense_surface(const ControlMesh& mesh, std::string_view scheme) {
    return triangles_of(refine(mesh, scheme, is_steps(scheme) ? 3 : 4, {.limit = true}));
}

double distance_to(const TriangleMesh& surface, const Hierarchy& h) {
    return compare_meshes(surface, triangles_of(h.to_mesh().mesh), {.samples = 20'000, .climbs = 8}).hausdorff;
}

void check_whole(const Hierarchy& h) {
    const auto fault = h.check();
    CHECK_MESSAGE(!fault, fault.value_or(""));
}

void check_settles(std::string_view scheme) {
    for (const std::uint64_t seed : {3, 4}) {
        CAPTURE(scheme);
        CAPTURE(seed);
        const ControlMesh mesh = test::hierarchy_mesh(scheme, seed);
        const double tolerance = 0.01 * glm::length(mesh.bounding_box().upper - mesh.bounding_box().lower);
        const int most = 4 * depths_a_level(scheme);
        Hierarchy h = make_hierarchy(mesh, scheme);
        const HierarchyEstimator estimator(h, tolerance);
        h.refine_where(estimator, tolerance, most);
        // As far as the depth allows.
        Hierarchy whole = make_hierarchy(mesh, scheme);
        whole.load(h.saved());
        const bool within = whole.refine_where(estimator, tolerance, most + 2) == 0;
        h.coarsen_where(estimator, tolerance);
        if (within) CHECK(h.refine_where(estimator, tolerance, most) == 0);
        const auto once = h.saved();
        h.coarsen_where(estimator, tolerance);
        CHECK(h.saved() == once);
        check_whole(h);
    }
}

}  // namespace

TEST_SUITE_BEGIN("eval");

TEST_CASE("[slow] hierarchies of every family are refined to a tolerance, tighter ones only adding leaves") {
    for (const std::string_view scheme : {"catmull-clark", "loop", "sqrt3", "midedge", "doo-sabin", "biquartic"})
        for (const bool closed : {true, false}) {
            CAPTURE(scheme);
            CAPTURE(closed);
            const ControlMesh mesh = estimated_mesh(scheme, closed ? test::k_closed : test::k_tube);
            const TriangleMesh surface = dense_surface(mesh, scheme);
            Hierarchy h = make_hierarchy(mesh, scheme);
            const int deep = 8 * depths_a_level(scheme);
            std::set<HierarchyNode> before = test::nodes_of(h);
            for (const double tolerance : {0.06, 0.02}) {
                CAPTURE(tolerance);
                const std::size_t created = h.refine_where(HierarchyEstimator(h, tolerance), tolerance, deep);
                CHECK(created > 0);
                check_whole(h);
                const double measured = distance_to(surface, h);
                CHECK(measured <= tolerance);
                // Not far finer than needed, either.
                CHECK(measured > tolerance / 8);
                const std::set<HierarchyNode> after = test::nodes_of(h);
                CHECK(after.size() > before.size());
                for (const HierarchyNode& node : before) {
                    const auto below = after.lower_bound(node);
                    REQUIRE(below != after.end());
                    CHECK((*below == node || h.tree().is_ancestor(node, *below)));
                }
                before = after;
                CHECK(h.refine_where(HierarchyEstimator(h, tolerance), tolerance, deep) == 0);
                // Errors that are not cut short lead to the same.
                CHECK(h.refine_where(HierarchyEstimator(h, 0), tolerance, deep) == 0);
            }
        }
}

TEST_CASE(
    "[slow] [peer] refining a hierarchy by an estimator finds the mesh that tessellate() makes of the same errors") {
    // One that ends inside, and two that cross.
    const std::string creased = std::string(test::k_closed) +
                                "t crease 2/1/0 0 1 10\nt crease 2/1/0 4 8 10\nt crease 2/1/0 8 7 10\n"
                                "t crease 2/1/0 5 8 10\nt crease 2/1/0 8 6 10\n";
    for (const std::string_view scheme : k_structured)
        for (const std::string& text : {std::string(test::k_closed), std::string(test::k_tube), creased}) {
            if (text == creased && scheme != "doo-sabin" && scheme != "midedge") continue;
            CAPTURE(scheme);
            CAPTURE(text);
            const ControlMesh mesh = estimated_mesh(scheme, text);
            TessellateOptions options;
            options.scheme = scheme;
            // tessellate() measures, so it can do with a smaller margin for what lies between the points looked at.
            options.tolerance = 0.01 * 0.94 / 0.98;
            options.tolerance_is_absolute = true;
            options.measure = false;
            const Tessellation expected = tessellate(mesh, options);
            Hierarchy h = make_hierarchy(mesh, scheme);
            h.refine_where(HierarchyEstimator(h, 0.01), 0.01, 10 * depths_a_level(scheme));
            const HierarchyMesh mine = h.to_mesh();
            CHECK(triangles_of(mine.mesh).triangles.size() == expected.mesh.triangles.size());
            REQUIRE(mine.mesh.positions.size() == expected.mesh.positions.size());
            for (std::size_t v = 0; v < mine.mesh.positions.size(); ++v)
                CHECK(glm::length(mine.mesh.positions[v] - expected.mesh.positions[v]) < 1e-12);
        }
}

TEST_CASE("what an estimator finds flat stays as coarse as it was") {
    for (const std::string_view scheme : {"catmull-clark", "loop", "sqrt3", "doo-sabin", "midedge", "biquartic"}) {
        CAPTURE(scheme);
        const ControlMesh mesh = hill(scheme);
        Hierarchy h = make_hierarchy(mesh, scheme);
        const auto at_root = [&](const HierarchyNode& node) { return node.depth == 0; };
        h.refine_where(HierarchyEstimator(h, 0.005), 0.005, 8 * depths_a_level(scheme));
        check_whole(h);
        int deepest = 0;
        std::size_t far = 0, coarse = 0;
        for (const LeafHandle leaf : h.leaves()) {
            const LeafView view = h.view(leaf);
            deepest = std::max<int>(deepest, view.node.depth);
            // Farther from the hill than any mask reaches.
            const Vec3d p = h.limit(view.corner[0]).position;
            if (std::max(std::abs(p.x - k_side / 2), std::abs(p.y - k_side / 2)) < 4.5) continue;
            ++far;
            coarse += at_root(view.node) ? 1 : 0;
        }
        CHECK(deepest >= 2 * depths_a_level(scheme));
        CHECK(far > 50);
        CHECK(coarse == far);
    }
}

TEST_CASE("[inv10] refining by an estimator: the same bytes for any number of threads, also after changes by hand") {
    for (const std::string_view scheme : std::initializer_list<std::string_view>{"sqrt3", "doo-sabin", "midedge"})
        for (const std::uint64_t seed : test::seeds(2)) {
            CAPTURE(scheme);
            CAPTURE(seed);
            const ControlMesh mesh = is_steps(scheme) ? test::random_sqrt3_mesh(seed) : test::random_dual_mesh(seed);
            const int deep = 4 * depths_a_level(scheme);
            std::vector<std::byte> expected;
            std::size_t created = 0;
            for (const int threads : {1, 2, 4}) {
                Hierarchy h = make_hierarchy(mesh, scheme);
                Random random(seed);
                test::random_changes(h, 5, deep / 2, random, [] {});
                const std::set<HierarchyNode> before = test::nodes_of(h);
                RunContext context;
                context.threads = threads;
                const std::size_t n = h.refine_where(HierarchyEstimator(h, 0.02), 0.02, deep, context);
                check_whole(h);
                for (const HierarchyNode& node : test::nodes_of(h)) CHECK(int{node.depth} <= deep);
                if (threads == 1) {
                    expected = h.saved();
                    created = n;
                    CHECK(created > 0);
                }
                CHECK(n == created);
                CHECK(h.saved() == expected);
            }
        }
}

TEST_CASE("depths, tolerances and estimators: limits are kept, bad values and other families' estimators refused") {
    for (const std::string_view scheme : std::initializer_list<std::string_view>{"sqrt3", "doo-sabin", "biquartic"}) {
        CAPTURE(scheme);
        const ControlMesh mesh = estimated_mesh(scheme, test::k_closed);
        Hierarchy h = make_hierarchy(mesh, scheme);
        const HierarchyEstimator estimator(h, 0.0);
        // Nothing is ever exact.
        h.refine_where(estimator, 0.0, 4);
        std::set<HierarchyNode> nodes = test::nodes_of(h);
        for (const HierarchyNode& node : nodes) CHECK(int{node.depth} <= 4);
        CHECK(std::any_of(nodes.begin(), nodes.end(), [](const HierarchyNode& node) { return node.depth == 4; }));
        const auto code_of = [&](auto&& call) {
            try {
                call();
            } catch (const Error& e) {
                return e.code();
            }
            FAIL("no error");
            return ErrorCode::io;
        };
        for (const double bad : {std::nan(""), -1.0, -std::numeric_limits<double>::infinity()}) {
            CHECK(code_of([&] { h.refine_where(estimator, bad, 3); }) == ErrorCode::invalid_input);
            CHECK(code_of([&] { h.coarsen_where(estimator, bad); }) == ErrorCode::invalid_input);
        }
        CHECK(code_of([&] { h.refine_where(estimator, 0.1, -1); }) == ErrorCode::invalid_input);
        CHECK(code_of([&] { h.refine_where(estimator, 0.1, h.tree().max_depth + 1); }) == ErrorCode::invalid_input);
        CHECK(test::nodes_of(h) == nodes);

        // Cancelled at the third report: what was refined until then stays.
        Hierarchy cancelled = make_hierarchy(mesh, scheme);
        int reports = 0;
        double last = 0;
        RunContext context;
        context.progress = [&](std::string_view, double done) {
            CHECK(done >= last);
            last = done;
            return ++reports < 3;
        };
        CHECK(code_of([&] { cancelled.refine_where(estimator, 0.0, 8, context); }) == ErrorCode::cancelled);
        check_whole(cancelled);
        CHECK(cancelled.leaf_count() > make_hierarchy(mesh, scheme).leaf_count());
        CHECK(cancelled.leaf_count() < h.leaf_count() + 1);
    }
}

TEST_CASE("[slow] where the lattice ends before a leaf's points, nothing is refined for them") {
    for (const std::string_view scheme : {"catmull-clark", "loop", "sqrt3", "doo-sabin"}) {
        CAPTURE(scheme);
        const ControlMesh mesh = estimated_mesh(scheme, test::k_closed);
        Hierarchy h = make_hierarchy(mesh, scheme);
        const int most = h.tree().max_depth;
        HierarchyNode deepest{h.node(h.leaves()[0]).root, 0, 0};
        for (int d = 0; d < most; ++d) deepest = h.tree().child(deepest, 0);
        h.refine_where(each_leaf([&](const LeafView& leaf) { return h.tree().is_ancestor(leaf.node, deepest); }), most);
        REQUIRE(h.find(deepest).has_value());
        const double tolerance = 10;  // more than the box is wide
        CHECK(h.refine_where(HierarchyEstimator(h, tolerance), tolerance, most) == 0);
        CHECK(h.coarsen_where(HierarchyEstimator(h, tolerance), tolerance) > 0);
        CHECK(h.leaf_count() == make_hierarchy(mesh, scheme).leaf_count());
        check_whole(h);
    }
}

TEST_CASE("coarsening by an estimator undoes what a tolerance does not need, and keeps what it does") {
    for (const std::string_view scheme : k_estimated) {
        CAPTURE(scheme);
        const ControlMesh mesh = estimated_mesh(scheme, test::k_tube);
        const TriangleMesh surface = dense_surface(mesh, scheme);
        const double tolerance = 0.05;
        Hierarchy h = make_hierarchy(mesh, scheme);
        h.refine_where(HierarchyEstimator(h, tolerance), tolerance, 8 * depths_a_level(scheme));
        const std::uint32_t needed = h.leaf_count();
        int deepest = 0;
        for (const HierarchyNode& node : test::nodes_of(h)) deepest = std::max<int>(deepest, node.depth);
        const int all = deepest + (depths_a_level(scheme) + 1) / 2;
        h.refine_where(each_leaf([](const LeafView&) { return true; }), all);
        const std::uint32_t many = h.leaf_count();
        REQUIRE(many > needed);
        CHECK(h.coarsen_where(HierarchyEstimator(h, tolerance), tolerance) > 0);
        check_whole(h);
        const double measured = distance_to(surface, h);
        CHECK(measured <= tolerance);
        CHECK(h.leaf_count() < needed + needed / 4);
    }
}

TEST_CASE("coarsening by an estimator leaves nothing over the tolerance beside what it merges, and settles") {
    for (const std::string_view scheme : {"catmull-clark", "loop", "sqrt3", "doo-sabin"}) check_settles(scheme);
}

TEST_CASE("[slow] coarsening by an estimator leaves nothing over the tolerance and settles: further schemes") {
    for (const std::string_view scheme : {"kobbelt", "butterfly", "midedge", "biquartic"}) check_settles(scheme);
}

TEST_SUITE_END();
