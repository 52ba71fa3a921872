#include "../kit/meshes.hpp"
#include "../kit/nearest.hpp"

#include "../../hier/obj/obj_reader.hpp"
#include "../../refine/adaptive/hierarchy.hpp"
#include "../../refine/uniform/refine.hpp"

#include <doctest/doctest.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

// Compares with the points and oriented faces of three other libraries, and with limits of OpenSubdiv. Sharpness is a
// float in all of them.

using namespace tetrakis;

namespace {

// The files of tests/golden: small control meshes refined by other libraries. Its README says how they were made.
namespace golden {

/// The folder tests/golden. If it is missing: nothing, and a message that makes ctest count the case as skipped.
std::optional<std::filesystem::path> folder() {
    const std::filesystem::path path = std::filesystem::path(TETRAKIS_SOURCE_DIR) / "tests" / "golden";
    if (std::filesystem::is_directory(path)) return path;
    MESSAGE("SKIPPED: there is no folder ", path.string());
    return std::nullopt;
}

/// Files of a folder that end in `suffix`, sorted.
std::vector<std::filesystem::path> files(const std::filesystem::path& folder, const std::string& suffix) {
    std::vector<std::filesystem::path> result;
    for (const auto& entry : std::filesystem::directory_iterator(folder))
        if (entry.path().filename().string().ends_with(suffix)) result.push_back(entry.path());
    std::sort(result.begin(), result.end());
    return result;
}

std::string unzip(const std::filesystem::path& path) {
    gzFile file = gzopen(path.c_str(), "rb");
    REQUIRE(file != nullptr);
    std::string text;
    std::array<char, 1 << 16> buffer;
    int got = 0;
    while ((got = gzread(file, buffer.data(), buffer.size())) > 0)
        text.append(buffer.data(), static_cast<std::size_t>(got));
    gzclose(file);
    REQUIRE(got == 0);
    REQUIRE(!text.empty());
    return text;
}

/// Reads "<mesh>.<scheme>.<library>.L<level>.obj.gz".
PolygonMesh read_mesh(const std::filesystem::path& path) {
    ControlMeshData data = parse_obj(unzip(path), path.string());
    REQUIRE(!data.face_vertices.empty());
    PolygonMesh mesh;
    mesh.positions = std::move(data.positions);
    mesh.face_offsets = std::move(data.face_offsets);
    mesh.face_vertices = std::move(data.face_vertices);
    return mesh;
}

/// Limit position and normal of a vertex of level 2.
struct Limit {
    Vec3d at, position, normal;  ///< position on level 2, limit position, limit normal (0: unknown)
    bool iterated = false;       ///< the normal is accurate to 2e-6 only
};

/// Reads "<mesh>.<scheme>.osd.limit.txt.gz".
std::vector<Limit> read_limits(const std::filesystem::path& path) {
    std::vector<Limit> limits;
    bool iterated = false;
    std::istringstream lines(unzip(path));
    for (std::string line; std::getline(lines, line);) {
        if (line.starts_with("#")) {
            iterated = line.find("next line by iterated ring refinement") != std::string::npos;
            continue;
        }
        std::istringstream words(line);
        Limit l;
        words >> l.at.x >> l.at.y >> l.at.z >> l.position.x >> l.position.y >> l.position.z >> l.normal.x >>
            l.normal.y >> l.normal.z;
        REQUIRE(!words.fail());
        l.iterated = iterated;
        iterated = false;
        limits.push_back(l);
    }
    REQUIRE(!limits.empty());
    return limits;
}

}  // namespace golden

std::string name_of(const std::filesystem::path& mesh) { return mesh.stem().string(); }

/// Tolerances of positions, relative to the bounding box's diagonal; the measured difference is 2e-15.
constexpr double k_points_apart = 1e-13, k_limits_apart = 1e-13;
constexpr double k_normals_apart = 1e-10, k_iterated_normals_apart = 2e-6;

std::vector<std::uint32_t> from_least(std::vector<std::uint32_t> face) {
    std::rotate(face.begin(), std::min_element(face.begin(), face.end()), face.end());
    return face;
}

/// Checks for the same points, one for one, and the same oriented faces. Unused points of `theirs` do not count.
void check_same(const PolygonMesh& ours, const PolygonMesh& theirs) {
    const double diagonal = bounding_box(theirs.positions).diagonal();
    const PointMatch match(ours.positions);
    std::multiset<std::vector<std::uint32_t>> faces, expected;
    std::map<std::uint32_t, std::uint32_t> ours_of;
    std::set<std::uint32_t> taken;
    double worst = 0;
    for (const auto& face : test::faces_of(theirs)) {
        std::vector<std::uint32_t> numbers;
        for (const std::uint32_t v : face) {
            const auto [known, is_new] = ours_of.try_emplace(v, 0);
            if (is_new) {
                known->second = match.nearest(theirs.positions[v]);
                taken.insert(known->second);
                worst = std::max(worst, glm::length(ours.positions[known->second] - theirs.positions[v]));
            }
            numbers.push_back(known->second);
        }
        expected.insert(from_least(numbers));
    }
    CHECK(worst < k_points_apart * diagonal);
    CHECK(ours_of.size() == ours.positions.size());
    CHECK(taken.size() == ours.positions.size());
    for (const auto& face : test::faces_of(ours)) faces.insert(from_least(face));
    CHECK(faces == expected);
}

struct Comparison {
    const char* scheme;
    const char* file;  ///< "<scheme>.<library>"
    int per_level;     ///< levels of the other library that are one level here
    CreaseMethod creases = CreaseMethod::uniform;
};

ControlMesh load(const std::filesystem::path& path, const Comparison& with) {
    ControlMeshData data = read_obj(path);
    data.crease_method = with.creases;
    // The other two libraries have no sharp corners.
    if (!std::string(with.file).ends_with(".osd")) data.boundary_rule = BoundaryRule::edge_only;
    return ControlMesh::build(std::move(data));
}

using Accepts = std::function<bool(const ControlMesh&)>;
using Refine = std::function<PolygonMesh(const ControlMesh&, int level)>;

/// @param files  number of files that must be compared
void check_levels(
    const Comparison& with, int files, const Accepts& accepts = [](const ControlMesh&) { return true; },
    const Refine& refined = {}) {
    const auto folder = golden::folder();
    if (!folder) return;
    int compared = 0;
    for (const auto& path : golden::files(*folder / "meshes", ".obj"))
        for (int level = 1; level <= 3; ++level) {
            const std::string file = name_of(path) + "." + with.file + ".L" + std::to_string(level) + ".obj.gz";
            if (level % with.per_level != 0 || !std::filesystem::exists(*folder / file)) continue;
            const ControlMesh mesh = load(path, with);
            if (!accepts(mesh)) continue;
            CAPTURE(file);
            check_same(refined ? refined(mesh, level) : refine(mesh, with.scheme, level / with.per_level),
                       golden::read_mesh(*folder / file));
            ++compared;
        }
    CHECK(compared == files);
}

void check_limits(const Comparison& with, int files) {
    const auto folder = golden::folder();
    if (!folder) return;
    int compared = 0;
    for (const auto& path : golden::files(*folder / "meshes", ".obj")) {
        const std::string file = name_of(path) + "." + with.file + ".limit.txt.gz";
        if (!std::filesystem::exists(*folder / file)) continue;
        CAPTURE(file);
        ++compared;
        const ControlMesh mesh = load(path, with);
        const PolygonMesh level = refine(mesh, with.scheme, 2),
                          limit = refine(mesh, with.scheme, 2, {.limit = true, .normals = true});
        REQUIRE(level.positions.size() == limit.positions.size());
        REQUIRE(level.positions.size() == limit.normals.size());
        const double diagonal = bounding_box(level.positions).diagonal();
        const PointMatch match(level.positions);
        std::set<std::uint32_t> vertices;
        double level_apart = 0, limit_apart = 0, normal_apart = 0, iterated_apart = 0;
        std::size_t normals = 0;
        const std::vector<golden::Limit> theirs = golden::read_limits(*folder / file);
        for (const golden::Limit& l : theirs) {
            const std::uint32_t v = match.nearest(l.at);
            vertices.insert(v);
            level_apart = std::max(level_apart, glm::length(level.positions[v] - l.at));
            limit_apart = std::max(limit_apart, glm::length(limit.positions[v] - l.position));
            if (l.normal == Vec3d(0)) continue;
            ++normals;
            double& apart = l.iterated ? iterated_apart : normal_apart;
            apart = std::max(apart, glm::length(limit.normals[v] - l.normal));
        }
        CHECK(level_apart < k_limits_apart * diagonal);
        CHECK(limit_apart < k_limits_apart * diagonal);
        CHECK(normal_apart < k_normals_apart);
        CHECK(iterated_apart < k_iterated_normals_apart);
        CHECK(vertices.size() == theirs.size());
        CHECK(vertices.size() == level.positions.size());
        CHECK(2 * normals > theirs.size());
    }
    CHECK(compared == files);
}

bool is_closed(const ControlMesh& mesh) { return !mesh.has_boundary(); }

/// New point of each edge on level 1 of an interpolating scheme: the vertex that shares faces with both of its ends.
/// Old vertices are found by their positions and numbered as in the control mesh.
std::map<std::pair<std::uint32_t, std::uint32_t>, Vec3d> edge_points(const ControlMesh& mesh,
                                                                     const PolygonMesh& level) {
    const std::vector<Vec3d>& points = level.positions;
    const PointMatch match(points);
    std::vector<std::uint32_t> old_vertex(points.size(), mesh.vertex_count());
    for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v) {
        const std::uint32_t at = match.nearest(mesh.position(VertexId(v)));
        REQUIRE(glm::length(points[at] - mesh.position(VertexId(v))) < 1e-15);
        old_vertex[at] = v;
    }
    std::map<std::uint32_t, std::set<std::uint32_t>> ends;
    for (const auto& face : test::faces_of(level))
        for (const std::uint32_t v : face)
            for (const std::uint32_t w : face)
                if (old_vertex[v] == mesh.vertex_count() && old_vertex[w] < mesh.vertex_count())
                    ends[v].insert(old_vertex[w]);
    std::map<std::pair<std::uint32_t, std::uint32_t>, Vec3d> result;
    for (const auto& [v, both] : ends) {
        REQUIRE(both.size() == 2);
        result[{*both.begin(), *both.rbegin()}] = points[v];
    }
    REQUIRE(result.size() == mesh.edge_count());
    return result;
}

}  // namespace

TEST_SUITE_BEGIN("contract");

TEST_CASE("golden: levels are those of OpenSubdiv, with Chaikin's creases as well") {
    check_levels({"catmull-clark", "catmark.osd", 1}, 88);
    check_levels({"loop", "loop.osd", 1}, 41);
    check_levels({"bilinear", "bilinear.osd", 1}, 30);
    check_levels({"catmull-clark", "catmark-chaikin.osd", 1, CreaseMethod::chaikin}, 9);
    check_levels({"loop", "loop-chaikin.osd", 1, CreaseMethod::chaikin}, 3);
}

TEST_CASE("golden: limits and normals are those of OpenSubdiv") {
    check_limits({"catmull-clark", "catmark.osd", 1}, 30);
    check_limits({"loop", "loop.osd", 1}, 14);
}

TEST_CASE("golden: levels are those of CGAL") {
    check_levels({"catmull-clark", "catmark.cgal", 1}, 30);
    check_levels({"loop", "loop.cgal", 1}, 16);
    check_levels({"doo-sabin", "doosabin.cgal", 1}, 18);
    check_levels({"sqrt3", "sqrt3.cgal", 2}, 8);
}

TEST_CASE("golden: levels are those of OpenMesh") {
    // OpenMesh's Catmull-Clark has other rules at boundary vertices (2/3, 1/6, 1/6): there is no file of an open mesh.
    check_levels({"catmull-clark", "catmark.openmesh", 1}, 18);
    check_levels({"loop", "loop.openmesh", 1}, 16);
    check_levels({"sqrt3", "sqrt3.openmesh", 2}, 8);
    check_levels({"midedge-simplest", "midpoint.openmesh", 2}, 9);  // midpoints, joined twice
    check_levels({"modified-butterfly", "butterfly.openmesh", 1}, 10, is_closed);
}

TEST_CASE("golden: single steps of sqrt3, which hierarchies have, are those of CGAL and OpenMesh") {
    for (const char* library : {"sqrt3.cgal", "sqrt3.openmesh"})
        check_levels(
            {"sqrt3", library, 1}, 16, [](const ControlMesh&) { return true; },
            [](const ControlMesh& mesh, int level) {
                Hierarchy all = make_hierarchy(mesh, "sqrt3");
                all.refine_where(each_leaf([](const LeafView&) { return true; }), 2 * level);
                return all.to_mesh({.positions = MeshPositions::level, .level = level}).mesh;
            });
}

// OpenMesh has no rules for inner edges that end on a boundary. It uses the eight-point rule with reflected points, as
// the first Butterfly does; if the other end is an inner extraordinary vertex, it uses that vertex's rule. The rules of
// Zorin's thesis differ from this by up to 0.3.
TEST_CASE("golden: Butterfly beside boundaries is that of OpenMesh by reflection, Zorin's further inside") {
    const auto folder = golden::folder();
    if (!folder) return;
    int inside = 0, beside = 0, apart = 0;
    for (const std::string name : {"cone9_tri", "grid_tri", "pipe3_tri"}) {
        CAPTURE(name);
        const ControlMesh mesh =
            load(*folder / "meshes" / (name + ".obj"), {"modified-butterfly", "butterfly.openmesh", 1});
        const auto theirs = edge_points(mesh, golden::read_mesh(*folder / (name + ".butterfly.openmesh.L1.obj.gz"))),
                   zorin = edge_points(mesh, refine(mesh, "modified-butterfly", 1)),
                   reflected = edge_points(mesh, refine(mesh, "butterfly", 1));
        for (const auto& [ends, point] : theirs) {
            const VertexId u(ends.first), v(ends.second);
            bool boundary_edge = false;
            for (std::uint32_t h = 0; h < mesh.halfedge_count(); ++h) {
                const HalfedgeId i(h);
                if (mesh.origin(i) == u && mesh.target(i) == v) boundary_edge |= !mesh.twin(i).valid();
                if (mesh.origin(i) == v && mesh.target(i) == u) boundary_edge |= !mesh.twin(i).valid();
            }
            const auto extraordinary = [&](VertexId w) { return !mesh.is_boundary(w) && mesh.valence(w) != 6; };
            const bool is_inside = !mesh.is_boundary(u) && !mesh.is_boundary(v);
            if (boundary_edge || is_inside || extraordinary(u) || extraordinary(v)) {
                CHECK(glm::length(zorin.at(ends) - point) < 1e-14);
                ++inside;
                continue;
            }
            CHECK(glm::length(reflected.at(ends) - point) < 1e-14);
            const double distance = glm::length(zorin.at(ends) - point);
            CHECK(distance < 0.3);
            ++beside;
            apart += distance > 1e-3 ? 1 : 0;
        }
    }
    CHECK(inside == 140);
    CHECK(beside >= apart);
    CHECK(apart == 45);
}

TEST_SUITE_END();
