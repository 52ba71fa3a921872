#include "../../eval/tessellate/tessellate.hpp"

#include "../kit/point_match.hpp"
#include "../kit/quad_test_mesh.hpp"
#include "../kit/surface_topology.hpp"
#include "../kit/triangle_test_mesh.hpp"

#include "../../refine/adaptive/closure.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cstring>
#include <set>

using namespace tetrakis;

namespace {

constexpr SchemeKind k_schemes[] = {SchemeKind::catmull_clark, SchemeKind::loop};
constexpr EstimatorKind k_estimators[] = {EstimatorKind::measured, EstimatorKind::certified};

double diagonal(const ControlMesh& mesh) { return bounding_box(mesh.positions()).diagonal(); }

/// Random meshes of up to 4 x 4 cells with tags of all kinds, every boundary rule and both crease methods.
ControlMesh make_mesh(SchemeKind scheme, std::uint64_t seed) {
    test::RandomMeshOptions options = test::random_options(seed);
    options.columns = std::min(options.columns, 4);
    options.rows = std::min(options.rows, 4);
    options.triangles_only = scheme == SchemeKind::loop;
    if (seed % 7 == 6) options.boundary_rule = BoundaryRule::none;
    ControlMeshData data = test::random_mesh_data(seed, options);
    data.crease_method = seed % 2 ? CreaseMethod::chaikin : CreaseMethod::uniform;
    return ControlMesh::build(std::move(data));
}

void check_conforming(const ControlMesh& mesh, const Tessellation& result) {
    const TriangleMesh& m = result.mesh;
    CHECK(test::topology(m.triangles) == test::surface_topology(mesh));
    std::set<std::array<std::uint32_t, 3>> seen;
    std::vector<char> used(m.positions.size(), 0);
    bool fine = true;
    for (auto t : m.triangles) {
        for (std::uint32_t v : t) {
            REQUIRE(v < m.positions.size());
            used[v] = 1;
        }
        std::sort(t.begin(), t.end());
        fine &= seen.insert(t).second;
    }
    CHECK(fine);
    CHECK(std::count(used.begin(), used.end(), 0) == 0);
    CHECK(result.triangle_face.size() == m.triangles.size());
    CHECK(result.triangle_error.size() == m.triangles.size());
    for (std::uint32_t f : result.triangle_face) fine &= f < mesh.face_count() && !mesh.is_hole(FaceId(f));
    CHECK(fine);
}

template <class T>
bool same_bytes(const std::vector<T>& a, const std::vector<T>& b) {
    return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0);
}
bool same(const Tessellation& a, const Tessellation& b) {
    return same_bytes(a.mesh.positions, b.mesh.positions) && same_bytes(a.mesh.triangles, b.mesh.triangles) &&
           same_bytes(a.mesh.normals, b.mesh.normals) && same_bytes(a.triangle_face, b.triangle_face) &&
           same_bytes(a.triangle_error, b.triangle_error) && a.certified_error == b.certified_error;
}

/// Limit points, by closure, of all lattice points down to a level.
std::vector<Vec3d> all_limits(const ControlMesh& mesh, SchemeKind scheme, int level) {
    const bool quads = scheme == SchemeKind::catmull_clark;
    std::vector<Site> sites;
    const std::uint32_t n = 1u << level;
    for (std::uint32_t h = 0; h < mesh.halfedge_count(); ++h) {
        const FaceId face = mesh.face(HalfedgeId(h));
        if (mesh.is_hole(face) || (!quads && mesh.face_halfedge(face).value != h)) continue;
        for (std::uint32_t y = 0; y <= n; ++y)
            for (std::uint32_t x = 0; x <= (quads ? n : n - y); ++x)
                sites.push_back({HalfedgeId(h), {x, y}, static_cast<std::uint8_t>(level)});
    }
    std::vector<Vec3d> points(sites.size());
    Closure(mesh, scheme).positions(sites, points);
    return points;
}

}  // namespace

TEST_SUITE_BEGIN("eval");

TEST_CASE("[inv1] [inv3] tessellations are conforming, with vertices at limits that closure gives") {
    for (const SchemeKind scheme : k_schemes)
        for (const EstimatorKind estimator : k_estimators)
            for (const std::uint64_t seed : test::seeds(14)) {
                INFO(name(scheme), estimator == EstimatorKind::measured ? ", measured" : ", certified");
                CAPTURE(seed);
                const ControlMesh mesh = make_mesh(scheme, seed);
                TessellateOptions options;
                options.scheme = scheme;
                options.estimator = estimator;
                options.tolerance = seed % 3 == 0 ? 0.05 : 0.01;
                options.max_level = 3;
                options.min_level = seed % 5 == 4 ? 2 : 0;
                options.measure = false;
                const Tessellation result = tessellate(mesh, options);
                check_conforming(mesh, result);
                CHECK(result.deepest_level <= 3);
                if (result.mesh.triangles.empty()) continue;
                CHECK(result.deepest_level >= options.min_level);
                const std::vector<Vec3d> limits = all_limits(mesh, scheme, 3);
                const PointMatch match(limits);
                double worst = 0;
                for (const Vec3d& p : result.mesh.positions)
                    worst = std::max(worst, glm::length(limits[match.nearest(p)] - p));
                CHECK(worst < 1e-12 * diagonal(mesh));
                bool unit = true;
                for (const Vec3d& n : result.mesh.normals) {
                    const double length = glm::length(n);
                    unit &= std::abs(length - 1) < 1e-12 || length == 0;
                }
                CHECK(unit);
            }
}

TEST_CASE("[slow] [inv9] measured <= certified, and certified <= tolerance with the certified estimator") {
    for (const SchemeKind scheme : k_schemes)
        for (const EstimatorKind estimator : k_estimators)
            for (const std::uint64_t seed : test::seeds(5)) {
                INFO(name(scheme), estimator == EstimatorKind::measured ? ", measured" : ", certified");
                CAPTURE(seed);
                const ControlMesh mesh = make_mesh(scheme, seed + 100);
                TessellateOptions options;
                options.measure = true;
                options.scheme = scheme;
                options.estimator = estimator;
                options.tolerance = 0.02;
                const Tessellation result = tessellate(mesh, options);
                if (result.mesh.triangles.empty()) continue;
                check_conforming(mesh, result);
                REQUIRE(result.measured_error);
                REQUIRE(result.certified_error);
                CHECK(result.tolerance_absolute == doctest::Approx(0.02 * diagonal(mesh)));
                CHECK(result.tolerance_reached);
                CHECK(result.measured_error->hausdorff <= *result.certified_error);
                CHECK(result.measured_error->hausdorff <= result.tolerance_absolute);
                CHECK(result.measured_error->mean <= result.measured_error->rms);
                CHECK(result.measured_error->rms <= result.measured_error->hausdorff);
                if (estimator == EstimatorKind::certified) CHECK(*result.certified_error <= result.tolerance_absolute);
            }
}

TEST_CASE("[slow] [inv9] certified bounds hold where a level or a budget stops the refinement") {
    for (const SchemeKind scheme : k_schemes)
        for (const std::uint64_t seed : test::seeds(4))
            for (const bool budget : {false, true}) {
                INFO(name(scheme), budget ? ", budget" : ", level");
                CAPTURE(seed);
                const ControlMesh mesh = make_mesh(scheme, seed + 30);
                TessellateOptions options;
                options.measure = true;
                options.scheme = scheme;
                options.estimator = EstimatorKind::certified;
                options.tolerance = 1e-4;
                if (budget)
                    options.max_triangles = 300;
                else
                    options.max_level = 1;
                const Tessellation result = tessellate(mesh, options);
                if (result.mesh.triangles.empty()) continue;
                CHECK(result.measured_error->hausdorff <= *result.certified_error);
                CHECK_FALSE(result.tolerance_reached);
                if (!budget) CHECK(result.deepest_level <= 1);
            }
}

TEST_CASE("[inv10] the same bytes for 1 to 4 threads, and from run to run") {
    for (const SchemeKind scheme : k_schemes)
        for (const EstimatorKind estimator : k_estimators)
            for (const bool budget : {false, true}) {
                INFO(name(scheme), estimator == EstimatorKind::measured ? ", measured" : ", certified",
                     budget ? ", budget" : "");
                const ControlMesh mesh = make_mesh(scheme, 8);
                TessellateOptions options;
                options.scheme = scheme;
                options.estimator = estimator;
                options.measure = false;
                options.tolerance = 0.003;
                if (budget) options.max_triangles = 700;
                RunContext context;
                context.threads = 1;
                const Tessellation first = tessellate(mesh, options, context);
                for (const int threads : {1, 2, 3, 4}) {
                    context.threads = threads;
                    CHECK(same(first, tessellate(mesh, options, context)));
                }
            }
}

TEST_CASE("[inv10] measurements do not depend on the number of threads") {
    const ControlMesh mesh = make_mesh(SchemeKind::catmull_clark, 12);
    TessellateOptions options;
    options.measure = true;
    options.tolerance = 0.03;
    RunContext one, three;
    one.threads = 1, three.threads = 3;
    const Tessellation a = tessellate(mesh, options, one), b = tessellate(mesh, options, three);
    CHECK(same(a, b));
    CHECK(a.measured_error->hausdorff == b.measured_error->hausdorff);
    CHECK(a.measured_error->mean == b.measured_error->mean);
    CHECK(a.measured_error->rms == b.measured_error->rms);
}

TEST_CASE("[slow] a budget of triangles is never exceeded, and the error falls as it grows") {
    for (const SchemeKind scheme : k_schemes)
        for (const std::uint64_t seed : test::seeds(3)) {
            INFO(name(scheme));
            CAPTURE(seed);
            const ControlMesh mesh = make_mesh(scheme, seed + 60);
            double before = std::numeric_limits<double>::infinity();
            std::size_t fewest = 0;
            for (const std::uint64_t most : {200, 400, 801, 1600, 3203}) {
                CAPTURE(most);
                TessellateOptions options;
                options.measure = true;
                options.scheme = scheme;
                options.max_triangles = most;
                options.measure_samples = 100'000;
                const Tessellation result = tessellate(mesh, options);
                if (result.mesh.triangles.empty()) break;
                check_conforming(mesh, result);
                REQUIRE(result.mesh.triangles.size() <= most);
                CHECK(result.mesh.triangles.size() > fewest);
                // Closures take a few triangles with them: a step may fall short by those.
                CHECK(result.mesh.triangles.size() + 60 >= most);
                fewest = result.mesh.triangles.size();
                // The measured one: leaf by leaf a split may cost the certified bound what sliding across the new edge
                // had gained.
                CHECK(result.measured_error->hausdorff <= 1.05 * before);
                before = result.measured_error->hausdorff;
                CHECK(*result.certified_error >= before);
            }
        }
}

TEST_CASE("a budget smaller than the coarsest mesh is refused with the number that would do, which does") {
    for (const SchemeKind scheme : k_schemes) {
        const ControlMesh mesh = make_mesh(scheme, 61);
        TessellateOptions options;
        options.scheme = scheme;
        options.max_triangles = 3;
        options.tolerance = 1e-3;
        options.measure = false;
        std::string message;
        try {
            tessellate(mesh, options);
        } catch (const Error& error) {
            CHECK(error.code() == ErrorCode::unsupported);
            message = error.what();
        }
        CAPTURE(message);
        CHECK(message.find("more than the 3 allowed") != std::string::npos);
        const std::string advice = "allow at least ";
        REQUIRE(message.find(advice) != std::string::npos);
        options.max_triangles = std::stoull(message.substr(message.find(advice) + advice.size()));
        CHECK(options.max_triangles > 3);
        const Tessellation result = tessellate(mesh, options);
        check_conforming(mesh, result);
        CHECK(result.mesh.triangles.size() <= options.max_triangles);
        CHECK_FALSE(result.tolerance_reached);
    }
}

TEST_CASE("the positions of a tessellation do not depend on normals being wanted") {
    for (const SchemeKind scheme : k_schemes) {
        const ControlMesh mesh = make_mesh(scheme, 3);
        TessellateOptions options;
        options.scheme = scheme;
        options.tolerance = 0.01;
        options.measure = false;
        const Tessellation with = tessellate(mesh, options);
        options.normals = false;
        const Tessellation without = tessellate(mesh, options);
        CHECK(without.mesh.normals.empty());
        CHECK(same_bytes(with.mesh.positions, without.mesh.positions));
        CHECK(same_bytes(with.mesh.triangles, without.mesh.triangles));
    }
}

TEST_SUITE_END();
