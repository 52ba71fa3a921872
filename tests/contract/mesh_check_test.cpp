#include "../../hier/mesh/mesh_check.hpp"
#include "../../hier/mesh/control_mesh.hpp"
#include "../kit/input_helpers.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <limits>
#include <map>
#include <set>

using namespace tetrakis;
using namespace tetrakis::test;

namespace {

using Kind = MeshFaultKind;

ControlMeshData two_quads() {
    ControlMeshData data =
        mesh_data({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {0, 1, 0}, {1, 1, 0}, {2, 1, 0}}, {{0, 1, 4, 3}, {1, 2, 5, 4}});
    data.face_lines = {11, 12};
    data.vertex_lines = {1, 2, 3, 4, 5, 6};
    data.source = "quads.obj";
    return data;
}

// Checks that this is the first fault of the data, and that build() throws it with the file, its line and the advice.
void check_fault(const ControlMeshData& data, Kind kind, std::uint32_t element, std::uint64_t line,
                 const std::string& words, const std::string& advice) {
    const auto faults = find_faults(data);
    REQUIRE(!faults.empty());
    CAPTURE(faults[0].message);
    CHECK(name(faults[0].kind) == name(kind));
    CHECK(faults[0].element == element);
    CHECK(faults[0].line == line);
    CHECK(contains(faults[0].message, words));
    CHECK(contains(faults[0].message, advice));
    const Error error = error_of([&] { ControlMesh::build(data); });
    CHECK(error.code() == ErrorCode::invalid_input);
    CHECK(error.line() == line);
    CHECK(error.file() == data.source);
    CHECK(contains(error.what(), faults[0].message));
}

// A random polygon soup. Each face is valid by itself: it repeats no vertex.
ControlMeshData random_soup(std::mt19937_64& random, std::uint32_t vertices, std::uint32_t faces) {
    ControlMeshData data;
    data.positions = random_points(vertices, random);
    data.face_offsets = {0};
    for (std::uint32_t f = 0; f < faces; ++f) {
        std::vector<std::uint32_t> all(vertices);
        for (std::uint32_t v = 0; v < vertices; ++v) all[v] = v;
        std::shuffle(all.begin(), all.end(), random);
        const std::uint32_t size = 3 + static_cast<std::uint32_t>(random() % 3);
        data.face_vertices.insert(data.face_vertices.end(), all.begin(), all.begin() + size);
        data.face_offsets.push_back(static_cast<std::uint32_t>(data.face_vertices.size()));
    }
    return data;
}

// Whether this is an oriented 2-manifold, by brute force: counts directed edges, and floods each vertex's faces.
bool is_manifold(const ControlMeshData& data) {
    const std::size_t faces = data.face_offsets.size() - 1;
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::vector<std::size_t>> directed;
    for (std::size_t f = 0; f < faces; ++f) {
        const std::uint32_t first = data.face_offsets[f], size = data.face_offsets[f + 1] - first;
        for (std::uint32_t i = 0; i < size; ++i)
            directed[{data.face_vertices[first + i], data.face_vertices[first + (i + 1) % size]}].push_back(f);
    }
    std::map<std::uint32_t, std::map<std::size_t, std::set<std::size_t>>> around;
    for (const auto& [edge, users] : directed) {
        if (users.size() > 1) return false;
        for (const std::uint32_t v : {edge.first, edge.second}) around[v][users[0]];
        const auto back = directed.find({edge.second, edge.first});
        if (back == directed.end()) continue;
        for (const std::uint32_t v : {edge.first, edge.second}) around[v][users[0]].insert(back->second[0]);
    }
    for (const auto& [v, graph] : around) {
        std::set<std::size_t> seen{graph.begin()->first};
        std::vector<std::size_t> open{graph.begin()->first};
        while (!open.empty()) {
            const std::size_t f = open.back();
            open.pop_back();
            for (const std::size_t g : graph.at(f))
                if (seen.insert(g).second) open.push_back(g);
        }
        if (seen.size() != graph.size()) return false;
    }
    return true;
}

}  // namespace

TEST_SUITE_BEGIN("contract");

TEST_CASE("[bad-input] every fault of an element is found, named, located and comes with advice") {
    REQUIRE(find_faults(two_quads()).empty());
    constexpr double k_nan = std::numeric_limits<double>::quiet_NaN();
    const auto check = [](auto&& change, Kind kind, std::uint32_t element, std::uint64_t line, const char* words,
                          const char* advice = "--repair") {
        ControlMeshData data = two_quads();
        change(data);
        check_fault(data, kind, element, line, words, advice);
    };
    using Data = ControlMeshData;
    // Arrays whose sizes do not match.
    check([](Data& d) { d.face_offsets = {0}, d.face_vertices.clear(), d.face_lines.clear(); }, Kind::no_faces, 0, 0,
          "no faces", "at least one");
    check([](Data& d) { d.face_offsets.clear(), d.face_vertices.clear(), d.face_lines.clear(); }, Kind::no_faces, 0, 0,
          "no faces", "at least one");
    for (const std::vector<std::uint32_t>& offsets : {std::vector<std::uint32_t>{0, 5, 4, 8}, {0, 4, 9}})
        check([&](Data& d) { d.face_offsets = offsets; }, Kind::array_size, 0, 0, "face_offsets", "must ascend");
    check([](Data& d) { d.face_uvs = {0, 0}; }, Kind::array_size, 0, 0, "face_uvs", "one number per face corner");
    check([](Data& d) { d.face_material = {0}; }, Kind::array_size, 0, 0, "face_material", "one number per face");
    // Vertices.
    for (const double x : {k_nan, -std::numeric_limits<double>::infinity()})
        check([&](Data& d) { d.positions[3].y = x; }, Kind::non_finite_vertex, 3, 4, "vertex 3");
    check([](Data& d) { d.positions[2].z = 1.1e60; }, Kind::absurd_coordinate, 2, 3,
          "vertex 2 has a coordinate beyond 1e+60");
    ControlMeshData large = two_quads();
    large.positions[2].z = -0.9e60;
    CHECK(find_faults(large).empty());
    // Faces.
    check(
        [](Data& d) {
            d.face_vertices = {0, 1, 4, 3, 1, 2}, d.face_offsets = {0, 4, 6};
        },
        Kind::face_too_small, 1, 12, "face 1 has 2 corners", "3 or more");
    check([](Data& d) { d.face_vertices[6] = 99; }, Kind::vertex_out_of_range, 1, 12,
          "face 1 uses vertex 99, but there are 6 vertices (numbers start at 0)");
    check([](Data& d) { d.face_vertices[3] = 1; }, Kind::repeated_vertex, 0, 11, "face 0 has vertex 1 (line 2) twice");
    ControlMeshData forty = mesh_data(std::vector<Vec3d>(40, Vec3d(0.0)), {{}});
    for (std::uint32_t i = 0; i < 40; ++i) forty.face_vertices.push_back(i == 33 ? 7 : i);
    forty.face_offsets = {0, 40};
    check_fault(forty, Kind::repeated_vertex, 0, 0, "face 0 has vertex 7 twice", "--repair");
    // Layers.
    check([](Data& d) { d.uvs = {{0, 0}, {1, k_nan}}; }, Kind::non_finite_uv, 1, 0, "texture coordinate 1");
    check(
        [](Data& d) {
            d.uvs = {{0, 0}, {1, 0}}, d.face_uvs = {0, 1, 0, 1, 0, 1, 2, 0};
        },
        Kind::uv_out_of_range, 1, 12, "texture coordinate 2, but there are 2");
    check(
        [](Data& d) {
            d.normals = {{0, 0, 1}}, d.face_normals = {0, 0, 1, 0, 0, 0, 0, 0};
        },
        Kind::normal_out_of_range, 0, 11, "normal 1, but there are 1");
    check(
        [](Data& d) {
            d.materials = {"steel"}, d.face_material = {0, 1};
        },
        Kind::group_out_of_range, 1, 12, "material 1");
    check([](Data& d) { d.face_group = {3, 0}; }, Kind::group_out_of_range, 0, 11, "group 3");
    // Tags.
    check(
        [](Data& d) {
            d.creases = {{0, 1, 2.0f, 20}, {1, 6, 2.0f, 21}};
        },
        Kind::crease_tag, 1, 21, "crease tag 1 (1, 6) names a vertex", "count vertices from 0");
    check([](Data& d) { d.creases = {{0, 4, 2.0f, 21}}; }, Kind::crease_tag, 0, 21, "no face has an edge");
    check([](Data& d) { d.creases = {{1, 4, -0.5f, 21}}; }, Kind::crease_tag, 0, 21, "sharpness -0.5", "0 or more");
    check(
        [](Data& d) {
            d.creases = {{1, 4, float(k_nan), 21}};
        },
        Kind::crease_tag, 0, 21, "sharpness nan", "0 or more");
    check(
        [](Data& d) {
            d.corners = {{6, 1.0f, 30}};
        },
        Kind::corner_tag, 0, 30, "corner tag 0 (6) names a vertex", "count vertices from 0");
    check([](Data& d) { d.corners = {{5, -1.0f, 30}}; }, Kind::corner_tag, 0, 30, "sharpness -1", "0 or more");
    check(
        [](Data& d) {
            d.corner_angles = {{6, 0, 1.0, 30}};
        },
        Kind::corner_angle_tag, 0, 30, "corner angle tag 0 (vertex 6, face 0) names a vertex", "count vertices from 0");
    check(
        [](Data& d) {
            d.corner_angles = {{0, 2, 1.0, 30}};
        },
        Kind::corner_angle_tag, 0, 30, "names a face", "count faces from 0");
    check(
        [](Data& d) {
            d.corner_angles = {{0, 0, 7.0, 30}};
        },
        Kind::corner_angle_tag, 0, 30, "has 401.07", "below 360");
    check(
        [](Data& d) {
            d.holes = {1, 2}, d.hole_lines = {40, 41};
        },
        Kind::hole_tag, 1, 41, "names face 2, but there are 2", "count faces from 0");
}

TEST_CASE("[bad-input] faces that do not hang together as a surface are told apart") {
    const std::vector<Vec3d> points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, -1, 0}, {1, 1, 1}};
    check_fault(mesh_data(points, {{0, 1, 2}, {1, 0, 3}, {0, 1, 4}}), Kind::non_manifold_edge, 0, 0,
                "between vertex 0 and vertex 1 of face 0", "--repair");
    check_fault(mesh_data(points, {{0, 1, 2}, {0, 1, 3}}), Kind::opposite_orientation, 0, 0,
                "between vertex 0 and vertex 1 ", "flip one");
    // A bow-tie, and two closed fans that touch.
    check_fault(mesh_data(points, {{1, 2, 0}, {0, 3, 4}}), Kind::non_manifold_vertex, 0, 0, "2 faces at vertex 0",
                "--repair");
    std::vector<Vec3d> more = points;
    more.insert(more.end(), {{3, 0, 0}, {3, 1, 0}, {3, 0, 1}});
    check_fault(
        mesh_data(more, {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}, {0, 7, 6}, {0, 6, 8}, {6, 7, 8}, {7, 0, 8}}),
        Kind::non_manifold_vertex, 0, 0, "6 faces at vertex 0", "--repair");
    // A duplicate face that starts at another vertex.
    const auto faults = find_faults(mesh_data(points, {{0, 1, 2}, {1, 2, 3}, {2, 0, 1}}));
    REQUIRE(!faults.empty());
    CHECK(name(faults[0].kind) == "duplicate face");
    CHECK(faults[0].element == 2);
    CHECK(contains(faults[0].message, "the same vertices as face 0"));
}

TEST_CASE("faces back to back and quads that share two edges are legal") {
    const std::vector<Vec3d> points = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0.5, 0.5, 0}};
    CHECK(find_faults(mesh_data(points, {{0, 1, 2, 3}, {3, 2, 1, 0}})).empty());
    const auto valence2 = mesh_data(points, {{0, 1, 2, 4}, {0, 4, 2, 3}});  // both around vertex 4
    CHECK(find_faults(valence2).empty());
    CHECK(ControlMesh::build(valence2).valence(VertexId(4)) == 2);
}

TEST_CASE("[bad-input] an exception quotes the first faults and counts all") {
    ControlMeshData data = two_quads();
    for (std::size_t v = 0; v < 6; ++v) data.positions[v].x = std::numeric_limits<double>::infinity();
    data.face_vertices[0] = 77;
    const Error error = error_of([&] { ControlMesh::build(data); });
    CHECK(contains(error.what(), "quads.obj:1: vertex 0"));
    CHECK(contains(error.what(), "line 5: vertex 4"));
    CHECK(!contains(error.what(), "vertex 5 "));
    CHECK(contains(error.what(), "7 faults in all"));
}

TEST_CASE("find_faults agrees with brute force on random polygon soups") {
    int sound = 0, unsound = 0;
    for (const std::uint64_t seed : seeds(3))
        for (int i = 0; i < 2000; ++i) {
            CAPTURE(seed);
            CAPTURE(i);
            std::mt19937_64 random(seed * 100003 + static_cast<std::uint64_t>(i));
            const auto data = random_soup(random, 5 + static_cast<std::uint32_t>(random() % 8),
                                          1 + static_cast<std::uint32_t>(random() % 4));
            const bool expected = is_manifold(data);
            (expected ? sound : unsound)++;
            REQUIRE(find_faults(data).empty() == expected);
        }
    CHECK(sound > 500);
    CHECK(unsound > 500);
}

TEST_CASE("angles at vertices that are no corners are a warning, and have no effect") {
    auto data = two_quads();
    data.corner_angles = {{0, 0, 1.0, 30}, {1, 0, 2.0, 31}, {1, 1, 2.0, 32}};
    const ControlMesh mesh = ControlMesh::build(data);
    REQUIRE(mesh.warnings().size() == 1);
    CHECK(contains(mesh.warnings()[0], "2 of 3 corner angle tags are at vertices that are no corners"));
    CHECK(contains(mesh.warnings()[0], "(the first is at vertex 1"));
    CHECK(contains(mesh.warnings()[0], "tagged on line 31"));
    CHECK(find_oddities(data) == mesh.warnings());
    for (std::uint32_t h = 0; h < mesh.halfedge_count(); ++h)
        CHECK(mesh.corner_angle(HalfedgeId(h)) == (mesh.origin(HalfedgeId(h)) == VertexId(0) ? 1.0 : 0.0));
    data.corner_angles.erase(data.corner_angles.begin());
    CHECK(!ControlMesh::build(data).has_corner_angles());
}

TEST_CASE("harmless oddities are warnings") {
    auto data = two_quads();
    data.positions.push_back({9, 9, 9});
    data.vertex_lines.push_back(7);
    data.positions[2] = data.positions[1];
    data.positions[5] = data.positions[4];
    data.warnings = {"met before"};
    const ControlMesh mesh = ControlMesh::build(data);
    REQUIRE(mesh.warnings().size() == 3);
    CHECK(mesh.warnings()[0] == "met before");
    CHECK(contains(mesh.warnings()[1], "1 of 7 vertices belong to no face"));
    CHECK(contains(mesh.warnings()[2], "1 of 2 faces have zero area (the first is on line 12)"));
    CHECK(mesh.is_isolated(VertexId(6)));
    CHECK(find_oddities(data).size() == 2);
}

TEST_CASE("[inv10] a large mesh builds the same for any number of threads, as brute force says") {
    constexpr std::uint32_t n = 200;
    auto data = grid(n);  // large enough for several blocks
    std::mt19937_64 random(5);
    std::vector<std::uint32_t> order(data.positions.size());  // scatter the vertex numbers over all buckets
    for (std::uint32_t v = 0; v < order.size(); ++v) order[v] = v;
    std::shuffle(order.begin(), order.end(), random);
    for (std::uint32_t& v : data.face_vertices) v = order[v];
    data.creases = {{order[(n + 1) * 5 + 5], order[(n + 1) * 5 + 6], 3.0f},
                    {order[(n + 1) * 5 + 6], order[(n + 1) * 5 + 5], 12.0f},
                    {order[0], order[1], 1.5f}};

    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> directed;
    const ControlMesh one = ControlMesh::build(data, with_thread_count(1));
    for (std::uint32_t h = 0; h < one.halfedge_count(); ++h)
        directed[{one.origin(HalfedgeId(h)).value, one.target(HalfedgeId(h)).value}] = h;
    std::uint32_t edges = 0;
    for (std::uint32_t h = 0; h < one.halfedge_count(); ++h) {
        const auto back = directed.find({one.target(HalfedgeId(h)).value, one.origin(HalfedgeId(h)).value});
        const HalfedgeId twin = one.twin(HalfedgeId(h));
        REQUIRE(twin.value == (back == directed.end() ? HalfedgeId::none : back->second));
        const bool leads = !twin.valid() || h < twin.value;
        REQUIRE(one.edge(HalfedgeId(h)).value == (leads ? edges : one.edge(twin).value));
        if (leads) REQUIRE(one.edge_halfedge(EdgeId(edges++)).value == h);
    }
    CHECK(one.edge_count() == edges);
    CHECK(edges == 2 * n * (n + 1));
    const auto inner = directed.at({order[(n + 1) * 5 + 5], order[(n + 1) * 5 + 6]});
    CHECK(one.sharpness(one.edge(HalfedgeId(inner))) == k_sharpness_infinity);  // the last tag wins
    CHECK(one.sharpness(VertexId(order[0])) == k_sharpness_infinity);           // by edge_and_corner

    for (const int threads : {2, 4}) {
        const ControlMesh many = ControlMesh::build(data, with_thread_count(threads));
        bool same = many.edge_count() == one.edge_count();
        for (std::uint32_t h = 0; h < one.halfedge_count() && same; ++h)
            same = many.twin(HalfedgeId(h)) == one.twin(HalfedgeId(h)) &&
                   many.edge(HalfedgeId(h)) == one.edge(HalfedgeId(h));
        for (std::uint32_t v = 0; v < one.vertex_count() && same; ++v)
            same = many.vertex_halfedge(VertexId(v)) == one.vertex_halfedge(VertexId(v));
        CHECK(same);
    }
}

TEST_CASE("[bad-input] building respects the memory limit and can be cancelled") {
    RunContext context;
    context.max_memory_bytes = 1000;
    CHECK(error_of([&] { ControlMesh::build(grid(20), context); }).code() == ErrorCode::memory_limit);
    context.max_memory_bytes = 0;
    context.progress = [](std::string_view, double fraction) { return fraction < 0.4; };
    CHECK(error_of([&] { ControlMesh::build(grid(20), context); }).code() == ErrorCode::cancelled);
}

TEST_SUITE_END();
