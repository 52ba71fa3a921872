#include "../kit/factored_helpers.hpp"
#include "../kit/input_helpers.hpp"
#include "../kit/surface_topology.hpp"

#include "../../hier/base/error.hpp"
#include "../../hier/base/parallel.hpp"
#include "../../refine/factored/adaptive_factored_mesh.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <random>
#include <set>
#include <utility>
#include <vector>

using namespace tetrakis;
using test::factored;
using test::k_agreement;

namespace {

using Output = AdaptiveFactoredMesh::Output;
using Triangle = std::array<std::uint32_t, 3>;

/// The triangle's cycle that starts at its lowest vertex.
Triangle turned(Triangle t) {
    while (t[0] > t[1] || t[0] > t[2]) t = {t[1], t[2], t[0]};
    return t;
}
std::vector<Triangle> triangles(const PolygonMesh& mesh) {
    std::vector<Triangle> result;
    for (std::uint32_t f = 0; f < mesh.face_count(); ++f) {
        REQUIRE(mesh.face_offsets[f + 1] == 3 * (f + 1));
        result.push_back({mesh.face_vertices[3 * f], mesh.face_vertices[3 * f + 1], mesh.face_vertices[3 * f + 2]});
    }
    return result;
}

/// The mesh of FactoredMesh after so many half-steps, to look for vertices of an adaptive one in.
struct Uniform {
    Uniform(const ControlMesh& control, FactoredScheme scheme, int half_steps)
        : mesh(factored(control, scheme, half_steps)), whole(mesh.mesh(&numbers)), match(whole.positions) {
        for (const Triangle& t : triangles(whole)) faces.insert(turned(t));
    }
    FactoredMesh mesh;
    std::vector<std::uint32_t> numbers;
    PolygonMesh whole;
    PointMatch match;
    std::set<Triangle> faces;
};

/// Every vertex is that of the uniform mesh, every triangle whose vertices are all as fine as itself is one of it, and
/// neighbours differ by one half-step at most.
void check(const ControlMesh& control, FactoredScheme scheme, const Output& out) {
    const double size = control.bounding_box().diagonal();
    std::map<int, Uniform> uniform;
    const auto at = [&](int s) -> const Uniform& {
        auto found = uniform.find(s);
        if (found == uniform.end()) found = uniform.emplace(s, Uniform(control, scheme, s)).first;
        return found->second;
    };
    std::vector<std::uint32_t> same(out.mesh.positions.size());
    double worst = 0;
    std::size_t other_states = 0;
    for (std::uint32_t v = 0; v < same.size(); ++v) {
        const Uniform& u = at(out.half_steps[v]);
        same[v] = u.match.nearest(out.mesh.positions[v]);
        worst = std::max(worst, glm::length(out.mesh.positions[v] - u.whole.positions[same[v]]) / size);
        other_states += u.mesh.state(u.numbers[same[v]]) != out.states[v];
    }
    CHECK(worst < k_agreement);
    CHECK(other_states == 0);

    const std::vector<Triangle> faces = triangles(out.mesh);
    REQUIRE(out.leaves.size() == faces.size());
    std::vector<int> finest(same.size(), 0);
    std::map<std::pair<std::uint32_t, std::uint32_t>, int> side;
    std::size_t strange = 0, found = 0, steep = 0;
    for (std::size_t t = 0; t < faces.size(); ++t) {
        const int s = out.leaves[t].half_steps;
        bool whole = true;
        for (std::size_t k = 0; k < 3; ++k) {
            const std::uint32_t v = faces[t][k];
            finest[v] = std::max(finest[v], s);
            whole &= out.half_steps[v] == s;
            side[{v, faces[t][(k + 1) % 3]}] = s;
        }
        if (!whole) continue;
        ++found;
        strange += at(s).faces.count(turned({same[faces[t][0]], same[faces[t][1]], same[faces[t][2]]})) == 0;
    }
    for (const auto& [edge, s] : side)
        if (const auto other = side.find({edge.second, edge.first}); other != side.end())
            steep += std::abs(other->second - s) > 1;
    CHECK(found > 0);
    CHECK(strange == 0);
    CHECK(steep == 0);
    for (std::size_t v = 0; v < finest.size(); ++v) CHECK(finest[v] == out.half_steps[v]);

    // No T-junction: no edge has more than two triangles, and there are no other holes than in the uniform mesh.
    const test::SurfaceTopology ours = test::topology(faces), uniforms = test::topology(triangles(at(4).whole));
    CHECK(ours.fault == "");
    CHECK(ours.euler == uniforms.euler);
    CHECK(ours.boundary_loops == uniforms.boundary_loops);
}

void refine_at_random(AdaptiveFactoredMesh& mesh, std::uint64_t seed, int rounds, int most) {
    std::mt19937_64 random(seed);
    for (int round = 0; round < rounds; ++round) {
        const std::vector<AdaptiveFactoredMesh::Leaf> leaves = mesh.mesh().leaves;
        std::vector<AdaptiveFactoredMesh::Leaf> marked;
        for (const auto& leaf : leaves)
            if (leaf.half_steps < most && random() % 4 == 0) marked.push_back(leaf);
        mesh.refine(marked);
    }
}

/// Random leaves on top of a random mesh.
void check_random(const ControlMesh& control, FactoredScheme scheme, std::uint64_t seed) {
    AdaptiveFactoredMesh mesh(control, scheme);
    const Output coarsest = mesh.mesh();
    check(control, scheme, coarsest);
    CHECK(coarsest.mesh.face_count() == factored(control, scheme, mesh.first_half_step()).mesh().face_count());
    refine_at_random(mesh, seed, 5, 7);
    check(control, scheme, mesh.mesh());
}

bool has_valence_two(const ControlMesh& mesh) {
    for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v)
        if (mesh.face_valence(VertexId(v)) == 2 && !mesh.is_boundary(VertexId(v))) return true;
    return false;
}

constexpr FactoredScheme k_dual[] = {FactoredScheme::doo_sabin, FactoredScheme::doo_sabin_catmull_clark,
                                     FactoredScheme::midedge, FactoredScheme::midedge_simplest};

}  // namespace

TEST_SUITE_BEGIN("refine");

TEST_CASE("[inv6] Catmull-Clark's half-steps adapt: each vertex has the point of its finest half-step") {
    check_random(test::prism(5), FactoredScheme::catmull_clark, 1);
    for (std::uint64_t seed = 1; seed <= 12; ++seed) {
        CAPTURE(seed);
        check_random(test::random_surface(seed, 1), FactoredScheme::catmull_clark, seed);
    }
}

TEST_CASE("[inv6] half-steps adapt with semi-sharp creases by Chaikin's method, too") {
    for (const std::uint64_t seed : test::seeds(8)) {
        CAPTURE(seed);
        ControlMeshData data = test::random_mesh_data(seed, test::random_options(seed));
        data.crease_method = CreaseMethod::chaikin;
        check_random(ControlMesh::build(std::move(data)), FactoredScheme::catmull_clark, seed);
    }
}

TEST_CASE("[inv6] dual half-steps adapt: each vertex has the point of its finest half-step") {
    check_random(test::prism(5), FactoredScheme::doo_sabin, 1);
    check_random(test::double_fan(3), FactoredScheme::doo_sabin, 1);
    int done = 0, open = 0;
    for (std::uint64_t seed = 1; seed <= 24; ++seed) {
        CAPTURE(seed);
        const ControlMesh mesh = test::random_surface(seed, 0);
        if (has_valence_two(mesh)) {
            CHECK_THROWS_AS(AdaptiveFactoredMesh(mesh, FactoredScheme::doo_sabin), Error);
            continue;
        }
        check_random(mesh, k_dual[done % 4], seed);
        ++done;
        open += mesh.has_boundary();
    }
    CHECK(done >= 8);
    CHECK(open >= 4);
}

TEST_CASE("refine_near: as many half-steps as asked for inside of the sphere, however many, and fewer outside") {
    for (const FactoredScheme scheme : {FactoredScheme::catmull_clark, FactoredScheme::doo_sabin}) {
        CAPTURE(name(scheme));
        const ControlMesh control = test::model("cube");
        // The corner's point on the limit surface.
        const Vec3d centre = factored(control, scheme, 12).positions()[0];
        for (const int half_steps : {3, 8, 16}) {
            CAPTURE(half_steps);
            AdaptiveFactoredMesh mesh(control, scheme);
            const double radius = 1.5 * std::pow(0.5, half_steps / 2.0);
            mesh.refine_near(centre, radius, half_steps);
            const Output out = mesh.mesh();
            CHECK(out.leaves.size() < 4000);
            std::size_t fine = 0, coarse = 0, inside = 0;
            for (std::size_t v = 0; v < out.half_steps.size(); ++v) {
                if (glm::length(out.mesh.positions[v] - centre) > radius) continue;
                ++inside;
                CHECK(out.half_steps[v] == half_steps);
            }
            for (const auto& leaf : out.leaves) {
                fine += leaf.half_steps == half_steps;
                coarse += leaf.half_steps <= mesh.first_half_step() + 1;
            }
            CHECK(inside > 3);
            CHECK(fine > 0);
            CHECK(coarse > 0);
            if (half_steps <= 8) check(control, scheme, out);
        }
    }
}

TEST_CASE("adaptive half-steps: the same bytes for any number of threads and any order of the calls") {
    for (const FactoredScheme scheme : {FactoredScheme::catmull_clark, FactoredScheme::doo_sabin}) {
        const auto run = [&](int threads, bool turned) {
            const RunContext context = test::with_thread_count(threads);
            return with_threads(context, [&] {
                AdaptiveFactoredMesh mesh(test::model("cube"), scheme);
                std::vector<AdaptiveFactoredMesh::Leaf> some;
                for (const auto& leaf : mesh.mesh().leaves)
                    if (leaf.id.value % 3 == 0) some.push_back(leaf);
                if (turned) std::reverse(some.begin(), some.end());
                mesh.refine(some);
                mesh.refine_near({0.6, 0.6, 0.6}, 0.3, 9);
                return mesh.mesh();
            });
        };
        const Output one = run(1, false);
        for (const Output& other : {run(2, false), run(7, true)}) {
            CHECK(one.mesh.positions == other.mesh.positions);
            CHECK(one.mesh.face_vertices == other.mesh.face_vertices);
            CHECK(one.half_steps == other.half_steps);
        }
    }
}

TEST_CASE("[bad-input] adaptive half-steps say what they cannot do") {
    const ControlMesh mesh = test::model("cube");
    const auto says = [](auto&& call, const char* what) { CHECK(test::contains(test::error_of(call).what(), what)); };
    says([&] { AdaptiveFactoredMesh(mesh, FactoredScheme::four_eight); }, "doo-sabin");
    ControlMeshData creased = mesh.data();
    creased.creases.push_back({0, 1, 2.0f, 0});
    says([&] { AdaptiveFactoredMesh(ControlMesh::build(creased), FactoredScheme::doo_sabin); }, "creases");
    AdaptiveFactoredMesh half(mesh, FactoredScheme::catmull_clark);
    says([&] { half.refine(std::vector<AdaptiveFactoredMesh::Leaf>{{1, LeafId(99999)}}); }, "leaf");
    AdaptiveFactoredMesh other(mesh, FactoredScheme::catmull_clark);
    const std::vector<AdaptiveFactoredMesh::Leaf> first{other.mesh().leaves.front()};
    other.refine(first);
    says([&] { other.refine(first); }, "take leaves from mesh() anew");
    for (const double r : {0.0, -1.0, std::numeric_limits<double>::quiet_NaN()})
        says([&] { half.refine_near({0, 0, 0}, r, 4); }, "radius");
    says([&] { half.refine_near({0, std::numeric_limits<double>::infinity(), 0}, 1, 4); }, "centre");
    says([&] { half.refine_near({1, 1, 1}, 1, 62); }, "61");
    RunContext little;
    little.max_memory_bytes = 1 << 20;
    AdaptiveFactoredMesh small(mesh, FactoredScheme::doo_sabin, little);
    says([&] { small.refine_near({1, 1, 1}, 10, 20); }, "allow more");
    CHECK(half.mesh().leaves.size() == 24);
}

TEST_SUITE_END();
