#include "tetrakis/eval/tessellate.hpp"
#include "tetrakis/hier/obj_reader.hpp"
#include "tetrakis/hier/triangulate.hpp"

#include <doctest/doctest.h>

#include <chrono>
#include <cmath>
#include <functional>
#include <string>
#include <vector>

using namespace tetrakis;

TEST_SUITE_BEGIN("eval");

namespace {

/// Far more than any of these takes, and far less than it takes to be a hang.
constexpr double k_most_seconds = 20;

using Map = std::function<Vec3d(const Vec3d&)>;

/// A cage moved to places that are not general: a box of quads with a crease, a corner and an open side, as a surface
/// with valences 3 to 5, boundary and tags.
ControlMesh cage(const Map& map, bool triangles) {
    ControlMeshData data = parse_obj(
        "v -1 -1 -1\nv 0 -1 -1\nv 1 -1 -1\nv -1 1 -1\nv 0 1 -1\nv 1 1 -1\n"
        "v -1 -1 1\nv 0 -1 1\nv 1 -1 1\nv -1 1 1\nv 0 1 1\nv 1 1 1\n"
        "f 1 4 5 2\nf 2 5 6 3\nf 1 2 8 7\nf 2 3 9 8\nf 5 4 10 11\nf 6 5 11 12\nf 4 1 7 10\nf 7 8 11 10\n"
        "t crease 2/1/0 1 4 1.5\nt crease 2/1/0 7 10 10\nt corner 1/1/0 0 10\n",
        "cage.obj");
    for (Vec3d& p : data.positions) p = map(p);
    ControlMesh mesh = ControlMesh::build(std::move(data));
    return triangles ? triangulate(mesh) : mesh;
}

struct Degenerate {
    const char* name;
    Map map;
};

const std::vector<Degenerate>& cages() {
    static const std::vector<Degenerate> all{
        {"flat", [](const Vec3d& p) { return Vec3d(p.x + 0.3 * p.z, p.y - 0.2 * p.z, 0); }},
        {"collinear", [](const Vec3d& p) { return (p.x + 3 * p.y + 9 * p.z) * Vec3d(1, 2, 3); }},
        {"needles", [](const Vec3d& p) { return Vec3d(p.x, 1e-7 * p.y, 1e-7 * p.z); }},
        {"one point", [](const Vec3d&) { return Vec3d(1, 2, 3); }},
        {"points repeated", [](const Vec3d& p) { return p.x == 0 ? Vec3d(1, p.y, p.z) : p; }},
        {"folded", [](const Vec3d& p) { return Vec3d(std::abs(p.x), p.y, p.z); }},
        {"tiny", [](const Vec3d& p) { return 1e-6 * p; }},
        {"huge", [](const Vec3d& p) { return 1e6 * p; }},
        {"far away", [](const Vec3d& p) { return p + Vec3d(1e6); }},
    };
    return all;
}

}  // namespace

TEST_CASE("degenerate cages come to an end, by every scheme and both estimators") {
    for (const SchemeInfo& scheme : scheme_table())
        for (const Degenerate& degenerate : cages())
            for (const EstimatorKind estimator : {EstimatorKind::embree, EstimatorKind::certified}) {
                const auto start = std::chrono::steady_clock::now();
                const auto seconds = [&] {
                    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
                };
                CAPTURE(std::string(scheme.name));
                CAPTURE(degenerate.name);
                CAPTURE(estimator == EstimatorKind::certified);
                const ControlMesh mesh = cage(degenerate.map, scheme.family == MeshFamily::triangles);
                if (estimator == EstimatorKind::certified && !scheme_support(mesh, scheme).certified) continue;
                RunContext context;
                context.progress = [&](std::string_view, double) { return seconds() < k_most_seconds; };
                TessellateOptions options{.scheme = scheme, .estimator = estimator, .tolerance = 1e-2};
                options.measure_samples = 2'000;
                const double diagonal = mesh.bounding_box().diagonal();
                if (diagonal == 0) {
                    options.tolerance = 1e-3;
                    options.tolerance_is_absolute = true;
                }
                try {
                    const Tessellation result = tessellate(mesh, options, context);
                    CHECK(!result.mesh.triangles.empty());
                    for (const Vec3d& p : result.mesh.positions)
                        REQUIRE((std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z)));
                    for (const Vec3d& n : result.mesh.normals)
                        REQUIRE((std::isfinite(n.x) && std::isfinite(n.y) && std::isfinite(n.z)));
                    if (result.certified_error) CHECK(*result.certified_error >= 0);
                } catch (const Error& error) {
                    CAPTURE(error.what());
                    CHECK(error.code() == ErrorCode::unsupported);
                }
                if (seconds() > 0.5)
                    MESSAGE(std::string(scheme.name), " ", degenerate.name, " ", estimator == EstimatorKind::certified,
                            " ", seconds());
            }
}

TEST_SUITE_END();
