#include "../../eval/tessellate/tessellate.hpp"
#include "../../hier/mesh/mesh_repair.hpp"
#include "../../hier/mesh/triangulate.hpp"
#include "../../hier/obj/obj_reader.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

using namespace tetrakis;

TEST_SUITE_BEGIN("eval");

namespace {

/// Far more than any case takes, sanitizers included.
constexpr double k_most_seconds = 20;

/// Of this process: a busy machine makes no case fail.
double cpu_seconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

/// Tessellates and cancels what takes longer: the case fails then, where it would hang otherwise.
Tessellation in_time(const ControlMesh& mesh, const TessellateOptions& options, double most_seconds) {
    const double start = cpu_seconds();
    RunContext context;
    context.progress = [&](std::string_view, double) { return cpu_seconds() - start < most_seconds; };
    return tessellate(mesh, options, context);
}

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
        {"one point at the origin", [](const Vec3d&) { return Vec3d(0); }},
        {"points repeated", [](const Vec3d& p) { return p.x == 0 ? Vec3d(1, p.y, p.z) : p; }},
        {"faces of one point", [](const Vec3d& p) { return p.z > 0 ? Vec3d(0, 0, 1) : p; }},
        {"folded", [](const Vec3d& p) { return Vec3d(std::abs(p.x), p.y, p.z); }},
        {"tiny", [](const Vec3d& p) { return 1e-6 * p; }},
        {"huge", [](const Vec3d& p) { return 1e6 * p; }},
        {"far away", [](const Vec3d& p) { return p + Vec3d(1e6); }},
    };
    return all;
}

void check_finite(const std::vector<Vec3d>& of) {
    CHECK(std::all_of(of.begin(), of.end(),
                      [](const Vec3d& v) { return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z); }));
}

/// A flat sheet with holes: the one whose recursion had no end is OpenSubdiv's catmark_hole_test3.
ControlMesh flat_sheet() {
    std::string text;
    for (const char* v : {"1.596037 1.006744",  "0.532012 1.006744",  "-0.532012 1.006744",  "-1.596037 1.006744",
                          "1.596037 0.099249",  "0.532012 0.099249",  "-0.532012 0.099249",  "-1.596037 0.099249",
                          "1.596037 -0.808247", "0.532012 -0.808247", "-0.532012 -0.808247", "-1.596037 -0.808247",
                          "1.596037 0.552996",  "1.064024 0.552997",  "1.064024 1.006744",   "0.532012 0.552996",
                          "1.064024 0.099249",  "1.596037 -0.354499", "1.064024 -0.354499",  "0.532012 -0.354499",
                          "1.064024 -0.808247", "1.596037 -1.261994", "1.064024 -1.261994",  "0.532012 -1.261994"}) {
        const std::string pair = v;
        const std::size_t space = pair.find(' ');
        text += "v " + pair.substr(0, space) + " 0" + pair.substr(space) + "\n";
    }
    text +=
        "f 13 1 15 14\nf 3 4 8 7\nf 18 5 17 19\nf 7 8 12 11\nf 22 9 21 23\nf 7 16 2 3\nf 15 2 16 14\nf 16 6 17 14\n"
        "f 17 5 13 14\nf 17 6 20 19\nf 20 10 21 19\nf 21 9 18 19\nf 21 10 24 23\nf 11 24 10 20\nf 11 20 7\n"
        "f 7 20 6 16\nt hole 8/0/0 15 2 7 8 9 5 13 14\nt interpolateboundary 1/0/0 1\n";
    return triangulate(ControlMesh::build(parse_obj(text, "sheet.obj")));
}

/// Triangles that share vertices and edges as no surface does, repaired.
ControlMesh repaired_fins() {
    ControlMeshData data = parse_obj(
        "v -1.75 0 0\nv -0.75 0 0\nv -1.25 0 0.866\nv -1.75 -0.75 0.866\nv -0.75 -0.75 0.866\nv -1.75 0.75 0.866\n"
        "v -0.75 0.75 0.866\nv -0.5 0 0\nv 0.5 0 0\nv 0 0 0.866\nv 0.75 0 0\nv 1.75 0 0\nv 1.25 0 0.866\n"
        "v 1.25 -0.75 0\nv 1.25 0.75 0\n"
        "f 1 2 3\nf 2 1 3\nf 3 4 5\nf 3 7 6\nf 8 9 10\nf 9 8 10\nf 11 12 13\nf 12 11 13\nf 14 12 11\nf 15 11 12\n"
        "t interpolateboundary 1/0/0 1\n",
        "fins.obj");
    repair(data);
    return ControlMesh::build(std::move(data));
}

}  // namespace

TEST_CASE("a proven tolerance is reached, though the way back from the mesh is measured too long") {
    // An open box with creases of several sharpnesses and a hole: Newton's method ends beside its boundary.
    const ControlMesh mesh = ControlMesh::build(
        parse_obj("v -0.26 -0.15 -0.22\nv -0.27 0.18 1.05\nv -0.06 0.74 0.18\nv -0.19 0.78 0.93\n"
                  "v 0.79 -0.06 -0.02\nv 1.29 -0.05 1.08\nv 0.79 0.87 -0.08\nv 1.28 0.82 0.82\n"
                  "f 2 4 3\nf 2 3 1\nf 7 8 6\nf 7 6 5\nf 5 6 2\nf 5 2 1\nf 3 4 8\nf 3 8 7\nf 6 8 4\nf 6 4 2\n"
                  "t crease 2/1/0 0 4 10\nt crease 2/1/0 1 2 0.5\nt crease 2/1/0 2 7 2.5\nt crease 2/1/0 3 5 2.5\n"
                  "t crease 2/1/0 6 7 10\nt hole 1/0/0 7\n",
                  "box.obj"));
    const Tessellation result = tessellate(
        mesh, {.scheme = SchemeKind::loop, .estimator = EstimatorKind::certified, .tolerance = 1e-3, .measure = true});
    CHECK(result.certified_error.value() <= result.tolerance_absolute);
    CHECK(result.measured_error.value().forward <= result.certified_error.value());
    CHECK(result.tolerance_reached);
}

TEST_CASE("flat sheets are certified as quickly as others, though hardly a point of them is off") {
    const ControlMesh mesh = flat_sheet();
    for (const double tolerance : {5e-2, 1e-3})
        for (const EstimatorKind estimator : {EstimatorKind::measured, EstimatorKind::certified}) {
            CAPTURE(tolerance);
            CAPTURE(estimator == EstimatorKind::certified);
            const Tessellation result = in_time(
                mesh, {.scheme = SchemeKind::loop, .estimator = estimator, .tolerance = tolerance}, k_most_seconds);
            CHECK(result.tolerance_reached);
            // By samples, in-plane distances to edges are not looked at; the bound has them.
            if (estimator == EstimatorKind::certified)
                CHECK(result.certified_error.value() <= result.tolerance_absolute);
        }
}

TEST_CASE("[slow] the bound of a tuned scheme comes to an end where there is none at vertices of two triangles") {
    const Tessellation result =
        in_time(repaired_fins(), {.scheme = "tuned-loop", .estimator = EstimatorKind::certified, .tolerance = 1e-2},
                k_most_seconds);
    CHECK(!result.tolerance_reached);
    check_finite(result.mesh.positions);
}

TEST_CASE("[slow] degenerate cages come to an end, by every scheme and both estimators") {
    for (const SchemeInfo& scheme : scheme_table()) {
        // Mask norms are found anew for each mesh, and by the measured estimator as well: some cages have to do for
        // both.
        constexpr int k_of_norms = 3;
        int number = 0;
        for (const Degenerate& degenerate : cages()) {
            const bool has_both = scheme_support(scheme).patches || number++ % k_of_norms == 0;
            for (const EstimatorKind estimator : {EstimatorKind::measured, EstimatorKind::certified}) {
                CAPTURE(std::string(scheme.name));
                CAPTURE(std::string(degenerate.name));
                CAPTURE(estimator == EstimatorKind::certified);
                const ControlMesh mesh = cage(degenerate.map, scheme.family == MeshFamily::triangles);
                if (estimator == EstimatorKind::certified && !(has_both && scheme_support(mesh, scheme).certified))
                    continue;
                TessellateOptions options{.scheme = scheme, .estimator = estimator, .tolerance = 1e-1};
                options.measure_samples = 500;
                if (mesh.bounding_box().diagonal() == 0) {
                    options.tolerance = 1e-3;
                    options.tolerance_is_absolute = true;
                }
                try {
                    const Tessellation result = in_time(mesh, options, k_most_seconds);
                    CHECK(!result.mesh.triangles.empty());
                    check_finite(result.mesh.positions);
                    check_finite(result.mesh.normals);
                    if (result.certified_error) CHECK(*result.certified_error >= 0);
                } catch (const Error& error) {
                    CAPTURE(error.what());
                    CHECK(error.code() == ErrorCode::unsupported);
                }
            }
        }
    }
}

TEST_SUITE_END();
