#include "../../eval/distance/limit_samples.hpp"
#include "../../eval/tessellate/tessellate.hpp"

#include "../../eval/distance/hausdorff.hpp"
#include "../../hier/obj/obj_reader.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

using namespace tetrakis;

namespace {

struct Tagged {
    ControlMesh mesh;
    HalfedgeId root;  ///< with corner (0, 0) at vertex 0 and x towards vertex 1
};

/// A strip of two quads, or four triangles, with tags for the edge between vertices 1 and 4 or vertex 1.
Tagged strip_mesh(const std::string& tags, bool triangles) {
    const std::string points = "v 0 0 0\nv 1 0 0\nv 2 0 0\nv 0 1 0\nv 1 1 0\nv 2 1 0\n";
    const std::string faces = triangles ? "f 1 2 5\nf 1 5 4\nf 2 3 6\nf 2 6 5\n" : "f 1 2 5 4\nf 2 3 6 5\n";
    Tagged out{ControlMesh::build(parse_obj(points + faces + tags, "test.obj")), {}};
    for (std::uint32_t h = 0; h < out.mesh.halfedge_count(); ++h) {
        const HalfedgeId half(h);
        if (out.mesh.origin(half).value == 1 && out.mesh.origin(out.mesh.next(half)).value == 4) out.root = half;
    }
    return out;
}

template <class Family>
std::vector<Vec3d> strip_points(const ControlMesh& mesh, const CellTriangle& leaf) {
    std::vector<Vec3d> points;
    detail::for_each_strip_point<Family>(mesh, leaf,
                                         [&](double b0, double b1, double b2) { points.emplace_back(b0, b1, b2); });
    for (const Vec3d& b : points) {
        CHECK(std::min({b.x, b.y, b.z}) >= 0);
        CHECK(b.x + b.y + b.z == doctest::Approx(1).epsilon(1e-14));
    }
    return points;
}

double least(const std::vector<Vec3d>& points, int k) {
    double value = 1;
    for (const Vec3d& b : points) value = std::min(value, b[k]);
    return value;
}

}  // namespace

TEST_SUITE_BEGIN("eval");

TEST_CASE_TEMPLATE("samples come nearer to a crease of finite sharpness than it is wide", Family, QuadFamily,
                   LoopFamily) {
    constexpr bool k_triangles = std::is_same_v<Family, LoopFamily>;
    const Tagged smooth = strip_mesh("", k_triangles), crease = strip_mesh("t crease 2/1/0 1 4 6.5\n", k_triangles),
                 sharp = strip_mesh("t crease 2/1/0 1 4 10\n", k_triangles);
    REQUIRE(crease.root.valid());
    // Its edge 0 lies on the crease; the other one touches it with a corner away from its ends.
    const CellTriangle along{crease.root, 2, {LatticePoint{1, 0}, {2, 0}, {1, 1}}};
    const CellTriangle touches{crease.root, 2, {LatticePoint{1, 0}, {2, 1}, {1, 1}}};
    CHECK(strip_points<Family>(smooth.mesh, {smooth.root, 2, along.corner}).empty());
    CHECK(strip_points<Family>(sharp.mesh, {sharp.root, 2, along.corner}).empty());
    const double width = std::exp2(2 - 6.5);  // in the leaf
    const auto beside = strip_points<Family>(crease.mesh, along);
    CHECK(least(beside, 2) <= 0.5 * width);
    CHECK(least(beside, 2) > 0);
    const auto near_corner = strip_points<Family>(crease.mesh, touches);
    REQUIRE(!near_corner.empty());
    double nearest = 0;
    for (const Vec3d& b : near_corner) nearest = std::max(nearest, b.x);
    CHECK(1 - nearest <= 0.5 * width);
    // Narrower than the strip: the lattice sees to it.
    const CellTriangle small{crease.root, 10, {LatticePoint{1, 0}, {2, 0}, {1, 1}}};
    CHECK(strip_points<Family>(crease.mesh, small).empty());
}

TEST_CASE("samples come near to vertices of finite sharpness") {
    const Tagged tagged = strip_mesh("t corner 1/1/0 1 5.5\n", false);
    const CellTriangle at{tagged.root, 2, {LatticePoint{0, 0}, {1, 0}, {0, 1}}};
    const auto points = strip_points<QuadFamily>(tagged.mesh, at);
    REQUIRE(!points.empty());
    double nearest = 0;
    for (const Vec3d& b : points) nearest = std::max(nearest, b.x);
    CHECK(1 - nearest <= 0.5 * std::exp2(2 - 5.5));
    const CellTriangle away{tagged.root, 2, {LatticePoint{1, 1}, {2, 1}, {1, 2}}};
    CHECK(strip_points<QuadFamily>(tagged.mesh, away).empty());
}

TEST_CASE("[slow] [inv9] narrow rounded creases within a leaf are seen: the rook at 1e-4") {
    // OpenSubdiv's, whose creases have a sharpness of 7.9; it lies beside the project.
    const char* shared = std::getenv("TETRAKIS_SHARED_DIR");
    const std::filesystem::path path =
        std::filesystem::path(shared != nullptr ? shared : TETRAKIS_SOURCE_DIR "/../shared") /
        "data/osd-shapes/catmark_rook.obj";
    if (!std::filesystem::exists(path)) {
        MESSAGE("SKIPPED: there is no ", path.string(), " (set TETRAKIS_SHARED_DIR)");
        return;
    }
    const ControlMesh mesh = ControlMesh::build(read_obj(path, {.repair = true}));
    TessellateOptions options{.tolerance = 1e-4, .measure = true};
    options.normals = options.uvs = false;
    const Tessellation result = tessellate(mesh, options);
    CHECK(result.tolerance_reached);
    CHECK(result.measured_error->hausdorff <= result.tolerance_absolute);
    constexpr double k_finer = 0.2;
    options.estimator = EstimatorKind::certified;
    options.measure = false;
    options.tolerance = k_finer * 1e-4;
    const Tessellation truth = tessellate(mesh, options);
    const MeasuredError error = compare(truth.mesh, result.mesh, {.samples = 200'000}).error;
    CHECK(error.hausdorff <= (1 + k_finer) * result.tolerance_absolute);
}

TEST_SUITE_END();
