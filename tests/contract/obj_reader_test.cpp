#include "../../hier/obj/obj_reader.hpp"
#include "../kit/input_helpers.hpp"
#include "../kit/scratch_dir.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>

using namespace tetrakis;
using namespace tetrakis::test;

namespace {

const std::string k_square = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

ControlMeshData parse(const std::string& text, bool repair = false) {
    return parse_obj(text, "test.obj", {.repair = repair});
}

// Checks that parsing, or else building, fails with this line, these words and this advice.
void check_refused(const std::string& text, std::uint64_t line, const std::string& words, const std::string& advice) {
    CAPTURE(text);
    const Error error = error_of([&] { ControlMesh::build(parse(text)); });
    CAPTURE(error.what());
    CHECK(error.code() == ErrorCode::invalid_input);
    CHECK(error.line() == line);
    CHECK(error.file() == "test.obj");
    const std::string place = line ? std::to_string(line) + ": " : std::string(" ");
    CHECK(std::string(error.what()).starts_with(std::string("test.obj:") + place));
    CHECK(contains(error.what(), words));
    CHECK(contains(error.what(), advice));
}

// A valid file with all kinds of lines.
const std::string k_good =
    "\xEF\xBB\xBF# comment \\\nmtllib a.mtl\no Sphere\xE4\r\nv 0 0 0 1\r\nv\t+1.5e0 0 -0.25 1.0 0.5 0.5 0.5\nv 1. 1 0\n"
    "v .0 1 0 0.1 0.2 0.3\nv 2 0.1 1e-3\nv 2 1 0\nvt 0 0\nvt 1 0 0\nvt 1 1\nvt 0\nvn 0 0 1\ng left hand side\nusemtl "
    "red metal\ns 1\n"
    "f 1/1/1 2/2/1 3/3/1 \\\n 4/4/1\ng\tright\nusemtl blue\nf -5//-1 -2//-1 -1//1 3//1 # end\n"
    "t crease 2/1/0 1 2 2.5\nt corner 2/2/0 0 3 1.5 20\nt hole 1/0/0 1\nt interpolateboundary 1/0/0 2\n"
    "t facevaryinginterpolateboundary 1/0/0 5\nt creasemethod 0/0/1 chaikin\nt smoothtriangles 1/0/0 1\n"
    "t cornerangle 4/2/0 3 0 3 0 112.5 112.5";

// Whether reading this text ends with data or with an Error that has advice.
bool survives(const std::string& text) {
    for (const bool repair : {false, true}) {
        try {
            ControlMesh::build(parse(text, repair));
        } catch (const Error& error) {
            if (std::strlen(error.what()) < 10) return false;
        }
    }
    return true;
}

}  // namespace

TEST_SUITE_BEGIN("contract");

TEST_CASE("an OBJ file with every kind of line is read as written") {
    const ControlMeshData data = parse(k_good);
    CHECK(data.positions.size() == 6);
    CHECK(data.positions[1] == Vec3d(1.5, 0, -0.25));
    CHECK(data.positions[4] == Vec3d(2, 0.1, 1e-3));
    CHECK(data.vertex_lines == std::vector<std::uint64_t>{4, 5, 6, 7, 8, 9});
    CHECK(data.face_offsets == std::vector<std::uint32_t>{0, 4, 8});
    CHECK(data.face_vertices == std::vector<std::uint32_t>{0, 1, 2, 3, 1, 4, 5, 2});
    CHECK(data.face_lines == std::vector<std::uint64_t>{18, 22});
    REQUIRE(data.uvs.size() == 5);  // the fifth for the corners that have none
    CHECK(data.uvs[3] == Vec2d(0, 0));
    CHECK(data.face_uvs == std::vector<std::uint32_t>{0, 1, 2, 3, 4, 4, 4, 4});
    CHECK(data.normals.size() == 1);
    CHECK(data.face_normals == std::vector<std::uint32_t>(8, 0));
    CHECK(data.groups == std::vector<std::string>{"left hand side", "right"});
    CHECK(data.face_group == std::vector<std::uint32_t>{0, 1});
    CHECK(data.materials == std::vector<std::string>{"red metal", "blue"});
    CHECK(data.face_material == std::vector<std::uint32_t>{0, 1});
    REQUIRE(data.creases.size() == 1);
    CHECK(data.creases[0].a == 1);
    CHECK(data.creases[0].b == 2);
    CHECK(data.creases[0].sharpness == 2.5f);
    CHECK(data.creases[0].line == 23);
    REQUIRE(data.corners.size() == 2);
    CHECK(data.corners[1].vertex == 3);
    CHECK(data.corners[1].sharpness == 20.0f);
    CHECK(data.holes == std::vector<std::uint32_t>{1});
    CHECK(data.hole_lines == std::vector<std::uint64_t>{25});
    REQUIRE(data.corner_angles.size() == 2);
    CHECK(data.corner_angles[1].vertex == 3);
    CHECK(data.corner_angles[1].face == 0);
    CHECK(data.corner_angles[1].angle == 112.5 * std::numbers::pi / 180);
    CHECK(data.corner_angles[1].line == 30);
    CHECK(data.boundary_rule == BoundaryRule::edge_only);
    CHECK(data.face_varying_rule == FaceVaryingRule::linear_all);
    CHECK(data.crease_method == CreaseMethod::chaikin);
    REQUIRE(data.warnings.size() == 3);
    CHECK(contains(data.warnings[0],
                   "vertex colours are not carried over (2 vertices have one, the first is on line 5)"));
    CHECK(contains(data.warnings[1], "'t smoothtriangles' ignored (the first is line 29)"));
    CHECK(contains(data.warnings[2], "4 of 8 face corners have no texture coordinate"));
    const ControlMesh mesh = ControlMesh::build(data);
    CHECK(mesh.is_hole(FaceId(1)));
    CHECK(mesh.has_uvs());
}

TEST_CASE("any white space stands between the numbers of OBJ") {
    const ControlMeshData data = parse_obj(
        "v 0\v0 0\nv 1\f0\t0\nv 0 1 0\nvt\v0.25\v0.5\nvt 0.75 \f0.5\nvn 0\v0\f1\nf 1/1/1\v2/2/1 3/2/1\n", "blanks.obj");
    CHECK(data.positions[1] == Vec3d(1, 0, 0));
    CHECK(data.uvs == std::vector<Vec2d>{{0.25, 0.5}, {0.75, 0.5}});
    CHECK(data.normals == std::vector<Vec3d>{{0, 0, 1}});
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

TEST_CASE("positions are correctly rounded") {
    const std::vector<double> values = {0.1, 1.0 / 3.0, 123456.789012345, 2.2250738585072014e-308, 4.9e-324, -7e22};
    std::string text;
    char buffer[64];
    for (const double x : values) {
        std::snprintf(buffer, sizeof buffer, "v %.17g 0 1e-400\n", x);
        text += buffer;
    }
    const ControlMeshData data = parse(text + "f 1 2 3\n");
    for (std::size_t i = 0; i < values.size(); ++i) CHECK(data.positions[i].x == values[i]);
    CHECK(data.positions[0].z == 0.0);
}

TEST_CASE("line ends may be LF, CR LF or CR, and the last one may be missing") {
    std::string good = k_square + "f 1 2 3 4";
    for (const std::string end : {"\n", "\r\n", "\r"}) {
        std::string text;
        for (const char c : good) text += c == '\n' ? end : std::string(1, c);
        const ControlMeshData data = parse(text);
        CHECK(data.face_vertices.size() == 4);
        CHECK(data.face_lines == std::vector<std::uint64_t>{5});
        CHECK(parse(text + end).face_vertices.size() == 4);
    }
}

TEST_CASE("names that are no UTF-8 are taken as Latin-1, others are kept") {
    const ControlMeshData data =
        parse(k_square + "usemtl K\xF6rper\nf 1 2 3\nusemtl K\xC3\xB6rper\nf 1 3 4\nusemtl \xE2\x82\xAC#1\nf 1 2 3\n");
    CHECK(data.materials == std::vector<std::string>{"K\xC3\xB6rper", "\xE2\x82\xAC#1"});
    CHECK(data.face_material == std::vector<std::uint32_t>{0, 0, 1});
}

TEST_CASE("a face of 300 corners, a very long line and a face over many lines are whole") {
    std::string points, face = "f", broken = "f";
    for (int i = 1; i <= 300; ++i) {
        points.append("v ").append(std::to_string(std::cos(i * 0.02))).append(" ");
        points.append(std::to_string(std::sin(i * 0.02))).append(" 0\n");
        face.append(" ").append(std::to_string(i));
        broken.append(" \\\n").append(std::to_string(i));
    }
    for (const std::string& line : {face, broken}) {
        const ControlMesh mesh = ControlMesh::build(parse(points + line + "\n"));
        CHECK(mesh.face_size(FaceId(0)) == 300);
        for (std::uint32_t i = 0; i < 300; ++i) REQUIRE(mesh.origin(HalfedgeId(i)).value == i);
    }
    std::string huge = "f";  // one line of 1.3 MB
    std::string many;
    for (int i = 1; i <= 200000; ++i) {
        many.append("v ").append(std::to_string(i)).append(" 0 0\n");
        huge.append(" ").append(std::to_string(i));
    }
    CHECK(parse(many + huge).face_vertices.size() == 200000);
}

TEST_CASE("crease tags are pairs of vertices, with one sharpness or one for each") {
    const auto sharpness = [](const std::string& tag) {
        std::string text;
        for (const auto& crease : parse(k_square + "f 1 2 3 4\n" + tag + "\n").creases)
            text += std::to_string(crease.a) + std::to_string(crease.b) + ":" +
                    std::to_string(static_cast<int>(crease.sharpness)) + " ";
        return text;
    };
    CHECK(sharpness("t crease 4/1/0 0 1 2 3 5") == "01:5 23:5 ");
    CHECK(sharpness("t crease 4/2/0 0 1 2 3 5 6") == "01:5 23:6 ");
    CHECK(sharpness("t crease 4/4/0 0 1 2 3 5 6 7 8") == "01:5 23:7 ");
    CHECK(parse(k_square + "f 1 2 3 4\nt crease 2/1/0 0 1 inf\n").creases[0].sharpness == k_sharpness_infinity);
    CHECK(parse(k_square + "f 1 2 3 4\nt crease 2/1/0 0 1 1e300\n").creases[0].sharpness == k_sharpness_infinity);
}

TEST_CASE("[bad-input] every malformed line is refused with file, line and advice") {
    check_refused("", 0, "empty", "give an OBJ file");
    check_refused(" \r\n\t\n", 0, "empty", "give an OBJ file");
    check_refused("# nothing\n", 0, "no faces", "at least one");
    check_refused(k_square, 0, "no faces", "at least one");
    check_refused(k_square + std::string("vf 1 2 3\n"), 0, "no faces", "vf");
    check_refused(std::string("v 0 0 0\nf\0 1", 12), 2, "zero byte", "give an OBJ file");
    check_refused("v 0 0 0\nv 1 2\n", 2, "has 2 coordinates", "complete the line");
    check_refused("v 0 0 0\nv\n", 2, "has 0 coordinates", "complete the line");
    check_refused("v 0 0 zero\n", 1, "'zero' in the vertex is no number", "correct the line");
    check_refused("v 0 0 0,5\n", 1, "'0,5'", "write a decimal point");
    check_refused("v 0 0 0x10\n", 1, "'0x10'", "correct the line");
    check_refused("v 0 0 0 1 1 1 1 1 1\n", 1, "more than 8 numbers", "correct the line");
    check_refused("v 0 0 +-1\n", 1, "'+-1'", "correct the line");
    check_refused(k_square + "vn 0 1\n", 5, "the normal has 2", "complete the line");
    check_refused(k_square + "vt\n", 5, "texture coordinate has 0", "complete the line");
    check_refused(k_square + "f 1 2 x\n", 5, "'x' is no face corner", "v/vt/vn");
    check_refused(k_square + "f 1 2 3.5\n", 5, "'3.5' is no face corner", "v/vt/vn");
    check_refused(k_square + "f 1 2 3/1/1/1\n", 5, "'3/1/1/1' is no face corner", "v/vt/vn");
    check_refused(k_square + "f 1 2 /3\n", 5, "'/3' is no face corner", "v/vt/vn");
    check_refused(k_square + "f 0 1 2\n", 5, "vertex number 0", "counts from 1");
    check_refused(k_square + "f 1/0 2 3\n", 5, "texture coordinate number 0", "counts from 1");
}

TEST_CASE("[bad-input] what the reader leaves to the check is reported with its line") {
    for (const char* odd : {"nan", "-NaN", "inf", "-inf", "1e999", "1.#IND", "-1.#INF", "1.#QNAN", "nan(ind)"})
        check_refused(k_square + "v 0 " + odd + " 0\nf 1 2 3\n", 5, "vertex 5 has a coordinate", "--repair");
    check_refused(k_square + "f 1 2 3\nf\n", 6, "face 2 has 0 corners", "--repair");
    check_refused(k_square + "f 1 2 5\n", 5, "face 1 uses vertex 5, but there are 4 vertices (numbers start at 1)",
                  "--repair");
    check_refused(k_square + "f 1 2 -5\n", 5, "face 1 uses a vertex that no number can name", "--repair");
    check_refused(k_square + "f 1 2 99999999999999999999\n", 5, "a vertex that no number can name", "--repair");
    check_refused(k_square + "f 1 2 3 4\nt hole 1/0/0 -1\n", 6, "names face a number below 0", "--repair");
    check_refused(k_square + "f 1 2 3 4\nt corner 1/1/0 3000000000000 2\n", 6, "too large for any mesh", "--repair");
    check_refused(k_square + "vt 0 0\nf 1/1 2/1 3/2\n", 6, "texture coordinate 2, but there are 1 (numbers start at 1)",
                  "--repair");
    check_refused(k_square + "vt 0 0\nf 1/1 2/2 3\n", 6, "texture coordinate 2, but there are 1", "--repair");
    check_refused(k_square + "vt 0 0\nf 1/-2 2/1 3/1\n", 6, "texture coordinate", "--repair");
    check_refused(k_square + "vt 0 0\nvt 1e45 0\nf 1/1 2/2 3/1\n", 6, "texture coordinate 2 is not finite or beyond",
                  "--repair");
    check_refused(k_square + "vn 0 0 1\nf 1//1 2//1 3//2\n", 6, "normal 2, but there are 1 (numbers start at 1)",
                  "--repair");
    check_refused(k_square + "f 1 2 3\nf 2 3 1\n", 6, "face 2 has the same vertices as face 1 (line 5)", "--repair");
    check_refused(k_square + "v 0 0 1\nf 1 2 3\nf 2 1 4\nf 1 2 5\n", 6,
                  "the edge between vertex 1 (line 1) and vertex 2 (line 2) of face 1 has more than two faces",
                  "--repair");
    check_refused(k_square + "f 1 2 3\nf 1 2 4\n", 5,
                  "between vertex 1 (line 1) and vertex 2 (line 2) (one is face 1) run along it in the same direction",
                  "--repair");
    check_refused(k_square + "v 5 5 5\nf 1 2 3\nf 1 4 5\n", 1,
                  "the 2 faces at vertex 1 are not one fan, they only touch there (one is face 2 (line 7))",
                  "--repair");
}

TEST_CASE("[bad-input] tags that make no sense are refused with their line") {
    const std::string mesh = k_square + "f 1 2 3 4\n";
    check_refused(mesh + "t\n", 6, "no name", "t crease 2/1/0");
    check_refused(mesh + "t crease\n", 6, "counts", "ints/reals/strings");
    check_refused(mesh + "t crease 2/1 0 1 2\n", 6, "counts", "ints/reals/strings");
    check_refused(mesh + "t crease 2/-1/0 0 1 2\n", 6, "counts", "ints/reals/strings");
    check_refused(mesh + "t crease 2/1/0 0 1\n", 6, "ends before the reals", "promise");
    check_refused(mesh + "t crease 4000000000/1/0 0 1 2\n", 6, "ends before the", "promise");
    check_refused(mesh + "t crease 2/1/0 0 1 2 3\n", 6, "goes on with '3'", "promise");
    check_refused(mesh + "t crease 2/1/0 0 a 2\n", 6, "'a'", "no integer");
    check_refused(mesh + "t crease 2/1/0 0 1 sharp\n", 6, "'sharp'", "no number");
    check_refused(mesh + "t crease 3/1/0 0 1 2 5\n", 6, "pairs of vertices", "not 3");
    check_refused(mesh + "t crease 4/3/0 0 1 2 3 5 5 5\n", 6, "1 sharpness or one for each", "not 3");
    check_refused(mesh + "t crease 2/1/0 0 2 5\n", 6,
                  "crease tag 1 (0, 2): no face has an edge between vertex 1 (line 1) and vertex 3 (line 3)", "from 0");
    check_refused(mesh + "t crease 2/1/0 0 -1 5\n", 6, "a vertex that is not there", "from 0");
    check_refused(mesh + "t crease 2/1/0 3 4 5\n", 6, "the last of 4 is 3", "from 0");
    check_refused(mesh + "t corner 0/1/0 5\n", 6, "at least one vertex", "at least one vertex");
    check_refused(mesh + "t corner 1/2/0 0 5 5\n", 6, "1 sharpness or one for each", "not 2");
    check_refused(mesh + "t cornerangle 1/1/0 0 90\n", 6, "pairs of a vertex and a face", "not 1");
    check_refused(mesh + "t cornerangle 4/3/0 0 0 1 0 9 9 9\n", 6, "1 angle or one for each", "not 3");
    check_refused(mesh + "t cornerangle 2/1/0 4 0 90\n", 6, "a vertex that is not there, the last of 4 is 3", "from 0");
    check_refused(mesh + "t cornerangle 2/1/0 -1 0 90\n", 6, "vertex a number below 0", "--repair");
    for (const char* angle : {"0", "-90", "180", "360", "400", "nan"})
        check_refused(mesh + "t cornerangle 2/1/0 0 0 " + angle + "\n", 6, "above 0 and below 360, and not 180",
                      "--repair");
    check_refused(mesh + "v 2 0 0\nf 2 5 3\nt cornerangle 2/1/0 0 1 90\n", 8,
                  "face 2 (line 7) does not touch vertex 1 (line 1)", "from 0");
    check_refused(mesh + "t cornerangle 2/1/0 0 0 90\nt cornerangle 4/2/0 1 0 0 0 80 91\n", 7,
                  "corner angle tag 3 (vertex 0, face 0) has 91 degrees, but tag 1 (line 6) has 90 for the same sector",
                  "--repair");
    check_refused(mesh + "t hole 0/0/0\n", 6, "at least one face", "at least one face");
    check_refused(mesh + "t interpolateboundary 1/0/0 3\n", 6, "one integer", "2 edge only");
    check_refused(mesh + "t facevaryinginterpolateboundary 1/0/0 6\n", 6, "one integer", "5 linear");
    check_refused(mesh + "t creasemethod 0/0/1 smooth\n", 6, "one word", "normal or chaikin");
}

TEST_CASE("[bad-input] files that cannot be read say why") {
    const auto folder = std::filesystem::temp_directory_path();
    const Error directory = error_of([&] { read_obj(folder); });
    CHECK(directory.code() == ErrorCode::io);
    CHECK(contains(directory.what(), "this is a directory; give a file"));
    const Error missing = error_of([&] { read_obj(folder / "there is no such mesh.obj"); });
    CHECK(missing.code() == ErrorCode::io);
    CHECK(contains(missing.what(), "there is no such mesh.obj: there is no such file; check the path"));
    const Error nowhere = error_of([&] { load_control_mesh(""); });
    CHECK(nowhere.code() == ErrorCode::io);
}

TEST_CASE("reading ends where its progress is refused, and before a file larger than the memory limit") {
    std::string text = k_square;
    while (text.size() < (std::size_t{2} << 20)) text += "v 0 0 0\n";
    int reports = 0;
    RunContext context;
    context.progress = [&](std::string_view stage, double done) {
        CHECK(stage == "load");
        CHECK(done <= 1);
        return ++reports < 1;
    };
    CHECK(error_of([&] { parse_obj(text, "test.obj", {}, context); }).code() == ErrorCode::cancelled);
    CHECK(reports == 1);
    const ScratchDir folder;
    const auto path = folder / "large.obj";
    std::ofstream(path) << text;
    context = {};
    context.max_memory_bytes = 1 << 20;
    CHECK(error_of([&] { read_obj(path, {}, context); }).code() == ErrorCode::memory_limit);
}

TEST_CASE("what is left out or filled in is a warning") {
    const ControlMeshData data =
        parse(k_square + "v 0 0 0 2\nv 0 0 0 1 5\nvn 0 0 1\ncurv 1\ncurv 2\nl 1 2\nf 1//1 2//1 3\n");
    CHECK(data.normals.empty());
    REQUIRE(data.warnings.size() == 5);
    CHECK(contains(data.warnings[0], "1 vertices have a weight other than 1 (the first is on line 5)"));
    CHECK(contains(data.warnings[1], "a weight or a colour or both (the first is on line 6)"));
    CHECK(contains(data.warnings[2], "2 lines of kind 'curv' ignored (the first is line 8)"));
    CHECK(contains(data.warnings[3], "1 line of kind 'l' ignored"));
    CHECK(contains(data.warnings[4], "1 of 3 face corners have no normal"));
    const ControlMesh mesh = ControlMesh::build(data);
    CHECK(mesh.warnings().size() == 6);
}

TEST_CASE("repair while reading reports each repair") {
    const ControlMeshData data = parse(k_square + "v 0 nan 0\nf 1 2 3\nf 2 3 1\nf 1 3 5\nf 3 4\nf 1 2 -9\n", true);
    CHECK(data.face_offsets.size() == 2);
    CHECK(find_faults(data).empty());
    CHECK(data.warnings.size() == 4);
    for (const std::string& warning : data.warnings) CHECK(warning.starts_with("repaired: dropped "));
}

TEST_CASE("[bad-input] every shorter length of a good file ends in a mesh or an error") {
    REQUIRE(survives(k_good));
    for (std::size_t length = 0; length < k_good.size(); ++length) {
        CAPTURE(length);
        // A separate copy, so that the sanitizers detect reads past its end.
        REQUIRE(survives(std::string(k_good.data(), length)));
    }
}

TEST_CASE("[bad-input] random bytes in a good file end in a mesh or an error") {
    const std::string spice = "0123456789-+./ \t\r\n\\#evtfnicrs,\xff";
    for (const std::uint64_t seed : seeds(4))
        for (int i = 0; i < 500; ++i) {
            CAPTURE(seed);
            CAPTURE(i);
            std::mt19937_64 random(seed * 7919 + static_cast<std::uint64_t>(i));
            std::string text = k_good;
            for (std::uint64_t changes = 1 + random() % 6; changes > 0; --changes) {
                const std::size_t at = random() % text.size();
                switch (random() % 3) {
                    case 0:
                        text[at] = spice[random() % spice.size()];
                        break;
                    case 1:
                        text.erase(at, 1 + random() % 4);
                        break;
                    default:
                        text.insert(
                            at, 1,
                            static_cast<char>(random() % 8 == 0 ? random() % 256 : spice[random() % spice.size()]));
                }
            }
            REQUIRE(survives(text));
        }
}

TEST_SUITE_END();
