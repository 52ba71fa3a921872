#include "../../hier/mesh/mesh_repair.hpp"
#include "../../hier/obj/obj_reader.hpp"
#include "../kit/input_helpers.hpp"

#include <doctest/doctest.h>

#include <glm/geometric.hpp>

#include <algorithm>
#include <array>
#include <iterator>
#include <limits>

using namespace tetrakis;
using namespace tetrakis::test;

namespace {

const std::vector<Vec3d> k_points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, -1, 0}, {1, 1, 1}, {2, 0, 1}};

bool reports_have(const std::vector<std::string>& reports, const std::string& part) {
    return std::ranges::any_of(reports, [&](const std::string& r) { return contains(r, part); });
}

// A soup with all faults that faces and tags can have. The UV of a corner and the line and material of a face contain
// its vertex or face number, so that a shifted layer is detected.
ControlMeshData wild_soup(std::mt19937_64& random) {
    ControlMeshData data;
    const auto vertices = 4 + static_cast<std::uint32_t>(random() % 10);
    const auto faces = 1 + static_cast<std::uint32_t>(random() % 14);
    data.positions = random_points(vertices, random);
    if (random() % 4 == 0) data.positions[random() % vertices].x = std::numeric_limits<double>::quiet_NaN();
    data.face_offsets = {0};
    for (std::uint32_t f = 0; f < faces; ++f) {
        const std::uint64_t size = random() % 8 == 0 ? random() % 3 : 3 + random() % 4;
        if (f > 0 && random() % 6 == 0) {  // copy of an earlier face, rotated, perhaps reversed
            const std::uint32_t g = static_cast<std::uint32_t>(random() % f);
            std::vector<std::uint32_t> copy(data.face_vertices.begin() + data.face_offsets[g],
                                            data.face_vertices.begin() + data.face_offsets[g + 1]);
            if (!copy.empty()) std::rotate(copy.begin(), copy.begin() + (random() % copy.size()), copy.end());
            if (random() % 2 == 0) std::reverse(copy.begin(), copy.end());
            data.face_vertices.insert(data.face_vertices.end(), copy.begin(), copy.end());
        } else {
            for (std::uint64_t i = 0; i < size; ++i)
                data.face_vertices.push_back(random() % 100 == 0 ? vertices + 3
                                                                 : static_cast<std::uint32_t>(random() % vertices));
        }
        data.face_offsets.push_back(static_cast<std::uint32_t>(data.face_vertices.size()));
        data.face_lines.push_back(100 + f);
        data.face_material.push_back(f);
        data.materials.push_back(std::to_string(f));
    }
    for (std::uint32_t v = 0; v < vertices; ++v) {
        data.uvs.emplace_back(v, 0.5);
        data.vertex_lines.push_back(1 + v);
    }
    for (const std::uint32_t v : data.face_vertices) data.face_uvs.push_back(std::min(v, vertices - 1));
    for (int i = 0; i < 6; ++i) {
        const auto a = static_cast<std::uint32_t>(random() % (vertices + 1));
        const auto b = static_cast<std::uint32_t>(random() % (vertices + 1));
        data.creases.push_back({a, b, static_cast<float>(random() % 5) - 1.0f});
        data.corners.push_back({a, static_cast<float>(a) + 1.0f});
        data.holes.push_back(static_cast<std::uint32_t>(random() % (faces + 2)));
        data.hole_lines.push_back(1000 + data.holes.back());
    }
    for (int i = 0; i < 8; ++i) {  // the line encodes vertex and face
        const auto v = static_cast<std::uint32_t>(random() % (vertices + 1)),
                   f = static_cast<std::uint32_t>(random() % (faces + 1));
        data.corner_angles.push_back({v, f, random() % 8 == 0 ? -1.0 : 0.2 + 0.1 * double(random() % 3), 100 * v + f});
    }
    return data;
}

}  // namespace

TEST_SUITE_BEGIN("contract");

TEST_CASE("repair leaves no fault in any random soup, and every layer stays with its corner") {
    int with_faces = 0, with_angles = 0;
    for (const std::uint64_t seed : seeds(3))
        for (int i = 0; i < 1500; ++i) {
            CAPTURE(seed);
            CAPTURE(i);
            std::mt19937_64 random(seed * 1000003 + static_cast<std::uint64_t>(i));
            const ControlMeshData soup = wild_soup(random);
            ControlMeshData data = soup;
            repair(data);
            const auto faults = find_faults(data);
            if (data.face_offsets.size() == 1) continue;
            ++with_faces;
            if (!faults.empty()) CAPTURE(faults[0].message);
            REQUIRE(faults.empty());
            REQUIRE(repair(data).empty());  // nothing is left to do
            for (std::size_t h = 0; h < data.face_vertices.size(); ++h) {
                const std::uint32_t v = data.face_vertices[h];
                const auto old = static_cast<std::uint32_t>(data.uvs[data.face_uvs[h]].x);
                REQUIRE(data.positions[v] == soup.positions[old]);
                REQUIRE(data.vertex_lines[v] == 1 + old);
            }
            for (std::size_t f = 0; f + 1 < data.face_offsets.size(); ++f) {
                REQUIRE(data.face_lines[f] == 100 + data.face_material[f]);
                const std::uint32_t old = data.face_material[f];
                const bool was_hole = std::ranges::find(soup.holes, old) != soup.holes.end();
                const bool is_hole = std::ranges::find(data.holes, f) != data.holes.end();
                REQUIRE(was_hole == is_hole);
            }
            for (const auto& corner : data.corners)
                REQUIRE(data.vertex_lines[corner.vertex] == static_cast<std::uint64_t>(corner.sharpness));
            for (const auto& tag : data.corner_angles)
                REQUIRE(100 * (data.vertex_lines[tag.vertex] - 1) + data.face_material[tag.face] == tag.line);
            with_angles += data.corner_angles.empty() ? 0 : 1;
        }
    CHECK(with_faces > 3000);
    CHECK(with_angles > 1000);
}

TEST_CASE("repair of single faults: repeats, faces that pass a vertex twice, faces that are turned over") {
    using Faces = std::vector<std::vector<std::uint32_t>>;
    struct Row {
        Faces faces;
        std::vector<std::uint32_t> offsets;
        std::vector<std::string> reports;
    };
    // Rows of four faces get only the four vertices that these faces use.
    const Faces tetrahedron = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}};
    for (const Row& row :
         {Row{{{0, 1, 2, 2}, {0, 1, 1}, {5, 5, 3, 1, 4, 5}},
              {0, 3, 7},
              {"dropped 1 faces with fewer than three", "repeated vertices out of 2 faces"}},
          Row{{{0, 1, 2, 0, 3, 5}}, {0, 3, 6}, {"repeated vertices out of 1 faces", "split 1 vertices"}},
          Row{{{0, 2, 1}, {0, 1, 3}, {3, 2, 1}, {2, 0, 3}}, {0, 3, 6, 9, 12}, {"flipped 1 faces to orient all alike"}},
          Row{tetrahedron, {0, 3, 6, 9, 12}, {}}}) {
        CAPTURE(row.faces);
        auto data = mesh_data(k_points, row.faces);
        if (row.faces.size() == 4) data.positions.resize(4);
        const auto reports = repair(data);
        CAPTURE(reports);
        CHECK(data.face_offsets == row.offsets);
        for (const std::string& report : row.reports) CHECK(reports_have(reports, report));
        CHECK(reports.empty() == row.reports.empty());
        CHECK(find_faults(data).empty());
        // The orientation is that of most faces, and the first corner of a face stays the first.
        if (row.faces.size() == 4)
            CHECK(data.face_vertices == (row.reports.empty()
                                             ? std::vector<std::uint32_t>{0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3}
                                             : std::vector<std::uint32_t>{0, 2, 1, 0, 1, 3, 3, 1, 2, 2, 0, 3}));
    }
}

TEST_CASE("repair opens a Moebius strip and the projective plane") {
    std::vector<Vec3d> ring(10, Vec3d(0.0));
    auto strip = mesh_data(ring, {{0, 1, 6, 5}, {1, 2, 7, 6}, {2, 3, 8, 7}, {3, 4, 9, 8}, {4, 5, 0, 9}});
    REQUIRE(!find_faults(strip).empty());
    CHECK(reports_have(repair(strip), "no orientation"));
    CHECK(find_faults(strip).empty());
    auto plane = mesh_data(
        std::vector<Vec3d>(6, Vec3d(0.0)),
        {{0, 1, 2}, {0, 2, 3}, {0, 3, 4}, {0, 4, 5}, {0, 5, 1}, {1, 2, 4}, {2, 3, 5}, {3, 4, 1}, {4, 5, 2}, {5, 1, 3}});
    REQUIRE(!find_faults(plane).empty());
    repair(plane);
    CHECK(find_faults(plane).empty());
    CHECK(plane.face_offsets.size() == 11);
}

TEST_CASE("repair gives every copy of a split edge and vertex its tags, and the last tag still wins") {
    auto data = mesh_data(k_points, {{0, 1, 2}, {1, 0, 3}, {0, 1, 4}});
    data.creases = {{1, 0, 1.0f}, {0, 1, 2.5f}, {4, 6, 1.0f}};
    data.corners = {{0, 7.0f}, {6, 1.0f}};
    const auto reports = repair(data);
    CHECK(reports_have(reports, "split 1 edges of more than two faces"));
    CHECK(reports_have(reports, "dropped 1 crease tags"));
    CHECK(reports_have(reports, "dropped 1 corner tags"));
    const ControlMesh mesh = ControlMesh::build(data);
    CHECK(data.creases.size() == 6);
    CHECK(data.creases.back().sharpness == 2.5f);
    CHECK(data.corners.size() == 3);
    CHECK(mesh.edge_count() == 9);
}

TEST_CASE("repair gives the angles of corners to what is left of their faces, and drops those that contradict others") {
    // Two faces that touch in vertex 0 alone, each with an angle. The first face has a duplicate.
    auto data = mesh_data(k_points, {{0, 1, 2}, {1, 2, 0}, {0, 3, 4}});
    data.corners = {{0, 7.0f}};
    data.corner_angles = {{0, 0, 1.0}, {0, 2, 2.0}, {0, 2, 2.5}, {0, 1, 1.0}, {0, 9, 1.0}, {0, 0, 7.0}};
    const auto reports = repair(data);
    CHECK(reports_have(reports, "dropped 3 corner angle tags that name no corner of a face that is left"));
    CHECK(reports_have(reports, "(the first is tag 3)"));
    CHECK(reports_have(reports, "dropped 1 corner angle tags of sectors with another angle (the first is tag 2)"));
    REQUIRE(data.corner_angles.size() == 2);
    const ControlMesh mesh = ControlMesh::build(data);
    CHECK(mesh.corner_angle(HalfedgeId(0)) == 1.0);
    CHECK(mesh.corner_angle(HalfedgeId(3)) == 2.0);
    CHECK(mesh.origin(HalfedgeId(0)) != mesh.origin(HalfedgeId(3)));
}

TEST_CASE("repair names vertices and faces as the file does, and their lines, whatever it dropped before") {
    const std::string points = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 9 9 9\n";
    const auto warnings = parse_obj(points + "f 1 1 2\nf 1 2 3\nf 2 3 1\nf 1 2 4\nf 2 1 5\nt hole 1/0/0 77\n" +
                                        "t crease 2/1/0 0 5 2\nt corner 1/1/0 5 2\nt hole 1/0/0 2\n",
                                    "test.obj", {.repair = true})
                              .warnings;
    CHECK(reports_have(warnings,
                       "dropped 1 faces with fewer than three distinct vertices (the first is face 1 (line 7))"));
    CHECK(reports_have(warnings, "dropped 1 hole tags of faces that are not there (the first is tag 1 on line 12)"));
    CHECK(reports_have(warnings, "dropped 1 duplicate faces (the first is face 3 (line 9))"));
    CHECK(reports_have(warnings, "(the first is between vertex 1 (line 1) and vertex 2 (line 2))"));
    CHECK(reports_have(warnings,
                       "dropped 1 crease tags that name no edge or have no sharpness (the first is tag 1 on line 13)"));
    CHECK(reports_have(
        warnings,
        "dropped 1 corner tags that name no vertex of a face or have no sharpness (the first is tag 1 on line 14)"));
    CHECK(reports_have(warnings, "dropped 1 vertices that belong to no face (the first is vertex 6 (line 6))"));
}

TEST_CASE("[bad-input] repair refuses offsets that fit no faces") {
    ControlMeshData data;
    data.positions = k_points;
    data.face_offsets = {0, 9};
    data.face_vertices = {0, 1, 2};
    CHECK(contains(error_of([&] { repair(data); }).what(), "cannot be repaired"));
}

namespace {

/// A cube of six faces that share no vertices. Each has its own texture coordinates, the unit square.
ControlMeshData unwelded_cube() {
    ControlMeshData data;
    data.face_offsets = {0};
    for (const std::array<int, 4>& face :
         {std::array{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}}) {
        for (const int i : face) {
            data.face_vertices.push_back(static_cast<std::uint32_t>(data.positions.size()));
            data.face_uvs.push_back(static_cast<std::uint32_t>(data.uvs.size()));
            data.positions.emplace_back(i & 1, i >> 1 & 1, i >> 2);
            data.uvs.emplace_back(i & 1, i >> 1 & 1);
            data.vertex_lines.push_back(data.positions.size());
            data.uv_lines.push_back(100 + data.uvs.size());
        }
        data.face_offsets.push_back(static_cast<std::uint32_t>(data.face_vertices.size()));
    }
    return data;
}

std::size_t weld_warnings(const ControlMesh& mesh) {
    return static_cast<std::size_t>(
        std::ranges::count_if(mesh.warnings(), [](const std::string& w) { return contains(w, "--weld"); }));
}

}  // namespace

TEST_CASE("faces that share no vertices are a warning, and welding joins them, tags and texture coordinates too") {
    ControlMeshData data = unwelded_cube();
    data.creases = {{0, 1, 3.0f}, {20, 23, 2.0f}};  // the edge from (0 0 0) up; the one from (1 0 0) to (1 0 1)
    data.corners = {{2, 4.0f}};                     // (1 1 0)
    data.holes = {1};
    const ControlMesh pieces = ControlMesh::build(data);
    REQUIRE(pieces.warnings().size() == 1);
    CHECK(
        contains(pieces.warnings()[0], "24 of 24 boundary edges lie on one another, between 24 vertices at 8 places"));
    CHECK(find_oddities(data) == pieces.warnings());
    CHECK(weld(data) == std::vector<std::string>{"joined 24 vertices at 8 places"});
    const ControlMesh cube = ControlMesh::build(data);
    CHECK(cube.warnings().empty());
    CHECK(cube.vertex_count() == 8);
    CHECK(cube.edge_count() == 12);
    CHECK(!cube.has_boundary());
    CHECK(data.uvs.size() == 4);
    CHECK(data.uv_lines == std::vector<std::uint64_t>{101, 102, 103, 104});
    const auto at = [&](VertexId v) { return cube.position(v); };
    int creases = 0;
    for (std::uint32_t h = 0; h < cube.halfedge_count(); ++h) {
        const HalfedgeId e(h);
        CHECK(data.uvs[cube.uv_index(e)] == Vec2d(at(cube.origin(e))));
        const Vec3d middle = 0.5 * (at(cube.origin(e)) + at(cube.target(e)));
        const float wanted = middle == Vec3d(0, 0.5, 0) ? 3.0f : middle == Vec3d(1, 0, 0.5) ? 2.0f : 0.0f;
        CHECK(cube.sharpness(cube.edge(e)) == wanted);
        creases += wanted != 0;
    }
    CHECK(creases == 4);
    for (std::uint32_t v = 0; v < 8; ++v)
        CHECK(cube.sharpness(VertexId(v)) == (at(VertexId(v)) == Vec3d(1, 1, 0) ? 4.0f : 0.0f));
    CHECK(cube.is_hole(FaceId(1)));
    CHECK(weld(data).empty());
}

TEST_CASE("no warning where welding would help little or make no surface") {
    // Cases: parallel sheets, faces that would have opposite orientations, three faces at an edge.
    const auto quad = [](double z) { return std::array<Vec3d, 4>{{{0, 0, z}, {1, 0, z}, {1, 1, z}, {0, 1, z}}}; };
    std::vector<Vec3d> points;
    for (const double z : {0.0, 1.0}) std::ranges::copy(quad(z), std::back_inserter(points));
    CHECK(weld_warnings(ControlMesh::build(mesh_data(points, {{0, 1, 2, 3}, {4, 5, 6, 7}}))) == 0);
    // Both faces use the edge in the same direction: joined, they would have opposite orientations.
    CHECK(weld_warnings(ControlMesh::build(mesh_data(
              {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 0}, {1, 0, 0}, {0, -1, 0}}, {{0, 1, 2}, {3, 4, 5}}))) == 0);
    CHECK(weld_warnings(ControlMesh::build(mesh_data(
              {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 0}, {1, 0, 0}, {0, -1, 0}}, {{0, 1, 2}, {4, 3, 5}}))) == 1);
    // Vertices that repair() has split stay split.
    ControlMeshData fins = mesh_data(k_points, {{0, 1, 2}, {1, 0, 3}, {1, 0, 4}});
    CHECK(!repair(fins).empty());
    CHECK(weld_warnings(ControlMesh::build(fins)) == 0);
}

TEST_CASE("welding within a distance joins what chains of such steps reach, and nothing else") {
    std::mt19937_64 random(7);
    for (const double distance : {1e-9, 0.01, 0.05, 0.1, 3.0, 1e300}) {
        CAPTURE(distance);
        ControlMeshData data;
        data.positions = random_points(300, random);
        for (int i = 0; i < 30; ++i) data.positions[static_cast<std::size_t>(200 + i)] = data.positions[0];
        data.face_offsets = {0};
        const std::vector<Vec3d> before = data.positions;
        std::vector<std::uint32_t> set(before.size());
        for (std::uint32_t v = 0; v < set.size(); ++v) set[v] = v;
        for (bool changed = true; changed;) {  // by brute force
            changed = false;
            for (std::uint32_t a = 0; a < set.size(); ++a)
                for (std::uint32_t b = 0; b < a; ++b)
                    if (set[a] != set[b] && glm::distance(before[a], before[b]) <= distance)
                        set[a] = set[b] = std::min(set[a], set[b]), changed = true;
        }
        std::vector<Vec3d> wanted;
        for (std::uint32_t v = 0; v < set.size(); ++v)
            if (set[v] == v) wanted.push_back(before[v]);
        CHECK(weld(data, distance).size() == 1);
        CHECK(data.positions == wanted);
    }
    ControlMeshData data;
    data.face_offsets = {0};
    data.positions.assign(600, {1, 2, 3});
    CHECK(weld(data) == std::vector<std::string>{"joined 600 vertices at 1 places"});
}

TEST_CASE("corners that fall together are taken out, with faces and tags that are then nothing") {
    ControlMeshData data =
        mesh_data({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {1.001, 0, 0}, {1.001, 1, 0}, {2, 0, 0}},
                  {{0, 1, 2, 3}, {1, 4, 2}, {4, 5, 2}, {4, 6, 5}, {4, 6, 6}});
    data.materials = {"a", "b", "c", "d", "e"};
    data.face_material = {0, 1, 2, 3, 4};
    data.holes = {1, 3};
    data.creases = {{1, 4, 1.0f}, {4, 5, 2.0f}};
    const std::vector<std::string> reports = weld(data, 0.01);
    CHECK(reports_have(reports, "joined 4 vertices at 2 places"));
    CHECK(reports_have(reports, "dropped 3 faces with fewer than three corners left (the first is face 1)"));
    CHECK(reports_have(reports, "dropped 1 crease tags of edges whose ends fell together"));
    CHECK(reports_have(reports, "dropped 1 hole tags"));
    const ControlMesh mesh = ControlMesh::build(data);
    CHECK(mesh.face_count() == 2);
    CHECK(mesh.vertex_count() == 5);
    CHECK(data.face_material == std::vector<std::uint32_t>{0, 3});
    CHECK(mesh.is_hole(FaceId(1)));
    CHECK(data.creases.size() == 1);
    CHECK(mesh.edge_count() == 6);
}

TEST_CASE("[bad-input] distances to weld within") {
    for (const double distance :
         {-1.0, -1e-300, std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
        ControlMeshData data = unwelded_cube();
        const Error error = error_of([&] { weld(data, distance); });
        CHECK(error.code() == ErrorCode::invalid_input);
        CHECK(contains(error.what(), "must be 0 or more"));
        CHECK(data.positions.size() == 24);
    }
    // Random soups: welding never fails worse than with an Error, and repair() then makes them valid.
    std::mt19937_64 random(3);
    for (int i = 0; i < 200; ++i) {
        ControlMeshData data = wild_soup(random);
        weld(data, i % 2 == 0 ? 0.0 : 0.4);
        repair(data);
        if (data.face_offsets.size() > 1) CHECK(find_faults(data).empty());
    }
}

TEST_SUITE_END();
