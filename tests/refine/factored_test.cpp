#include "../kit/factored_helpers.hpp"
#include "../kit/surface_topology.hpp"

#include "../../hier/base/error.hpp"
#include "../../hier/base/parallel.hpp"
#include "../../refine/rules/rule_refinement.hpp"
#include "../../refine/uniform/refine.hpp"
#include "../../schemes/core/scheme_kind.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

using namespace tetrakis;
using test::build;
using test::disagreement;
using test::double_fan;
using test::factored;
using test::k_agreement;
using test::prism;
using test::random_surface;

namespace {

/// Steps of the scheme with its rules: of 4-8 on other faces than quads the first one is half of one.
double disagreement_with_rules(const ControlMesh& mesh, FactoredScheme scheme, int steps) {
    bool half_first = false;
    for (std::uint32_t f = 0; f < mesh.face_count(); ++f)
        half_first |= scheme == FactoredScheme::four_eight && mesh.face_size(FaceId(f)) != 4;
    const int half_steps = steps * FactoredMesh(mesh, scheme).half_steps_per_level();
    const PolygonMesh ours = factored(mesh, scheme, half_steps - (half_first ? 1 : 0)).active_mesh();
    const PolygonMesh rules = refine_by_rules(mesh, *find_scheme(name(scheme)), steps);
    CHECK(ours.face_count() == rules.face_count());
    return disagreement(ours.positions, rules.positions);
}

ControlMesh tagged(const ControlMesh& mesh, std::vector<ControlMeshData::EdgeTag> creases,
                   std::vector<ControlMeshData::VertexTag> corners) {
    ControlMeshData data = mesh.data();
    data.creases = std::move(creases);
    data.corners = std::move(corners);
    return ControlMesh::build(std::move(data));
}

struct Tagged {
    std::string what;
    ControlMesh mesh;
};

/// double_fan(n) with what can be tagged at its first vertex, of valence n, infinitely sharp and not. Its edges lead to
/// the vertices 2, 4, ...
std::vector<Tagged> tagged_fans(int n) {
    const ControlMesh mesh = double_fan(n);
    const auto edge = [&](int i, float sharpness) {
        return ControlMeshData::EdgeTag{0, static_cast<std::uint32_t>(2 + 2 * (i % n)), sharpness, 0};
    };
    const auto last = static_cast<std::uint32_t>(2 * n);  // the end of edge n - 1
    std::vector<Tagged> result;
    // A level takes 1 off a sharpness.
    for (const float s : {k_infinite_sharpness, 1.6f, 0.7f}) {
        const auto add = [&](const char* what, std::vector<ControlMeshData::EdgeTag> creases,
                             std::vector<ControlMeshData::VertexTag> corners) {
            result.push_back(
                {what + (" of sharpness " + std::to_string(s)), tagged(mesh, std::move(creases), std::move(corners))});
        };
        add("dart", {edge(1, s)}, {});
        add("crease", {edge(0, s), edge(n / 2, s)}, {});
        add("crease along two neighbours", {edge(0, s), edge(n - 1, s)}, {});
        add("meeting of three creases", {edge(0, s), edge(1, s), edge(n - 1, s)}, {});
        add("corner", {}, {{0, s, 0}});
        add("corner on a crease", {edge(0, s), edge(n / 2, s)}, {{0, s, 0}});
        add("corner at the end of an edge", {edge(n - 1, s)}, {{last, s, 0}});
    }
    result.push_back({"creases of two kinds", tagged(mesh, {edge(0, k_infinite_sharpness), edge(n / 2, 0.7f)}, {})});
    return result;
}

ControlMesh with_rule(const ControlMesh& mesh, BoundaryRule rule) {
    ControlMeshData data = mesh.data();
    data.boundary_rule = rule;
    return ControlMesh::build(std::move(data));
}

/// An open fan: a boundary vertex of n faces, quads or triangles; the rim is not symmetric.
ControlMesh open_fan(int n, bool quads) {
    std::vector<Vec3d> positions{{0.1, -0.2, 1.5}};
    std::vector<std::vector<std::uint32_t>> faces;
    const int step = quads ? 2 : 1, rim = step * n + 1;
    for (int i = 0; i < rim; ++i) positions.push_back(test::on_circle(i, rim + 3, 2, i % 2 == 0 ? 0.4 : -0.3));
    for (int i = 0; i < n; ++i) {
        const auto at = [&](int j) { return static_cast<std::uint32_t>(1 + step * i + j); };
        if (quads)
            faces.push_back({0, at(0), at(1), at(2)});
        else
            faces.push_back({0, at(0), at(1)});
    }
    return build(std::move(positions), faces);
}

/// An n-gon with quads at some of its edges; the others are the boundary.
ControlMesh open_cap(int n, int sides) {
    const ControlMesh whole = prism(n);
    std::vector<std::vector<std::uint32_t>> faces(1);
    for (int i = 0; i < n; ++i) {
        const auto a = static_cast<std::uint32_t>(2 * i), b = static_cast<std::uint32_t>(2 * ((i + 1) % n));
        faces[0].push_back(a + 1);
        if (i < sides) faces.push_back({a, b, b + 1, a + 1});
    }
    // Below the sides that are missing nothing is left of the prism's other end.
    std::vector<Vec3d> positions;
    std::vector<std::uint32_t> number(whole.vertex_count(), VertexId::none);
    for (auto& face : faces)
        for (std::uint32_t& v : face) {
            if (number[v] == VertexId::none) {
                number[v] = static_cast<std::uint32_t>(positions.size());
                positions.push_back(whole.position(VertexId(v)));
            }
            v = number[v];
        }
    return build(std::move(positions), faces);
}

/// Boundary vertices with n faces, and n-gons on the boundary, with and without corners of the boundary.
std::vector<Tagged> open_meshes(int n) {
    std::vector<Tagged> result;
    for (const BoundaryRule rule : {BoundaryRule::edge_only, BoundaryRule::edge_and_corner}) {
        const auto add = [&](const char* what, const ControlMesh& mesh) {
            const char* corners = rule == BoundaryRule::edge_only ? "" : ", sharp corners";
            result.push_back({std::string(what) + corners, with_rule(mesh, rule)});
        };
        add("fan of quads", open_fan(n, true));
        add("fan of triangles", open_fan(n, false));
        add("n-gon with a quad at each edge", open_cap(n, n));
        add("n-gon with half of its edges on the boundary", open_cap(n, n / 2));
        add("n-gon alone but for one quad", open_cap(n, 1));
    }
    // An inner crease that ends at the boundary vertex.
    const ControlMesh fan = open_fan(n, true);
    for (const float s : {k_infinite_sharpness, 0.7f})
        result.push_back(
            {"crease to the boundary", tagged(fan, {{0, static_cast<std::uint32_t>(1 + 2 * (n / 2)), s, 0}}, {})});
    result.push_back({"corner on the boundary", tagged(fan, {}, {{0, k_infinite_sharpness, 0}})});
    return result;
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
    for (const int n : {3, 4, 5, 6, 7, 12}) {
        std::vector<Tagged> all = tagged_fans(n);
        for (Tagged& open : open_meshes(n)) {
            CAPTURE(n);
            CAPTURE(open.what);
            // In the second step the boundary vertex of n faces has become an n-gon there.
            CHECK(disagreement_with_rules(open.mesh, FactoredScheme::doo_sabin, 2) < k_agreement);
            all.push_back(std::move(open));
        }
        for (const Tagged& of : all)
            for (const CreaseMethod method : {CreaseMethod::uniform, CreaseMethod::chaikin}) {
                CAPTURE(n);
                CAPTURE(of.what);
                ControlMeshData data = of.mesh.data();
                data.crease_method = method;
                const ControlMesh mesh = ControlMesh::build(std::move(data));
                const PolygonMesh ours = factored(mesh, FactoredScheme::catmull_clark, 4).active_mesh();
                CHECK(disagreement(ours.positions, refine(mesh, name(SchemeKind::catmull_clark), 2).positions) <
                      k_agreement);
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
            RunContext context;
            context.threads = threads;
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
