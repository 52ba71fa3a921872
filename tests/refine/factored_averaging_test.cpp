#include "../kit/factored_helpers.hpp"

#include "../../hier/base/error.hpp"
#include "../../refine/uniform/refine.hpp"

#include <doctest/doctest.h>

#include <optional>

using namespace tetrakis;
using test::k_agreement;

namespace {

constexpr int k_most_steps = 5;
constexpr AveragingBoundary k_boundaries[] = {AveragingBoundary::replicate, AveragingBoundary::recede};

RuleOptions rules(int steps, AveragingBoundary boundary) {
    RuleOptions result;
    result.averaging_steps = steps;
    result.averaging_boundary = boundary;
    return result;
}

FactoredMesh averaging(const ControlMesh& mesh, int steps, AveragingBoundary boundary) {
    return FactoredMesh(mesh, FactoredScheme::averaging, 0, rules(steps, boundary));
}

/// With room for outer rings to recede.
ControlMesh wide_plane(std::uint64_t seed, double tags) {
    test::RandomMeshOptions options;
    options.columns = options.rows = 12;
    options.removed_faces = 0;
    options.hole = 0;
    options.crease *= tags;
    options.corner *= tags;
    options.edge_vertices *= tags;
    return test::random_mesh(seed, options);
}

/// Closed meshes of given valences, open ones with n-gons, with and without tags.
std::vector<ControlMesh> meshes() {
    std::vector<ControlMesh> result;
    for (const int n : {3, 4, 5, 6, 9, 17}) {
        result.push_back(test::prism(n));
        result.push_back(test::double_fan(n));
    }
    for (const std::uint64_t seed : test::seeds(6))
        for (const double tags : {0.0, 1.0}) result.push_back(test::random_surface(seed, tags));
    result.push_back(wide_plane(1, 0));
    result.push_back(wide_plane(2, 1));
    return result;
}

PolygonMesh steps_by_rules(const ControlMesh& mesh, int levels, const RuleOptions& options) {
    return refine_stencils(mesh, scheme_named("averaging"), levels, {.rules = options}).mesh;
}

/// The classical steps; empty where the mesh is used up, or receding leaves faces that touch in a vertex alone.
std::optional<PolygonMesh> classical(const ControlMesh& mesh, int levels, const RuleOptions& options) {
    try {
        return steps_by_rules(mesh, levels, options);
    } catch (const Error& e) {
        CHECK(e.code() == ErrorCode::invalid_input);
        CHECK(options.averaging_boundary == AveragingBoundary::recede);
        return std::nullopt;
    }
}

std::vector<Vec3d> active_points(const FactoredMesh& mesh) {
    std::vector<Vec3d> result;
    for (std::uint32_t v = 0; v < mesh.positions().size(); ++v)
        if (mesh.state(v) == FactoredVertex::active) result.push_back(mesh.positions()[v]);
    return result;
}

/// Calls body(mesh, steps, boundary), with what it is about in the messages.
template <class Body>
void for_all(Body&& body) {
    const std::vector<ControlMesh> all = meshes();
    for (std::size_t i = 0; i < all.size(); ++i)
        for (int steps = 0; steps <= k_most_steps; ++steps)
            for (const AveragingBoundary boundary : k_boundaries) {
                CAPTURE(i);
                CAPTURE(steps);
                CAPTURE(static_cast<int>(boundary));
                body(all[i], steps, boundary);
            }
}

}  // namespace

TEST_SUITE_BEGIN("refine");

TEST_CASE("[inv6] averaging by half-steps: whole levels are the classical steps, three averagings the biquartic ones") {
    int used_up = 0;
    for_all([&](const ControlMesh& mesh, int steps, AveragingBoundary boundary) {
        for (int levels = 1; levels <= 2; ++levels) {
            FactoredMesh ours = averaging(mesh, steps, boundary);
            CHECK(ours.half_steps_per_level() == steps + 2);
            const auto run = [&] {
                for (int i = 0; i < levels * (steps + 2); ++i) ours.half_step();
            };
            if (!classical(mesh, levels, rules(steps, boundary))) {
                ++used_up;
                CHECK_THROWS_AS(run(), Error);
                continue;
            }
            CHECK(test::disagreement_with_rules(mesh, FactoredScheme::averaging, levels, rules(steps, boundary)) <
                  k_agreement);
            if (steps != 3) continue;
            run();
            FactoredMesh biquartic(mesh, FactoredScheme::biquartic, 0, rules(0, boundary));
            while (biquartic.half_steps() < ours.half_steps()) biquartic.half_step();
            CHECK(biquartic.active_mesh().positions == ours.active_mesh().positions);
        }
    });
    CHECK(used_up > 0);
}

TEST_CASE("[inv6] averaging by half-steps: after some averagings the points of so many averagings are active") {
    int touching = 0, compared = 0;
    for_all([&](const ControlMesh& mesh, int steps, AveragingBoundary boundary) {
        FactoredMesh ours = averaging(mesh, steps, boundary);
        if (!classical(mesh, 1, rules(steps, boundary))) return;
        ours.half_step();
        ours.half_step();
        for (int done = 0; done <= steps; ++done) {
            CAPTURE(done);
            if (done > 0) ours.half_step();
            const bool recedes = boundary == AveragingBoundary::recede;
            // Two averagings alone have Catmull-Clark's rules.
            if (done == 2 && steps != 2 && !recedes) continue;
            const auto expected = classical(mesh, 1, rules(done, boundary));
            if (!expected) {
                // That mesh by itself is refused where further averagings take the fault away.
                CHECK_THROWS_WITH_AS(steps_by_rules(mesh, 1, rules(done, boundary)),
                                     doctest::Contains("share nothing but the vertex"), Error);
                ++touching;
                continue;
            }
            ++compared;
            const std::vector<Vec3d> active = active_points(ours);
            const PointMatch points(active);
            double worst = 0;
            for (const Vec3d& p : expected->positions)
                worst = std::max(worst, glm::length(p - active[points.nearest(p)]));
            CHECK(worst < k_agreement * mesh.bounding_box().diagonal());
            // Beside these, only those around the mesh that come from copies.
            if (recedes || done == steps) CHECK(active.size() == expected->positions.size());
            CHECK(active.size() >= expected->positions.size());
            // Which mesh() leaves out: it has the points and a centre in each of their faces.
            CHECK(ours.mesh().positions.size() == expected->positions.size() + (done > 0 ? expected->face_count() : 0));
        }
    });
    CHECK(20 * touching < compared);
}

TEST_CASE("[bad-input] averaging by half-steps: too few steps, too small a mesh, too little memory") {
    CHECK_THROWS_WITH_AS(averaging(test::prism(5), -1, AveragingBoundary::replicate), doctest::Contains("from 0 to 64"),
                         Error);
    test::RandomMeshOptions options;
    options.columns = options.rows = 2;
    options.removed_faces = 0;
    const ControlMesh small = test::random_mesh(1, options);
    for (const bool recedes : {true, false}) {
        FactoredMesh mesh(recedes ? small : test::prism(5), FactoredScheme::averaging, std::uint64_t{1} << 20,
                          rules(k_most_steps, recedes ? AveragingBoundary::recede : AveragingBoundary::replicate));
        const auto refuse = [&] {
            for (int i = 0; i < 40; ++i) mesh.half_step();
        };
        CHECK_THROWS_WITH_AS(refuse(), doctest::Contains(recedes ? "replicate its boundary" : "the limit is 1 MiB"),
                             Error);
        FactoredMesh same = averaging(recedes ? small : test::prism(5), k_most_steps,
                                      recedes ? AveragingBoundary::recede : AveragingBoundary::replicate);
        for (int i = 0; i < mesh.half_steps(); ++i) same.half_step();
        CHECK(mesh.half_steps() >= 2);
        CHECK(mesh.triangles() == same.triangles());
        CHECK(std::equal(mesh.positions().begin(), mesh.positions().end(), same.positions().begin(),
                         same.positions().end()));
    }
}

TEST_SUITE_END();
