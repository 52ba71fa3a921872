#include "../kit/factored_helpers.hpp"
#include "../kit/input_helpers.hpp"
#include "../kit/surface_topology.hpp"

#include "../../hier/base/error.hpp"
#include "../../hier/base/parallel.hpp"
#include "../../refine/uniform/refine.hpp"
#include "../../schemes/core/scheme_table.hpp"

#include <doctest/doctest.h>

#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

using namespace tetrakis;
using test::disagreement;
using test::disagreement_with_rules;
using test::double_fan;
using test::factored;
using test::k_agreement;
using test::prism;
using test::random_surface;

namespace {

/// Creases, darts and corners at random, infinitely sharp or not, with both boundary rules, and in every other mesh
/// without its last face.
ControlMesh with_tags(const ControlMesh& mesh, std::uint64_t seed) {
    ControlMeshData data = mesh.data();
    test::Random random(seed);
    const float sharpness[] = {k_infinite_sharpness, 1.6f, 0.7f};  // a level takes 1 off
    if (seed % 2 == 1) {
        data.face_offsets.pop_back();
        data.face_vertices.resize(data.face_offsets.back());
        data.boundary_rule = seed % 4 == 1 ? BoundaryRule::edge_only : BoundaryRule::edge_and_corner;
    }
    const ControlMesh left = ControlMesh::build(data);
    for (std::uint32_t e = 0; e < left.edge_count(); ++e) {
        const HalfedgeId h = left.edge_halfedge(EdgeId(e));
        if (random.chance(0.2))
            data.creases.push_back({left.origin(h).value, left.target(h).value, sharpness[random.below(3)]});
    }
    for (std::uint32_t v = 0; v < left.vertex_count(); ++v)
        if (random.chance(0.1)) data.corners.push_back({v, sharpness[random.below(3)], 0});
    return ControlMesh::build(std::move(data));
}

}  // namespace

TEST_SUITE_BEGIN("refine");

TEST_CASE("[inv6] factored Catmull-Clark is uniform refinement: boundaries, creases, corners, semi-sharp tags, holes") {
    for (const std::uint64_t seed : test::seeds(12))
        for (const CreaseMethod method : {CreaseMethod::uniform, CreaseMethod::chaikin}) {
            CAPTURE(seed);
            ControlMeshData data = test::random_mesh_data(seed, test::random_options(seed));
            data.crease_method = method;
            const ControlMesh mesh = ControlMesh::build(std::move(data));
            const FactoredMesh ours = factored(mesh, FactoredScheme::catmull_clark, 6);
            const PolygonMesh uniform = refine(mesh, name(SchemeKind::catmull_clark), 3);
            CHECK(disagreement(ours.active_mesh().positions, uniform.positions) < k_agreement);
            CHECK(ours.mesh().face_count() == 2 * uniform.face_count());
        }
}

TEST_CASE("[inv6] factored schemes are the classical ones: valences and n-gons 3 to 12, and 64") {
    for (const FactoredScheme scheme : factored_schemes())
        for (const int n : {3, 4, 5, 6, 7, 8, 12, 64})
            for (const ControlMesh& mesh : {prism(n), double_fan(n)}) {
                CAPTURE(name(scheme));
                CAPTURE(n);
                CHECK(disagreement_with_rules(mesh, scheme, n <= 6 ? 3 : 2) < k_agreement);
            }
}

TEST_CASE("[inv6] factored schemes are the classical ones: creases, darts, corners, boundaries at valences 3 to 12") {
    for (const int n : {3, 4, 5, 6, 7, 12})
        for (const ControlMesh& mesh : {prism(n), double_fan(n)})
            for (const std::uint64_t seed : test::seeds(16)) {
                CAPTURE(n);
                CAPTURE(seed);
                ControlMeshData data = with_tags(mesh, seed).data();
                CHECK(disagreement_with_rules(ControlMesh::build(data), FactoredScheme::doo_sabin, 2) < k_agreement);
                for (const CreaseMethod method : {CreaseMethod::uniform, CreaseMethod::chaikin}) {
                    data.crease_method = method;
                    const ControlMesh tagged = ControlMesh::build(data);
                    const PolygonMesh ours = factored(tagged, FactoredScheme::catmull_clark, 4).active_mesh();
                    CHECK(disagreement(ours.positions, refine(tagged, "catmull-clark", 2).positions) < k_agreement);
                }
            }
}

TEST_CASE("[inv6] factored schemes are the classical ones: random meshes with boundaries and tags") {
    for (const FactoredScheme scheme : factored_schemes())
        for (const std::uint64_t seed : test::seeds(10)) {
            CAPTURE(name(scheme));
            CAPTURE(seed);
            CHECK(disagreement_with_rules(random_surface(seed, 1), scheme, 2) < k_agreement);
        }
}

TEST_CASE("[inv3] every half-step is a conforming triangle mesh of the control mesh's topology") {
    for (const FactoredScheme scheme : factored_schemes())
        for (const std::uint64_t seed : test::seeds(10))
            // Dual schemes open a crease for its points alone; the surface stays one.
            for (const double tags : {0.0, 1.0}) {
                CAPTURE(name(scheme));
                CAPTURE(seed);
                const ControlMesh mesh = random_surface(seed, tags);
                const test::SurfaceTopology expected = test::surface_topology(mesh);
                FactoredMesh ours(mesh, scheme);
                for (int i = 0; i < 5; ++i) {
                    CAPTURE(i);
                    if (!ours.triangles().empty()) {
                        const test::SurfaceTopology topology = test::topology(ours.triangles());
                        CHECK(topology.fault == "");
                        CHECK(topology.euler == expected.euler);
                        CHECK(topology.boundary_loops == expected.boundary_loops);
                    } else {
                        CHECK(i == 0);
                    }
                    ours.half_step();
                }
            }
}

TEST_CASE("dual schemes: active and inactive vertices after each half-step") {
    const ControlMesh mesh = prism(5);
    FactoredMesh ours(mesh, FactoredScheme::doo_sabin);
    const auto count = [&](FactoredVertex state) {
        std::uint32_t n = 0;
        for (std::uint32_t v = 0; v < ours.positions().size(); ++v) n += ours.state(v) == state;
        return n;
    };
    CHECK(count(FactoredVertex::active) == 10);
    CHECK(count(FactoredVertex::inactive) == 7);
    ours.half_step();
    CHECK(count(FactoredVertex::active) == 10 + 15);
    CHECK(count(FactoredVertex::inactive) == 7);
    ours.half_step();
    CHECK(count(FactoredVertex::active) == 30);             // one per half-edge
    CHECK(count(FactoredVertex::inactive) == 10 + 15 + 7);  // all the old ones, one per new face
    CHECK(count(FactoredVertex::unused) == 0);
}

TEST_CASE("factored schemes: half-steps without room are refused before any is made") {
    const auto code = [](auto&& call) -> std::optional<ErrorCode> {
        try {
            call();
        } catch (const Error& e) {
            return e.code();
        }
        return std::nullopt;
    };
    std::vector<ControlMesh> meshes{test::prism(5)};
    for (const std::uint64_t seed : test::seeds(2)) meshes.push_back(random_surface(seed, 1.0));
    for (std::size_t m = 0; m < meshes.size(); ++m)
        for (const FactoredScheme scheme : factored_schemes()) {
            CAPTURE(m);
            CAPTURE(name(scheme));
            CHECK(code([&] { FactoredMesh(meshes[m], scheme).check_half_steps(300); }) == ErrorCode::unsupported);
            constexpr std::uint64_t k_limit = 8 << 20;
            CHECK_THROWS_WITH_AS(FactoredMesh(meshes[m], scheme, k_limit).check_half_steps(62),
                                 doctest::Contains("of 62 needs about"), Error);
            // As many as there is room for are not refused; of a closed mesh without creases no more than these.
            FactoredMesh mesh(meshes[m], scheme, k_limit);
            while (!code([&] { mesh.half_step(); })) {
            }
            const FactoredMesh start(meshes[m], scheme, k_limit);
            CHECK_FALSE(code([&] { start.check_half_steps(mesh.half_steps()); }));
            if (m == 0) CHECK(code([&] { start.check_half_steps(mesh.half_steps() + 1); }) == ErrorCode::memory_limit);
            CHECK(code([&] { mesh.check_half_steps(1); }) == ErrorCode::memory_limit);
        }
}

TEST_CASE("[inv10] factored schemes: the same bytes for any number of threads") {
    test::RandomMeshOptions options;
    options.topology = test::Topology::torus;
    options.columns = options.rows = 12;
    const ControlMesh mesh = test::random_mesh(3, options);
    for (const FactoredScheme scheme : factored_schemes()) {
        CAPTURE(name(scheme));
        const auto run = [&](int threads) {
            const RunContext context = test::with_thread_count(threads);
            return with_threads(context, [&] {
                const FactoredMesh result = factored(mesh, scheme, 7);
                return std::vector<Vec3d>(result.positions().begin(), result.positions().end());
            });
        };
        const std::vector<Vec3d> one = run(1);
        CHECK(one.size() > (scheme == FactoredScheme::catmull_clark ? 10000 : 1000));
        CHECK(one == run(2));
        CHECK(one == run(4));
    }
}

TEST_SUITE_END();
