#include "../../eval/io/mesh_reader.hpp"
#include "../../eval/io/mesh_writer.hpp"
#include "../../eval/tessellate/tessellate.hpp"
#include "../../hier/mesh/obj_reader.hpp"
#include "../../refine/uniform/refine.hpp"

#include "../kit/scratch_dir.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>

using namespace tetrakis;

// What files give back of results; their formats by themselves are in io_test.cpp and obj_reader_test.cpp.

namespace {

/// A cube with a chart for each face, two materials, two groups and a crease around the bottom.
const std::string k_cube =
    "v -1 -1 -1\nv 1 -1 -1\nv -1 1 -1\nv 1 1 -1\nv -1 -1 1\nv 1 -1 1\nv -1 1 1\nv 1 1 1\n"
    "vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n"
    "g bottom\nusemtl wood\nf 1/1 3/2 4/3 2/4\nf 5/1 6/2 8/3 7/4\n"
    "g sides\nusemtl blue steel\nf 1/1 2/2 6/3 5/4\nf 4/1 3/2 7/3 8/4\nf 3/1 1/2 5/3 7/4\nf 2/1 4/2 8/3 6/4\n"
    "t crease 2/1/0 0 1 10\nt crease 2/1/0 1 3 10\nt crease 2/1/0 3 2 10\nt crease 2/1/0 2 0 10\n";

Tessellation cube() {
    return tessellate(ControlMesh::build(parse_obj(k_cube, "cube.obj")), {.tolerance = 1e-2, .measure = false});
}

/// The normal at a triangle's corner.
Vec3d normal_at(const TriangleMesh& mesh, std::size_t t, std::size_t k) {
    return mesh.normals[mesh.triangle_normals.empty() ? mesh.triangles[t][k] : mesh.triangle_normals[t][k]];
}

/// What a call ends with, if with an error.
template <class Call>
std::optional<Error> error_of(const Call& call) {
    try {
        call();
    } catch (const Error& error) {
        return error;
    }
    return std::nullopt;
}

}  // namespace

TEST_SUITE_BEGIN("contract");

TEST_CASE("a tessellation comes back from every format: places, triangles, normals by corner, UVs, materials") {
    const ScratchDir dir;
    const TriangleMesh mesh = cube().mesh;
    REQUIRE(!mesh.triangle_normals.empty());  // the crease's
    REQUIRE(!mesh.triangle_uvs.empty());
    for (const std::string name : {"a.obj", "a.ply", "a.glb"}) {
        CAPTURE(name);
        write_mesh(dir / name, mesh);
        const TriangleMesh back = read_triangle_mesh(dir / name);
        const bool floats = name == "a.glb";
        REQUIRE(back.triangles.size() == mesh.triangles.size());
        REQUIRE(!back.normals.empty());
        REQUIRE(back.triangle_uvs.size() == mesh.triangles.size());
        REQUIRE(back.triangle_material.size() == mesh.triangles.size());
        // GLB is in parts, one for each material and group: triangles are found by their places.
        const double near = floats ? 1e-6 : 0;
        std::size_t missing = 0;
        double normals = 0, uvs = 0;
        for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
            const auto same = [&](std::size_t s) {
                for (std::size_t k = 0; k < 3; ++k)
                    if (glm::length(back.positions[back.triangles[s][k]] - mesh.positions[mesh.triangles[t][k]]) > near)
                        return false;
                return true;
            };
            std::size_t s = t;
            if (!same(s))
                for (s = 0; s < back.triangles.size() && !same(s);) ++s;
            if (s == back.triangles.size()) {
                ++missing;
                continue;
            }
            for (std::size_t k = 0; k < 3; ++k) {
                normals = std::max(normals, glm::length(normal_at(back, s, k) - normal_at(mesh, t, k)));
                uvs = std::max(uvs, glm::length(back.uvs[back.triangle_uvs[s][k]] - mesh.uvs[mesh.triangle_uvs[t][k]]));
            }
            CHECK(back.materials[back.triangle_material[s]] == mesh.materials[mesh.triangle_material[t]]);
        }
        CHECK(missing == 0);
        CHECK(normals <= (floats ? 1e-6 : 0));
        CHECK(uvs <= (floats ? 1e-6 : 0));
    }
    CHECK(dir.file_count() == 3);
}

TEST_CASE("what refine() makes comes back: polygons with their UVs and materials") {
    const ScratchDir dir;
    const PolygonMesh mesh =
        refine(ControlMesh::build(parse_obj(k_cube, "cube.obj")), "catmull-clark", 2, {.limit = true, .normals = true});
    write_mesh(dir / "a.obj", mesh);
    const ControlMeshData back = read_obj(dir / "a.obj");
    CHECK(back.positions == mesh.positions);
    CHECK(back.face_offsets == mesh.face_offsets);
    CHECK(back.face_vertices == mesh.face_vertices);
    CHECK(back.face_material == mesh.face_material);
    CHECK(back.materials == mesh.materials);
    REQUIRE(back.face_uvs.size() == mesh.face_uvs.size());
    double off = 0;
    for (std::size_t c = 0; c < mesh.face_uvs.size(); ++c)
        off = std::max(off, glm::length(back.uvs[back.face_uvs[c]] - mesh.uvs[mesh.face_uvs[c]]));
    CHECK(off <= 1e-7);  // of control meshes only positions are read to the last bit
}

TEST_CASE("[bad-input] shorter lengths of a good file are read or end in an error that names the file") {
    const ScratchDir dir;
    TriangleMesh mesh;
    mesh.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
    mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
    mesh.normals.assign(4, {0, 0, 1});
    mesh.uvs = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
    mesh.triangle_uvs = mesh.triangles;
    mesh.triangle_material = {0, 1};
    mesh.materials = {"wood", "stone"};
    for (const char* name : {"cut.obj", "cut.ply", "cut.glb", "control.obj"}) {
        CAPTURE(name);
        const auto path = dir / name;
        const bool control = name == std::string("control.obj"), text = std::string(name).ends_with(".obj");
        if (control)
            spill(path, k_cube);
        else
            write_mesh(path, mesh);
        const std::string bytes = slurp(path);
        std::size_t tried = 0, whole = 0, refused = 0;
        for (std::size_t length = 0; length < bytes.size(); length += 3) {
            ++tried;
            spill(path, bytes.substr(0, length));
            const auto error = error_of([&] {
                if (control)
                    load_control_mesh(path);
                else
                    read_triangle_mesh(path);
            });
            whole += !error;
            refused += error && error->code() == ErrorCode::invalid_input && error->file() == path &&
                       std::string(error->what()).find(path.string()) != std::string::npos;
        }
        CHECK(whole + refused == tried);
        CHECK(refused > 0);
        if (!text) CHECK(whole == 0);
        const auto missing = error_of([&] { read_triangle_mesh(dir / "none.ply"); });
        REQUIRE(missing);
        CHECK(missing->code() == ErrorCode::io);
        CHECK(missing->file() == dir / "none.ply");
    }
}

TEST_CASE("every tag of an OBJ file has its effect on the control mesh") {
    const ControlMesh mesh = ControlMesh::build(
        parse_obj("v 0 0 0\nv 1 0 0\nv 2 0 0\nv 0 1 0\nv 1 1 0\nv 2 1 0\nv 0 2 0\nv 1 2 0\nv 2 2 0\n"
                  "vt 0 0\nf 1/1 2/1 5/1 4/1\nf 2/1 3/1 6/1 5/1\nf 4/1 5/1 8/1 7/1\nf 5/1 6/1 9/1 8/1\n"
                  "t crease 4/2/0 1 4 4 7 2.5 10\nt crease 2/1/0 4 5 1\nt corner 1/1/0 4 3\nt corner 2/2/0 0 2 4 12\n"
                  "t hole 1/0/0 3\nt interpolateboundary 1/0/0 2\nt facevaryinginterpolateboundary 1/0/0 4\n"
                  "t creasemethod 0/0/1 chaikin\nt cornerangle 2/1/0 2 1 60\n",
                  "tags.obj"));
    const auto sharpness = [&](std::uint32_t a, std::uint32_t b) -> float {
        for (std::uint32_t h = 0; h < mesh.halfedge_count(); ++h)
            if (mesh.origin(HalfedgeId(h)).value == a && mesh.target(HalfedgeId(h)).value == b)
                return mesh.sharpness(mesh.edge(HalfedgeId(h)));
        return -1;
    };
    CHECK(sharpness(1, 4) == 2.5f);
    CHECK(std::isinf(sharpness(7, 4)));
    CHECK(sharpness(5, 4) == 1.0f);
    CHECK(sharpness(4, 3) == 0.0f);
    CHECK(std::isinf(sharpness(0, 1)));  // the boundary
    CHECK(mesh.sharpness(VertexId(4)) == 3.0f);
    CHECK(mesh.sharpness(VertexId(0)) == 4.0f);
    CHECK(std::isinf(mesh.sharpness(VertexId(2))));
    CHECK(mesh.sharpness(VertexId(6)) == 0.0f);  // edge_only
    CHECK(mesh.is_hole(FaceId(3)));
    CHECK_FALSE(mesh.is_hole(FaceId(0)));
    CHECK(mesh.boundary_rule() == BoundaryRule::edge_only);
    CHECK(mesh.face_varying_rule() == FaceVaryingRule::boundaries);
    CHECK(mesh.crease_method() == CreaseMethod::chaikin);
    CHECK(mesh.has_corner_angles());
    CHECK(mesh.warnings().empty());
}

TEST_CASE("what is no surface is refused with its line, and mended on request") {
    // Three faces at an edge, one face twice, one turned over, one with an index out of range.
    const std::string text =
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 -1 0\nv 0 0 1\nv 1 1 0\n"
        "f 1 2 3\nf 2 1 4\nf 1 2 5\nf 1 2 3\nf 2 3 6\nf 1 2 9\n";
    const auto error = error_of([&] { ControlMesh::build(parse_obj(text, "bad.obj")); });
    REQUIRE(error);
    CHECK(error->code() == ErrorCode::invalid_input);
    CHECK(error->line() >= 7);
    CHECK(std::string(error->what()).starts_with("bad.obj:"));
    const ControlMesh mended = ControlMesh::build(parse_obj(text, "bad.obj", {.repair = true}));
    CHECK(mended.face_count() == 4);
    CHECK(!mended.warnings().empty());
    const Tessellation result = tessellate(mended, {.tolerance = 1e-2, .measure = false});
    CHECK(!result.mesh.triangles.empty());
}

TEST_SUITE_END();
