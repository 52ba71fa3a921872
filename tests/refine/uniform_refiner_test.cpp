#include "../kit/random_mesh.hpp"
#include "../kit/same_bytes.hpp"

#include "../../hier/base/error.hpp"
#include "../../hier/mesh/triangulate.hpp"
#include "../../refine/uniform/grid_limit.hpp"
#include "../../refine/uniform/grid_refinement.hpp"
#include "../../refine/uniform/uniform_refiner.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cstring>
#include <string>

using namespace tetrakis;
using test::same_bytes;

namespace {

constexpr SchemeKind k_schemes[] = {SchemeKind::catmull_clark, SchemeKind::loop};

/// Quads only for odd seeds, so that both kinds of roots occur.
ControlMesh make_mesh(SchemeKind scheme, std::uint64_t seed, CreaseMethod method = CreaseMethod::uniform) {
    test::RandomMeshOptions options = test::random_options(seed);
    if (seed % 2 == 1) {
        options.split = options.merge = options.edge_vertices = 0;
        options.topology = test::Topology::torus;
    }
    ControlMeshData data = test::random_mesh_data(seed, options);
    data.crease_method = method;
    const ControlMesh mesh = ControlMesh::build(std::move(data));
    return scheme == SchemeKind::loop ? triangulate(mesh) : mesh;
}

template <class T>
std::vector<Vec3<T>> control_of(const ControlMesh& mesh) {
    return {mesh.positions().begin(), mesh.positions().end()};
}

template <class T>
struct Result {
    std::vector<Vec3<T>> positions, normals;
};

template <class T>
Result<T> refined(UniformRefiner<T>& refiner, std::span<const Vec3<T>> control) {
    Result<T> result;
    result.positions.resize(refiner.vertex_count());
    result.normals.resize(refiner.vertex_count());
    refiner.refine(control, result.positions, result.normals);
    return result;
}

}  // namespace

TEST_SUITE_BEGIN("refine");

TEST_CASE("float positions and normals are those of double, rounded") {
    for (const SchemeKind scheme : k_schemes)
        for (const std::uint64_t seed : test::seeds(6)) {
            CAPTURE(seed);
            const ControlMesh mesh = make_mesh(scheme, seed);
            const double diagonal = bounding_box(mesh.positions()).diagonal();
            UniformRefiner<double> doubles(mesh, scheme, 3, {.limit = true});
            UniformRefiner<float> floats(mesh, scheme, 3, {.limit = true});
            const Result<double> exact = refined<double>(doubles, mesh.positions());
            const Result<float> rounded = refined<float>(floats, control_of<float>(mesh));
            double worst = 0;
            for (std::size_t v = 0; v < exact.positions.size(); ++v)
                worst = std::max(worst, glm::length(exact.positions[v] - Vec3d(rounded.positions[v])));
            CHECK(worst < 1e-6 * diagonal);
        }
}

TEST_CASE("normals have length one and do not depend on whether positions are asked for on the limit") {
    for (const SchemeKind scheme : k_schemes) {
        const ControlMesh mesh = make_mesh(scheme, 1);
        UniformRefiner<double> limits(mesh, scheme, 3, {.limit = true}), nets(mesh, scheme, 3);
        const Result<double> a = refined<double>(limits, mesh.positions());
        const Result<double> b = refined<double>(nets, mesh.positions());
        CHECK(same_bytes(a.normals, b.normals));
        CHECK(!same_bytes(a.positions, b.positions));
        std::vector<Vec3d> alone(nets.vertex_count());
        nets.refine(mesh.positions(), alone);
        CHECK(same_bytes(alone, b.positions));
        for (const Vec3d& n : a.normals) REQUIRE(glm::length(n) == doctest::Approx(1).epsilon(1e-12));
    }
}

TEST_CASE("a refiner refuses what does not fit, and writes nothing") {
    const ControlMesh mesh = make_mesh(SchemeKind::catmull_clark, 1);
    UniformRefiner<double> refiner(mesh, SchemeKind::catmull_clark, 2);
    const Vec3d mark(4711, 0, -1);
    std::vector<Vec3d> out(refiner.vertex_count(), mark), control = control_of<double>(mesh);
    const auto refuses = [&](const auto& call) {
        try {
            call();
        } catch (const Error& error) {
            return error.code() == ErrorCode::invalid_input;
        }
        return false;
    };
    CHECK(refuses([&] { refiner.refine(std::span(control).subspan(1), out); }));
    CHECK(refuses([&] { refiner.refine(control, std::span(out).subspan(1)); }));
    CHECK(refuses([&] { refiner.refine(control, out, std::span(out).subspan(1)); }));
    std::vector<std::uint32_t> corners(4 * std::size_t{refiner.face_count()} + 1);
    CHECK(refuses([&] { refiner.faces(corners); }));
    CHECK(refuses([&] { UniformRefiner<double>(mesh, SchemeKind::loop, 2); }));
    CHECK(refuses([&] { UniformRefiner<double>(mesh, SchemeKind::catmull_clark, -1); }));
    for (const Vec3d& p : out) REQUIRE(p == mark);

    UniformOptions options;
    options.context.max_memory_bytes = std::uint64_t{64} << 20;
    std::string message;
    try {
        UniformRefiner<double>(mesh, SchemeKind::catmull_clark, 10, options);
    } catch (const Error& error) {
        CHECK(error.code() == ErrorCode::memory_limit);
        message = error.what();
    }
    CHECK(message.find("64 MiB") != std::string::npos);
    CHECK(message.find("10 levels") != std::string::npos);
}

TEST_SUITE_END();
