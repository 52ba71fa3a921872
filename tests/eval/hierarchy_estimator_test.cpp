#include "../kit/hierarchy_helpers.hpp"
#include "../kit/input_helpers.hpp"
#include "../kit/random_mesh.hpp"
#include "../kit/scheme_meshes.hpp"

#include "../../eval/distance/hausdorff.hpp"
#include "../../eval/estimate/hierarchy_estimator.hpp"
#include "../../eval/tessellate/tessellate.hpp"
#include "../../hier/base/error.hpp"
#include "../../hier/trees/vertex_forest.hpp"
#include "../../refine/points/vertex_links.hpp"
#include "../../refine/uniform/refine.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <limits>
#include <string_view>

using namespace tetrakis;
using test::triangles_of;

namespace {

/// One of each family at least, and all that are dual.
constexpr std::string_view k_estimated[] = {"catmull-clark", "kobbelt", "loop",      "butterfly",
                                            "sqrt3",         "midedge", "doo-sabin", "biquartic"};

bool is_steps(std::string_view scheme) { return scheme == "sqrt3"; }

/// Depths of the family's trees that halve a leaf's size, about.
int depths_a_level(std::string_view scheme) {
    if (is_steps(scheme)) return 4;  // two simple steps make thirds
    return find_scheme(scheme)->family == MeshFamily::triangles || scheme == "midedge" || scheme == "doo-sabin" ||
                   scheme == "biquartic"
               ? 1
               : 2;
}

/// Limit points of uniform refinement, far finer than what is compared with it.
TriangleMesh dense_surface(const ControlMesh& mesh, std::string_view scheme) {
    return triangles_of(refine(mesh, scheme, is_steps(scheme) ? 3 : 4, {.limit = true}));
}

double distance_to(const TriangleMesh& surface, const Hierarchy& h) {
    return compare(surface, triangles_of(h.to_mesh().mesh), {.samples = 20'000, .climbs = 8}).error.hausdorff;
}

/// Estimates triangles alone.
class TrianglesOnly final : public ErrorEstimator {
    using ErrorEstimator::estimate;
    void estimate(std::span<const CellTriangle>, std::span<double>) const override {}
};

}  // namespace

TEST_SUITE_BEGIN("eval");

TEST_CASE("[slow] hierarchies of every family are refined to a tolerance, tighter ones only adding leaves") {
    for (const std::string_view scheme : {"catmull-clark", "loop", "sqrt3", "midedge", "doo-sabin", "biquartic"})
        for (const bool closed : {true, false}) {
            CAPTURE(scheme);
            CAPTURE(closed);
            const ControlMesh mesh = test::mesh_for(scheme, closed ? test::k_closed : test::k_tube);
            const TriangleMesh surface = dense_surface(mesh, scheme);
            Hierarchy h = make_hierarchy(mesh, scheme);
            const int deep = 8 * depths_a_level(scheme);
            std::set<HierarchyNode> before = test::nodes_of(h);
            for (const double tolerance : {0.06, 0.02}) {
                CAPTURE(tolerance);
                const std::size_t created = h.refine_where(HierarchyEstimator(h, tolerance), tolerance, deep);
                CHECK(created > 0);
                test::check_sound(h);
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

TEST_CASE("depths, tolerances and estimators: limits are kept, bad values and other families' estimators refused") {
    for (const std::string_view scheme : std::initializer_list<std::string_view>{"sqrt3", "doo-sabin", "biquartic"}) {
        CAPTURE(scheme);
        const ControlMesh mesh = test::mesh_for(scheme, test::k_closed);
        Hierarchy h = make_hierarchy(mesh, scheme);
        const HierarchyEstimator estimator(h, 0.0);
        // Nothing is ever exact.
        h.refine_where(estimator, 0.0, 4);
        std::set<HierarchyNode> nodes = test::nodes_of(h);
        for (const HierarchyNode& node : nodes) CHECK(int{node.depth} <= 4);
        CHECK(std::any_of(nodes.begin(), nodes.end(), [](const HierarchyNode& node) { return node.depth == 4; }));
        const auto code_of = [](auto&& call) { return test::error_of(call).code(); };
        for (const double bad : {std::nan(""), -1.0, -std::numeric_limits<double>::infinity()}) {
            CHECK(code_of([&] { h.refine_where(estimator, bad, 3); }) == ErrorCode::invalid_input);
            CHECK(code_of([&] { h.coarsen_where(estimator, bad); }) == ErrorCode::invalid_input);
        }
        CHECK_THROWS_AS(h.refine_where(TrianglesOnly(), 0.1, 5), Error);
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
        test::check_sound(cancelled);
        CHECK(cancelled.leaf_count() > make_hierarchy(mesh, scheme).leaf_count());
        CHECK(cancelled.leaf_count() < h.leaf_count() + 1);
        context.progress = [](std::string_view, double) { return false; };
        CHECK(code_of([&] { cancelled.to_mesh({.context = context}); }) == ErrorCode::cancelled);
    }
}

TEST_CASE("a leaf that is asked for twice has its error twice") {
    const ControlMesh mesh = test::mesh_for("doo-sabin", test::k_closed);
    const Hierarchy h = make_hierarchy(mesh, "doo-sabin");
    const VertexForest forest(vertex_roots(mesh, *find_scheme("doo-sabin"), {}));
    const std::vector<LeafId> leaves{LeafId(0), LeafId(1), LeafId(0)};
    std::vector<double> errors(leaves.size());
    HierarchyEstimator(h, 0.0).estimate_vertices(forest, leaves, errors);
    CHECK(errors[0] > 0);
    CHECK(errors[0] == errors[2]);
}

TEST_CASE("coarsening by an estimator undoes what a tolerance does not need, and keeps what it does") {
    for (const std::string_view scheme : k_estimated) {
        CAPTURE(scheme);
        const ControlMesh mesh = test::mesh_for(scheme, test::k_tube);
        const TriangleMesh surface = dense_surface(mesh, scheme);
        const double tolerance = 0.05;
        Hierarchy h = make_hierarchy(mesh, scheme);
        h.refine_where(HierarchyEstimator(h, tolerance), tolerance, 8 * depths_a_level(scheme));
        const std::uint32_t needed = h.leaf_count();
        int deepest = 0;
        for (const HierarchyNode& node : test::nodes_of(h)) deepest = std::max<int>(deepest, node.depth);
        const int all = deepest + (depths_a_level(scheme) + 1) / 2;
        h.refine_where(test::everything(), all);
        const std::uint32_t many = h.leaf_count();
        REQUIRE(many > needed);
        CHECK(h.coarsen_where(HierarchyEstimator(h, tolerance), tolerance) > 0);
        test::check_sound(h);
        const double measured = distance_to(surface, h);
        CHECK(measured <= tolerance);
        CHECK(h.leaf_count() < needed + needed / 4);
    }
}

TEST_CASE("coarsening by an estimator leaves nothing over the tolerance beside what it merges, and settles") {
    for (const std::string_view scheme : k_estimated)
        for (const std::uint64_t seed : {3, 4}) {
            CAPTURE(scheme);
            CAPTURE(seed);
            const ControlMesh mesh = test::hierarchy_mesh(scheme, seed);
            const double tolerance = 0.01 * mesh.bounding_box().diagonal();
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
            test::check_sound(h);
        }
}

TEST_CASE("coarsening by an estimator does not refine what was over the tolerance before") {
    for (const std::string_view scheme : k_estimated) {
        CAPTURE(scheme);
        const ControlMesh mesh = test::mesh_for(scheme, test::k_tube);
        const double tolerance = 1e-3 * mesh.bounding_box().diagonal();
        Hierarchy h = make_hierarchy(mesh, scheme);
        for (int i = 0; i < 4 * depths_a_level(scheme); ++i) h.refine(h.leaves().front());
        const std::uint32_t before = h.leaf_count();
        h.coarsen_where(HierarchyEstimator(h, tolerance), tolerance);
        CHECK(h.leaf_count() <= before);
        test::check_sound(h);
    }
}

TEST_SUITE_END();
