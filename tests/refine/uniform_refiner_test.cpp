#include "../kit/random_mesh.hpp"

#include "../../hier/base/error.hpp"
#include "../../hier/mesh/triangulate.hpp"
#include "../../refine/uniform/grid_limit.hpp"
#include "../../refine/uniform/grid_refinement.hpp"
#include "../../refine/uniform/uniform.hpp"
#include "../../refine/uniform/uniform_refiner.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cstring>
#include <map>
#include <string>

using namespace tetrakis;

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
bool same_bytes(const std::vector<T>& a, const std::vector<T>& b) {
    return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0;
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

template <class T>
void check_kernel_sets(const detail::GridTopology& topology, std::span<const Vec3<T>> control) {
    std::vector<T> nets[2], limits[2], normals[2];
    int i = 0;
    for (const detail::KernelSet set : {detail::KernelSet::baseline, detail::KernelSet::avx2}) {
        if (!detail::has_kernels(set)) {
            MESSAGE("no AVX2 here: nothing to compare with");
            return;
        }
        detail::GridPoints<T> points(topology, detail::LevelSteps::whole, set);
        const std::size_t count = 3 * std::size_t{topology.last().vertex_count()};
        nets[i].assign(count + detail::k_limit_padding, T(0));
        limits[i].resize(count);
        normals[i].resize(count);
        points.run(control, nets[i].data(), {});
        detail::grid_limits(topology, nets[i].data(), limits[i].data(), normals[i].data(), {}, set);
        ++i;
    }
    CHECK(same_bytes(nets[0], nets[1]));
    CHECK(same_bytes(limits[0], limits[1]));
    CHECK(same_bytes(normals[0], normals[1]));
}

}  // namespace

TEST_SUITE_BEGIN("refine");

TEST_CASE("[inv10] row kernels give the same bytes whatever they are compiled for") {
    for (const SchemeKind scheme : k_schemes)
        for (const std::uint64_t seed : test::seeds(4)) {
            CAPTURE(seed);
            const ControlMesh mesh = make_mesh(scheme, seed);
            for (const int levels : {1, 2, 3, 5}) {
                const detail::GridTopology topology(mesh, scheme, levels, detail::PointRule::scheme);
                check_kernel_sets<double>(topology, mesh.positions());
                check_kernel_sets<float>(topology, control_of<float>(mesh));
            }
        }
}

TEST_CASE("a refiner used again gives what a new one gives, for other positions of the same mesh") {
    for (const SchemeKind scheme : k_schemes)
        for (const std::uint64_t seed : test::seeds(4)) {
            CAPTURE(seed);
            const ControlMesh mesh = make_mesh(scheme, seed, CreaseMethod::chaikin);
            ControlMeshData data = mesh.data();
            for (Vec3d& p : data.positions) p = Vec3d(p.z - p.x, p.y * p.x, 2 * p.z + 1);
            const ControlMesh moved = ControlMesh::build(std::move(data));
            UniformOptions options;
            for (options.limit = false;; options.limit = true) {
                UniformRefiner<double> refiner(mesh, scheme, 3, options), fresh(moved, scheme, 3, options);
                const Result<double> before = refined<double>(refiner, mesh.positions());
                const Result<double> again = refined<double>(refiner, moved.positions());
                const Result<double> expected = refined<double>(fresh, moved.positions());
                CHECK(same_bytes(again.positions, expected.positions));
                CHECK(same_bytes(again.normals, expected.normals));
                CHECK(!same_bytes(again.positions, before.positions));
                const Result<double> back = refined<double>(refiner, mesh.positions());
                CHECK(same_bytes(back.positions, before.positions));
                CHECK(same_bytes(back.normals, before.normals));
                if (options.limit) break;
            }
        }
}

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

TEST_CASE("kept buffers hold what a caller's would, faces included") {
    for (const SchemeKind scheme : k_schemes)
        for (const bool limit : {false, true}) {
            const ControlMesh mesh = make_mesh(scheme, 2);
            UniformRefiner<float> kept(mesh, scheme, 3, {.limit = limit, .normals = limit}),
                other(mesh, scheme, 3, {.limit = limit});
            const std::vector<Vec3f> control = control_of<float>(mesh);
            const Result<float> expected = refined<float>(other, control);
            std::vector<std::uint32_t> faces(std::size_t{other.face_count()} *
                                             static_cast<std::size_t>(other.face_size()));
            other.faces(faces);
            for (int i = 0; i < 2; ++i) {
                const UniformLevel<float> level = kept.refine(control);
                CHECK(
                    same_bytes(std::vector<Vec3f>(level.positions.begin(), level.positions.end()), expected.positions));
                CHECK(std::ranges::equal(level.faces, faces));
                if (limit)
                    CHECK(same_bytes(std::vector<Vec3f>(level.normals.begin(), level.normals.end()), expected.normals));
                else
                    CHECK(level.normals.empty());
            }
        }
}

TEST_CASE("[inv3] faces: every inner edge has two sides of opposite directions, and each face knows its control face") {
    for (const SchemeKind scheme : k_schemes)
        for (const std::uint64_t seed : test::seeds(4)) {
            CAPTURE(seed);
            const ControlMesh mesh = make_mesh(scheme, seed);
            constexpr int k_levels = 3;
            UniformRefiner<float> refiner(mesh, scheme, k_levels);
            const auto size = static_cast<std::uint32_t>(refiner.face_size());
            std::vector<std::uint32_t> corners(std::size_t{refiner.face_count()} * size);
            refiner.faces(corners);
            std::map<std::pair<std::uint32_t, std::uint32_t>, int> sides;
            std::map<std::uint32_t, std::uint32_t> faces_of;
            for (std::uint32_t f = 0; f < refiner.face_count(); ++f) {
                for (std::uint32_t i = 0; i < size; ++i) {
                    const std::uint32_t a = corners[f * size + i], b = corners[f * size + (i + 1) % size];
                    REQUIRE(a < refiner.vertex_count());
                    ++sides[{a, b}];
                }
                ++faces_of[refiner.control_face(f)];
            }
            std::uint32_t boundary = 0, control_boundary = 0;
            for (const auto& [side, count] : sides) {
                REQUIRE(count == 1);
                boundary += sides.contains({side.second, side.first}) ? 0 : 1;
            }
            for (std::uint32_t e = 0; e < mesh.edge_count(); ++e) control_boundary += mesh.is_boundary(EdgeId(e));
            CHECK(boundary == control_boundary << k_levels);
            for (std::uint32_t f = 0; f < mesh.face_count(); ++f) {
                const std::uint32_t parts = scheme == SchemeKind::loop ? 4 : mesh.face_size(FaceId(f));
                CHECK(faces_of[f] == parts << 2 * (k_levels - 1));
            }
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
