#include "../../eval/io/mesh_writer.hpp"
#include "../../hier/base/error.hpp"

#include "../kit/input_helpers.hpp"
#include "../kit/scratch_dir.hpp"
#include "../kit/shapes.hpp"

#include <doctest/doctest.h>
#include <sys/resource.h>

#include <cmath>
#include <csignal>
#include <filesystem>
#include <string>

using namespace tetrakis;

TEST_SUITE_BEGIN("contract");

TEST_CASE("[bad-input] a failed write leaves the directory as it was and says why") {
    const ScratchDir dir;
    const TriangleMesh mesh = shapes::octahedron();
    const auto failure = [&](const std::filesystem::path& path, const TriangleMesh& what,
                             ErrorCode code = ErrorCode::io) -> std::string {
        const Error error = test::error_of([&] { write_mesh(path, what); });
        CHECK(error.code() == code);
        return error.what();
    };
    CHECK(failure(dir / "no/such/place.obj", mesh).find("there is no directory") != std::string::npos);
    CHECK(failure(dir / "mesh.xyz", mesh, ErrorCode::unsupported).find("use .obj, .ply or .glb") != std::string::npos);
    CHECK(failure(dir / "mesh", mesh, ErrorCode::unsupported).find("needs an extension") != std::string::npos);
    CHECK(failure(dir / (std::string(300, 'x') + ".obj"), mesh).find("too long") != std::string::npos);
    std::filesystem::create_directory(dir / "taken.ply");
    CHECK(failure(dir / "taken.ply", mesh).find("this is a directory") != std::string::npos);
    TriangleMesh bad = mesh;
    bad.triangles[2][1] = 6;
    CHECK(failure(dir / "bad.obj", bad, ErrorCode::invalid_input) ==
          "mesh to write: vertex index number 7 is 6, but there are 6");
    bad = mesh;
    bad.positions[1].x = std::nan("");
    CHECK(failure(dir / "bad.obj", bad, ErrorCode::invalid_input) == "mesh to write: position 1 is not finite");
    bad = mesh;
    bad.normals = bad.positions;
    bad.triangle_normals = bad.triangles;
    bad.triangle_normals[1][2] = 6;
    CHECK(failure(dir / "bad.obj", bad, ErrorCode::invalid_input).find("normal index number 5 is 6") !=
          std::string::npos);
    bad.triangle_normals.pop_back();
    CHECK(failure(dir / "bad.obj", bad, ErrorCode::invalid_input).find("21 normal indices for 24") !=
          std::string::npos);
    bad = mesh;
    bad.positions[1].x = 1e39;
    bad.positions[0].x = -1e39;
    CHECK(failure(dir / "bad.glb", bad, ErrorCode::unsupported).find("exceed the floats") != std::string::npos);
    CHECK(dir.file_count() == 1);  // the directory made above

    write_mesh(dir / "kept.obj", mesh);
    const std::string before = slurp(dir / "kept.obj");
    RunContext context;
    context.progress = [](std::string_view, double) { return false; };
    CHECK_THROWS_AS(write_mesh(dir / "kept.obj", mesh, context), Error);
    CHECK(slurp(dir / "kept.obj") == before);
    CHECK(dir.file_count() == 2);
}

TEST_CASE("[bad-input] a disk that fills up leaves no partial file") {
    const ScratchDir dir;
    const TriangleMesh mesh = shapes::sphere(60, 120, Vec3d(0), 1.0);
    // A file size limit is what a full disk looks like to one process; /dev/full is what the kernel offers.
    rlimit old{};
    ::getrlimit(RLIMIT_FSIZE, &old);
    const auto old_handler = std::signal(SIGXFSZ, SIG_IGN);
    const rlimit small{10'000, old.rlim_max};
    ::setrlimit(RLIMIT_FSIZE, &small);
    for (const char* name : {"big.obj", "big.ply", "big.glb"}) {
        const Error error = test::error_of([&] { write_mesh(dir / name, mesh); });
        CHECK(error.code() == ErrorCode::io);
        CHECK(test::contains(error.what(), "larger than the system allows"));
    }
    ::setrlimit(RLIMIT_FSIZE, &old);
    std::signal(SIGXFSZ, old_handler);
    CHECK(dir.file_count() == 0);
}

TEST_SUITE_END();
