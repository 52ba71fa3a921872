#include "../../eval/io/gpu_mesh.hpp"
#include "../../eval/io/mesh_reader.hpp"
#include "../../eval/io/mesh_writer.hpp"
#include "../../hier/obj/obj_reader.hpp"

#include "../kit/input_helpers.hpp"
#include "../kit/meshes.hpp"
#include "../kit/scratch_dir.hpp"

#include <doctest/doctest.h>
#include <sys/resource.h>

#include <csignal>
#include <cstring>
#include <nlohmann/json.hpp>
#include <random>

using namespace tetrakis;

TEST_SUITE_BEGIN("contract");

namespace {

// A sphere with all attributes of a mesh. Coordinates use all bits of a double and a wide range of exponents.
TriangleMesh rich_mesh() {
    TriangleMesh mesh = shapes::sphere(9, 14, Vec3d(0.1, 1e-5, 1e3), 1.0 / 3);
    std::mt19937_64 random(7);
    std::uniform_real_distribution<double> unit(-1, 1);
    mesh.positions[3].x = 1e-310;  // subnormal
    mesh.positions[4].y = -0.0;
    mesh.positions[5].z = 1.7976931348623157e300;
    mesh.positions[6].z = 5e-324;
    for (int i = 0; i < 50; ++i) mesh.uvs.emplace_back(unit(random), unit(random));
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
        const auto number = [&](std::uint64_t k) { return static_cast<std::uint32_t>((t * k) % 50); };
        mesh.triangle_uvs.push_back({number(1), number(7), number(11)});
        mesh.triangle_material.push_back(t / 10 % 3);
        mesh.triangle_group.push_back(t < 40 ? 0 : 1);
        // Some corners have separate normals, as on creases.
        mesh.triangle_normals.push_back(mesh.triangles[t]);
        if (t % 5 == 0) mesh.triangle_normals.back()[t % 3] = number(1);
    }
    mesh.materials = {"brass", "blue steel", "wood"};
    mesh.groups = {"upper part", "lower"};
    return mesh;
}

TriangleMesh gltf_mesh() {  // all coordinates are in the range of floats
    TriangleMesh mesh = rich_mesh();
    const TriangleMesh plain = shapes::sphere(9, 14, Vec3d(0.1, 1e-5, 1e3), 1.0 / 3);
    mesh.positions = plain.positions;
    return mesh;
}

Vec2d uv_at(const TriangleMesh& mesh, std::size_t t, int k) { return mesh.uvs[mesh.triangle_uvs[t][k]]; }
Vec3d normal_at(const TriangleMesh& mesh, std::size_t t, int k) {
    return mesh.normals[mesh.triangle_normals.empty() ? mesh.triangles[t][k] : mesh.triangle_normals[t][k]];
}

std::string message_of(const std::filesystem::path& path, ErrorCode code = ErrorCode::invalid_input) {
    const Error error = test::error_of([&] { read_triangle_mesh(path); });
    CHECK(error.code() == code);
    return std::string(error.what()).substr(path.string().size());
}

std::string message_of_text(const ScratchDir& dir, const char* name, const std::string& text) {
    spill(dir / name, text);
    return message_of(dir / name);
}

}  // namespace

TEST_CASE(
    "faces whose corners are not all convex are cut where no triangle turns over: GLB as written, others as read") {
    const ScratchDir dir;
    // A dart whose shorter diagonal is outside, an L, and a comb that no fan covers.
    PolygonMesh mesh;
    mesh.positions = {{0, 10, 0}, {-1, 0, 0}, {0, 1, 0},  {1, 0, 0},  {4, 0, 0},  {6, 0, 0},  {6, 1, 0},  {5, 1, 0},
                      {5, 2, 0},  {4, 2, 0},  {10, 0, 0}, {16, 0, 0}, {16, 3, 0}, {15, 3, 0}, {15, 1, 0}, {14, 1, 0},
                      {14, 3, 0}, {12, 3, 0}, {12, 1, 0}, {11, 1, 0}, {11, 3, 0}, {10, 3, 0}};
    mesh.face_offsets = {0, 4, 10, 22};
    for (std::uint32_t v = 0; v < 22; ++v) mesh.face_vertices.push_back(v);
    mesh.uvs.resize(22);
    for (std::uint32_t v = 0; v < 22; ++v) mesh.uvs[v] = {mesh.positions[v].x, 0};
    mesh.face_uvs = mesh.face_vertices;
    for (const char* name : {"mesh.glb", "mesh.obj", "mesh.ply"}) {
        CAPTURE(name);
        write_mesh(dir / name, mesh);
        const TriangleMesh back = read_triangle_mesh(dir / name);
        double area = 0;  // signed: triangles that are turned over count negatively
        for (const auto& [a, b, c] : back.triangles)
            area += glm::cross(back.positions[b] - back.positions[a], back.positions[c] - back.positions[a]).z / 2;
        CHECK(area == doctest::Approx(9 + 3 + 14).epsilon(1e-6));
        REQUIRE(back.triangle_uvs.size() == back.triangles.size());
        for (std::size_t t = 0; t < back.triangles.size(); ++t)
            for (std::size_t k = 0; k < 3; ++k)
                CHECK(back.uvs[back.triangle_uvs[t][k]].x ==
                      doctest::Approx(back.positions[back.triangles[t][k]].x).epsilon(1e-6));
    }
}

TEST_CASE("OBJ and PLY give back every bit of a mesh") {
    const ScratchDir dir;
    const TriangleMesh mesh = rich_mesh();
    for (const char* name : {"mesh.obj", "mesh.ply", "MESH.PLY"}) {
        CAPTURE(name);
        write_mesh(dir / name, mesh);
        const TriangleMesh back = read_triangle_mesh(dir / name);
        CHECK(test::same_bytes(back.positions, mesh.positions));
        CHECK(back.triangles == mesh.triangles);
        CHECK(back.triangle_material == mesh.triangle_material);
        CHECK(back.materials == mesh.materials);
        CHECK(back.triangle_group == mesh.triangle_group);
        CHECK(back.groups == mesh.groups);
        REQUIRE(back.triangle_uvs.size() == mesh.triangles.size());
        for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
            for (int k = 0; k < 3; ++k) {
                REQUIRE(uv_at(back, t, k) == uv_at(mesh, t, k));
                REQUIRE(normal_at(back, t, k) == normal_at(mesh, t, k));
            }
    }
    CHECK(dir.file_count() == 3);  // no temporary file is left
}

TEST_CASE("GLB gives back the mesh to float precision about its own origin") {
    const ScratchDir dir;
    const TriangleMesh mesh = gltf_mesh();
    const Box3d box = bounding_box(mesh.positions);
    CHECK(glb_origin(box) != Vec3d(0));
    const double bound = glb_rounding_bound(box);
    CHECK(bound < 1e-7);  // 2^-24 of 1/3 in each axis; about the world's origin it would be 3e-5
    write_mesh(dir / "mesh.glb", mesh);
    const TriangleMesh back = read_triangle_mesh(dir / "mesh.glb");
    // Copies at the seams are joined again; triangles are sorted by group and material.
    REQUIRE(back.positions.size() == mesh.positions.size());
    REQUIRE(back.triangles.size() == mesh.triangles.size());
    double worst = 0;
    for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
        worst = std::max(worst, glm::length(back.positions[v] - mesh.positions[v]));
    }
    CHECK(worst <= bound);
    CHECK(worst > bound / 10);
    std::vector<std::uint32_t> order;
    for (std::uint32_t g = 0; g < 2; ++g)
        for (std::uint32_t m = 0; m < 3; ++m)
            for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t)
                if (mesh.triangle_group[t] == g && mesh.triangle_material[t] == m) order.push_back(t);
    for (std::size_t i = 0; i < order.size(); ++i) {
        REQUIRE(back.triangles[i] == mesh.triangles[order[i]]);
        REQUIRE(back.materials[back.triangle_material[i]] == mesh.materials[mesh.triangle_material[order[i]]]);
        REQUIRE(back.groups[back.triangle_group[i]] == mesh.groups[mesh.triangle_group[order[i]]]);
        for (int k = 0; k < 3; ++k) {
            REQUIRE(glm::length(uv_at(back, i, k) - uv_at(mesh, order[i], k)) < 1e-6);
            REQUIRE(glm::length(normal_at(back, i, k) - normal_at(mesh, order[i], k)) < 1e-6);
        }
    }
}

TEST_CASE("a GLB keeps the rules of its format") {
    const ScratchDir dir;
    TriangleMesh mesh = gltf_mesh();
    mesh.materials[1] =
        "Stra\xdf"
        "e";  // Latin-1, as in old OBJ files
    write_mesh(dir / "mesh.glb", mesh);
    const std::string bytes = slurp(dir / "mesh.glb");
    const auto word = [&](std::size_t at) {
        std::uint32_t value;
        std::memcpy(&value, bytes.data() + at, 4);
        return value;
    };
    REQUIRE(bytes.substr(0, 4) == "glTF");
    CHECK(word(4) == 2);
    CHECK(word(8) == bytes.size());
    REQUIRE(bytes.substr(16, 4) == "JSON");
    const std::size_t json_size = word(12), bin = 20 + json_size;
    CHECK(json_size % 4 == 0);
    REQUIRE(bytes.substr(bin + 4, 3) == "BIN");
    CHECK(word(bin) % 4 == 0);
    CHECK(bin + 8 + word(bin) == bytes.size());
    const auto json = nlohmann::json::parse(bytes.substr(20, json_size));
    CHECK(json["asset"]["version"] == "2.0");
    CHECK(json["buffers"][0]["byteLength"] == word(bin));
    CHECK(json["materials"][1]["name"] ==
          "Stra\xc3\x9f"
          "e");
    std::size_t triangles = 0;
    for (const auto& node : json["nodes"]) {
        CHECK(node["translation"].size() == 3);
        for (const auto& primitive : json["meshes"][node["mesh"].get<int>()]["primitives"]) {
            const auto& positions = json["accessors"][primitive["attributes"]["POSITION"].get<int>()];
            const auto& indices = json["accessors"][primitive["indices"].get<int>()];
            const std::size_t count = positions["count"];
            triangles += indices["count"].get<std::size_t>() / 3;
            for (const auto* accessor : {&positions, &indices}) {
                const auto& view = json["bufferViews"][(*accessor)["bufferView"].get<int>()];
                CHECK(view["byteOffset"].get<std::size_t>() % 4 == 0);
                CHECK(view["byteOffset"].get<std::size_t>() + view["byteLength"].get<std::size_t>() <= word(bin));
            }
            const auto& view = json["bufferViews"][positions["bufferView"].get<int>()];
            const std::size_t start = bin + 8 + view["byteOffset"].get<std::size_t>();
            for (int axis = 0; axis < 3; ++axis) {
                float lower = 1e30f, upper = -1e30f;
                for (std::size_t v = 0; v < count; ++v) {
                    float x;
                    std::memcpy(&x, bytes.data() + start + 12 * v + 4 * axis, 4);
                    lower = std::min(lower, x), upper = std::max(upper, x);
                }
                CHECK(positions["min"][axis].get<float>() == lower);
                CHECK(positions["max"][axis].get<float>() == upper);
            }
            const auto& index_view = json["bufferViews"][indices["bufferView"].get<int>()];
            for (std::size_t i = 0; i < indices["count"].get<std::size_t>(); ++i)
                REQUIRE(word(bin + 8 + index_view["byteOffset"].get<std::size_t>() +
                             indices["byteOffset"].get<std::size_t>() + 4 * i) < count);
        }
    }
    CHECK(triangles == mesh.triangles.size());
    // Normals whose lengths are out of the range of floats: their directions are still exported.
    for (const double length : {1e200, 1e-200, 1e-310}) {
        TriangleMesh far = shapes::octahedron();
        for (const Vec3d& p : far.positions) far.normals.push_back(length * p);
        write_mesh(dir / "far.glb", far);
        const TriangleMesh back = read_triangle_mesh(dir / "far.glb");
        REQUIRE(back.normals.size() == far.normals.size());
        for (std::size_t v = 0; v < back.normals.size(); ++v)
            CHECK(glm::distance(back.normals[v], glm::normalize(far.positions[v])) < 1e-6);
        CHECK(glm::distance(Vec3d(gpu_mesh(far).normals[1]), glm::normalize(far.positions[1])) < 1e-6);
    }
    mesh.uvs[0].x = 1e300;
    CHECK(test::error_of([&] { write_mesh(dir / "far.glb", mesh); }).code() == ErrorCode::unsupported);
    CHECK(test::error_of([&] { (void)gpu_mesh(mesh); }).code() == ErrorCode::invalid_input);
    CHECK(test::error_of([&] { (void)gpu_mesh(shapes::octahedron(), Vec3d(1e300)); }).code() ==
          ErrorCode::invalid_input);
}

TEST_CASE("a GLB of as many groups as materials takes little memory") {
    const ScratchDir dir;
    TriangleMesh mesh = shapes::octahedron();
    mesh.groups.resize(1'000'000, "g");
    mesh.materials.resize(20'000, "m");
    mesh.triangle_group.assign(mesh.triangles.size(), 999'999);
    mesh.triangle_material.assign(mesh.triangles.size(), 19'999);
    mesh.triangle_material[3] = 7;
    write_mesh(dir / "many.glb", mesh);  // a table of all pairs would be 160 GB
    CHECK(read_triangle_mesh(dir / "many.glb").triangles.size() == mesh.triangles.size());
}

TEST_CASE("a name that ends in a backslash does not join lines") {
    const ScratchDir dir;
    TriangleMesh mesh = shapes::octahedron();
    mesh.groups = {"lower", "upper\\"};
    mesh.materials = {"red\\", "blue"};
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
        mesh.triangle_group.push_back(t / 4);
        mesh.triangle_material.push_back(t % 2);
    }
    for (const char* name : {"a.obj", "a.ply"}) {
        CAPTURE(name);
        write_mesh(dir / name, mesh);
        const TriangleMesh back = read_triangle_mesh(dir / name);
        CHECK(back.triangles.size() == mesh.triangles.size());
        CHECK(back.groups == std::vector<std::string>{"lower", "upper_"});
        CHECK(back.materials == std::vector<std::string>{"red_", "blue"});
    }
}

TEST_CASE("polygons are written as polygons, and cut into triangles for GLB") {
    const ScratchDir dir;
    PolygonMesh mesh;  // a quad whose diagonals differ, and a 200-gon beside it
    mesh.positions = {{0, 0, 0}, {4, -1, 0}, {4, 1, 0}, {0, 2, 0}};
    mesh.face_offsets = {0, 4, 204};
    mesh.face_vertices = {0, 1, 2, 3};
    for (std::uint32_t i = 0; i < 200; ++i) {
        mesh.positions.push_back({10 + std::cos(i * 0.0314159), std::sin(i * 0.0314159), 0});
        mesh.face_vertices.push_back(4 + i);
    }
    mesh.uvs = {{0, 0}, {1, 0}, {1, 1}};
    for (std::uint32_t c = 0; c < 204; ++c) mesh.face_uvs.push_back(c % 3);
    mesh.materials = {"wood", "blue steel"};
    mesh.face_material = {1, 0};
    write_mesh(dir / "p.obj", mesh);
    CHECK(test::contains(slurp(dir / "p.obj"), "\nf 1/1 2/2 3/3 4/1\n"));
    const ControlMeshData control = read_obj(dir / "p.obj");
    CHECK(control.positions == mesh.positions);
    CHECK(control.face_offsets == mesh.face_offsets);
    CHECK(control.face_vertices == mesh.face_vertices);
    CHECK(control.face_uvs == mesh.face_uvs);
    REQUIRE(control.face_material.size() == 2);
    for (std::size_t face = 0; face < 2; ++face)
        CHECK(control.materials[control.face_material[face]] == mesh.materials[mesh.face_material[face]]);
    for (const char* name : {"p.obj", "p.ply", "p.glb"}) {
        CAPTURE(name);
        write_mesh(dir / name, mesh);
        const TriangleMesh back = read_triangle_mesh(dir / name);
        CHECK(back.positions.size() == 204);
        REQUIRE(back.triangles.size() == 2 + 198);
        CHECK(back.triangle_uvs.size() == 200);
    }
    // The GLB's quad is cut along the shorter diagonal.
    const TriangleMesh glb = read_triangle_mesh(dir / "p.glb");
    const auto& quad = glb.triangles[glb.materials[glb.triangle_material[0]] == "blue steel" ? 0 : 198];
    CHECK(std::count(quad.begin(), quad.end(), 0u) + std::count(quad.begin(), quad.end(), 2u) == 2);
}

TEST_CASE("[inv10] the thread count changes no byte of a file") {
    const ScratchDir dir;
    const TriangleMesh mesh = shapes::sphere(150, 300, Vec3d(0), 1.0);  // several blocks for the threads
    for (const char* extension : {".obj", ".ply", ".glb"}) {
        std::string first;
        for (const int threads : {1, 2}) {
            const RunContext context = test::with_thread_count(threads);
            write_mesh(dir / (std::string("m") + extension), mesh, context);
            const std::string bytes = slurp(dir / (std::string("m") + extension));
            if (threads == 1) first = bytes;
            CHECK(bytes == first);
        }
    }
}

TEST_CASE("text PLY, big-endian PLY and properties of other programs are read") {
    const ScratchDir dir;
    spill(dir / "a.ply",
          "ply\r\nformat ascii 1.0\r\ncomment made by hand\r\nelement vertex 4\r\nproperty float x\r\nproperty float "
          "y\r\n"
          "property float z\r\nproperty uchar red\r\nproperty float s\r\nproperty float t\r\nelement face 1\r\n"
          "property uchar flags\r\nproperty list uchar int vertex_index\r\nelement edge 1\r\nproperty int vertex1\r\n"
          "end_header\r\n0 0 0 255 0 0\r\n1 0 0 255 1 0\n+1 1 0 0 1 1\n0 1e0 0 0 0 1\n7 4 0 1 2 3\n0");
    const TriangleMesh text = read_triangle_mesh(dir / "a.ply");
    CHECK(text.triangles == std::vector<std::array<std::uint32_t, 3>>{{3, 0, 1}, {2, 3, 1}});
    CHECK(text.positions[2] == Vec3d(1, 1, 0));
    CHECK(text.triangle_uvs == text.triangles);
    CHECK(text.uvs[3] == Vec2d(0, 1));

    std::string big =
        "ply\nformat binary_big_endian 1.0\nelement face 1\nproperty list ushort uint vertex_indices\n"
        "element vertex 3\nproperty short x\nproperty double y\nproperty float z\nend_header\n";
    const auto put = [&]<class T>(T value) {
        char bytes[sizeof(T)];
        std::memcpy(bytes, &value, sizeof(T));
        for (std::size_t i = sizeof(T); i-- > 0;) big += bytes[i];
    };
    put(std::uint16_t{3});
    for (const std::uint32_t v : {2u, 1u, 0u}) put(v);
    for (int v = 0; v < 3; ++v) {
        put(static_cast<std::int16_t>(-300 * v));
        put(0.1 * v);
        put(0.5f);
    }
    spill(dir / "b.ply", big);
    const TriangleMesh back = read_triangle_mesh(dir / "b.ply");
    CHECK(back.positions[2] == Vec3d(-600, 0.2, 0.5));
    CHECK(back.triangles.front() == std::array<std::uint32_t, 3>{2, 1, 0});
    spill(dir / "b.ply", big.substr(0, big.size() - 1));
    CHECK(message_of(dir / "b.ply").find("the file") != std::string::npos);
}

TEST_CASE("OBJ as other programs write it is read") {
    const ScratchDir dir;
    spill(dir / "a.obj",
          "# comment\r\nmtllib x.mtl\r\no thing\r\nv 0 0 0 1 0.5 0.5\r\nv 1 0 0\r\n  v 1 1 0 \nv +0 1e0 0\nvt 0.5\nvt "
          "0 1 0\n"
          "vn 0 0 1\nvn 0 0 1\nusemtl red paint\nf -4/1/1 -3/2/2 \\\n -2/1/1 -1/2/1 # quad\nl 1 2\nf 5//1 1//1 2//1\nv "
          "9 9 9");
    const TriangleMesh mesh = read_triangle_mesh(dir / "a.obj");
    CHECK(mesh.positions.size() == 5);
    CHECK(mesh.triangles == std::vector<std::array<std::uint32_t, 3>>{{3, 0, 1}, {2, 3, 1}, {4, 0, 1}});
    CHECK(mesh.normals.size() == 2);
    CHECK(mesh.triangle_normals == std::vector<std::array<std::uint32_t, 3>>{{0, 0, 1}, {0, 0, 1}, {0, 0, 0}});
    CHECK(mesh.triangle_uvs.empty());  // the last face has none
    CHECK(mesh.materials == std::vector<std::string>{"red paint"});
    CHECK(mesh.groups == std::vector<std::string>{"thing"});
}

// Faults of words within a line are tested in obj_reader_test.
TEST_CASE("[bad-input] faults of OBJ files are named with their line") {
    const ScratchDir dir;
    const auto refused = [&](const std::string& text, const std::string& begins) {
        CAPTURE(text);
        CHECK(message_of_text(dir, "bad.obj", text).starts_with(begins));
    };
    const std::string points = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
    const std::string no_such = ":4: this face uses a vertex that no number can name";
    refused(points + "f 1 2\n", ":4: this face has 2 corners; complete it to three or more, or remove it");
    refused(points + "v 0 nan 0\nf 1 2 3", ":4: 'nan' in the vertex is not finite; give a finite number");
    refused(points + "f 1 2 -4\n", no_such);
    refused(points + "\nf 1 2 3\nf 1 2 9\n",
            ":6: this face uses vertex 9, but the file has 3; the file may be cut short");
    refused(points + "f 1 2 99999999999999999999\n", no_such);
    refused(points + "f 1/1 2/1 3/1\n", ":4: this face uses texture coordinate 1");
    refused(points, ": the file has no faces");
    refused("", ": the file is empty");
    CHECK(message_of(dir / "none.obj", ErrorCode::io) == ": there is no such file; check the path");
    CHECK(test::contains(message_of(dir / "none.stl", ErrorCode::unsupported), "meshes are read from"));
    std::filesystem::create_directory(dir / "dir.obj");
    CHECK(message_of(dir / "dir.obj", ErrorCode::io) == ": this is a directory; give a file");
}

TEST_CASE("[bad-input] faults of PLY files are named, and absurd counts allocate nothing") {
    const ScratchDir dir;
    const auto refused = [&](const std::string& text, const std::string& words) {
        CAPTURE(text);
        CHECK(test::contains(message_of_text(dir, "bad.ply", text), words));
    };
    const std::string xyz = "property float x\nproperty float y\nproperty float z\n";
    const std::string face = "element face 1\nproperty list uchar int vertex_indices\nend_header\n";
    const std::string ply = "ply\nformat ascii 1.0\n", vertex = ply + "element vertex 3\n" + xyz;
    const std::string points = "0 0 0\n1 0 0\n0 1 0\n", faces = vertex + face + points;
    refused(faces + "3 0 1 3\n",
            ": face 0 uses vertex 3, but there are 3 vertices (numbers start at 0); check the export");
    refused(faces + "3 0 1 -1\n", ":13: a vertex index of face 0 is no index");
    refused(faces + "2 0 1\n", ":13: face 0 has 2 corners; it needs three");
    refused(vertex + face + "0 0 0\n1 nan 0\n0 1 0\n3 0 1 2\n", ":11: y of vertex 1 is not finite");
    refused(vertex + face + "0 0 0\n1 o 0\n0 1 0\n3 0 1 2\n", ":11: this is not a number");
    refused(faces + "9999999 0 1 2\n", ":13: a list is longer than the rest of the file");
    refused(ply + "element vertex 4000000000\n" + xyz + face + points, "4000000000 elements 'vertex' do not fit");
    refused(ply + "element vertex 9999999999999999999999\n", ":3: an element line");
    refused(ply + "element vertex 5\nend_header\n", "has no properties");
    refused(ply + "element vertex 1\nproperty float x\nend_header\n0\n", "no x, y and z");
    refused(vertex + "end_header\n" + points, ": the file has no faces");
    refused(ply + "element vertex 3\nproperty flat x\n", ":4: a property has an");
    refused("ply\nelement vertex 1\nproperty list float int x\n", ":3: the count of a list");
    refused(vertex + "property float u\nproperty float s\nproperty float v\n" + face +
                "0 0 0 0 0 0\n1 0 0 0 0 0\n0 1 0 0 0 0\n3 0 1 2\n",
            "second property for what s says");
    refused(vertex + "element face 1\nproperty list uchar int vertex_index\nproperty list uchar int vertex_indices\n" +
                "end_header\n" + points + "3 0 1 2 3 0 1 2\n",
            "second property for what vertex_indices says");
    refused("plx\n", ":1: this is no PLY file");
    refused("ply\nformat binary_middle_endian 1.0\n", ":2: the format is none of");
}

TEST_CASE("[bad-input] shorter lengths and flipped bytes of a good file are read or end in an error that names it") {
    const ScratchDir dir;
    TriangleMesh mesh = shapes::octahedron();
    mesh.triangle_material.assign(8, 0);
    mesh.materials = {"m"};
    std::mt19937_64 random(99);
    for (const char* name : {"a.ply", "a.glb", "a.obj"}) {
        CAPTURE(name);
        write_mesh(dir / name, mesh);
        const std::string good = slurp(dir / name);
        const auto is_refused = [&](const std::string& bytes) {
            spill(dir / name, bytes);
            try {
                const TriangleMesh back = read_triangle_mesh(dir / name);
                for (const auto& triangle : back.triangles)
                    for (const std::uint32_t v : triangle) REQUIRE(v < back.positions.size());
            } catch (const Error& error) {
                REQUIRE(error.code() == ErrorCode::invalid_input);
                REQUIRE(error.file() == dir / name);
                REQUIRE(test::contains(error.what(), (dir / name).string()));
                return true;
            }
            return false;
        };
        std::size_t cut = 0;
        for (std::size_t length = 0; length < good.size(); ++length) cut += is_refused(good.substr(0, length));
        CHECK(cut > 0);
        if (name != std::string("a.obj")) CHECK(cut == good.size());
        int refused = 0;
        for (int i = 0; i < 200; ++i) {
            std::string bytes = good;
            for (int k = 0; k < 1 + i % 3; ++k) bytes[random() % bytes.size()] = static_cast<char>(random());
            refused += is_refused(bytes);
        }
        CHECK(refused > 10);
    }
}

TEST_CASE("[bad-input] glTF files with accessors that reach beyond their data are refused") {
    const ScratchDir dir;
    const auto gltf = [&](const std::string& accessor, const std::string& rest) {
        spill(dir / "a.gltf", R"({"asset":{"version":"2.0"},"scenes":[{"nodes":[0]}],"nodes":[)" + rest +
                                  R"(],"meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],
            "accessors":[)" + accessor +
                                  R"(],"bufferViews":[{"buffer":0,"byteLength":36}],
            "buffers":[{"byteLength":36,"uri":"data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}]})");
        return dir / "a.gltf";
    };
    const std::string good = R"({"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"})";
    const TriangleMesh mesh = read_triangle_mesh(gltf(good, R"({"mesh":0,"scale":[2,2,-2],"translation":[0,0,5]})"));
    REQUIRE(mesh.triangles.size() == 1);
    CHECK(mesh.positions[1] == Vec3d(2, 0, 5));
    CHECK(mesh.triangles[0] == std::array<std::uint32_t, 3>{0, 2, 1});  // mirrored: turned round again
    const std::string node = R"({"mesh":0})";
    CHECK(message_of(gltf(R"({"bufferView":0,"componentType":5126,"count":4,"type":"VEC3"})", node)) ==
          ": accessor 0 exceeds its buffer view");
    CHECK(message_of(gltf(R"({"bufferView":0,"componentType":5126,"count":99999999999,"type":"VEC3"})", node)) ==
          ": accessor 0 exceeds its buffer view");
    CHECK(message_of(gltf(R"({"bufferView":0,"byteOffset":4,"componentType":5126,"count":3,"type":"VEC3"})", node)) ==
          ": accessor 0 exceeds its buffer view");
    CHECK(message_of(gltf(R"({"bufferView":7,"componentType":5126,"count":3,"type":"VEC3"})", node)) ==
          ": there is no buffer view number 7; the file has 1");
    CHECK(message_of(gltf(good, R"({"mesh":3})")) == ": there is no mesh number 3; the file has 1");
    CHECK(message_of(gltf(good, R"({"mesh":0,"children":[0]})")).find("is its own ancestor") != std::string::npos);
    CHECK(message_of(gltf(R"({"bufferView":0,"componentType":5126,"count":9,"type":"SCALAR"})", node)) ==
          ": accessor 0 has the wrong type for a position");
    // The component types INT and DOUBLE, which glTF does not allow.
    for (const char* type : {"5124", "5130"})
        CHECK(message_of(gltf(
                  R"({"bufferView":0,"componentType":)" + std::string(type) + R"(,"count":1,"type":"VEC3"})", node)) ==
              ": accessor 0 has the wrong type for a position");
    std::string text = slurp(gltf(good + R"(,{"bufferView":1,"componentType":5126,"count":3,"type":"VEC3"})", node));
    const auto insert = [&](const std::string& after, const std::string& more) {
        text.insert(text.find(after) + after.size(), more);
    };
    insert(R"("POSITION":0)", R"(,"NORMAL":1)");
    insert(R"("byteLength":36})", R"(,{"buffer":1,"byteLength":36})");
    std::string nans;
    for (int i = 0; i < 12; ++i) nans += "////";
    insert("AAAAgD8AAAAA\"}", R"(,{"byteLength":36,"uri":"data:application/octet-stream;base64,)" + nans + R"("})");
    spill(dir / "nan.gltf", text);
    CHECK(message_of(dir / "nan.gltf") == ": normal 0 of accessor 1 is not finite");
}

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
    // Two substitutes for a full disk: a limit of the process's file size, and the kernel's /dev/full.
    rlimit old{};
    ::getrlimit(RLIMIT_FSIZE, &old);
    const auto old_handler = std::signal(SIGXFSZ, SIG_IGN);
    const rlimit small{10'000, old.rlim_max};
    ::setrlimit(RLIMIT_FSIZE, &small);
    for (const char* name : {"big.obj", "big.ply", "big.glb"}) {
        const Error error = test::error_of([&] { write_mesh(dir / name, mesh); });
        CHECK(error.code() == ErrorCode::io);
        CHECK(test::contains(error.what(), "File too large"));
    }
    ::setrlimit(RLIMIT_FSIZE, &old);
    std::signal(SIGXFSZ, old_handler);
    CHECK(dir.file_count() == 0);
}

TEST_SUITE_END();
