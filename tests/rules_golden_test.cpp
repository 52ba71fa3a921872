#include "golden_mesh.hpp"
#include "point_match.hpp"
#include "shared_data.hpp"

#include "tetrakis/hier/error.hpp"
#include "tetrakis/hier/obj_reader.hpp"
#include "tetrakis/refine/rule_refinement.hpp"

#include <doctest/doctest.h>

#include <map>
#include <set>
#include <string>

using namespace tetrakis;

namespace {

/// A scheme as a library knows it, and at which of its levels.
struct Peer {
    const char* scheme;
    const char* file;  ///< "<scheme>.<library>"
    int level, steps;  ///< the library's level is this many steps of ours
};
constexpr Peer k_peers[] = {
    {"catmull-clark", "catmark.osd", 1, 1},
    {"catmull-clark", "catmark.osd", 3, 3},
    {"loop", "loop.osd", 1, 1},
    {"loop", "loop.osd", 3, 3},
    {"catmull-clark", "catmark.cgal", 1, 1},
    {"catmull-clark", "catmark.cgal", 2, 2},
    {"catmull-clark", "catmark.openmesh", 1, 1},
    {"catmull-clark", "catmark.openmesh", 2, 2},
    {"loop", "loop.cgal", 1, 1},
    {"loop", "loop.cgal", 2, 2},
    {"loop", "loop.openmesh", 1, 1},
    {"loop", "loop.openmesh", 2, 2},
    {"doo-sabin", "doosabin.cgal", 1, 1},
    {"doo-sabin", "doosabin.cgal", 2, 2},
    {"sqrt3", "sqrt3.cgal", 2, 1},
    {"sqrt3", "sqrt3.openmesh", 2, 1},
    {"bilinear", "bilinear.osd", 1, 1},
    {"bilinear", "bilinear.osd", 2, 2},
    {"midedge-simplest", "midpoint.openmesh", 2, 1},  // joining midpoints twice
    {"modified-butterfly", "butterfly.openmesh", 1, 1},
    {"modified-butterfly", "butterfly.openmesh", 2, 2},
};

bool has_boundary(const ControlMesh& mesh) {
    const RuleMesh rules = rule_mesh(mesh);
    for (int h = 0; h < rules.halfedge_count(); ++h)
        if (rules.twin(h) == RuleMesh::none) return true;
    return false;
}

}  // namespace

TEST_SUITE_BEGIN("refine");

TEST_CASE("[golden] the schemes' rules give the points and faces of three other libraries") {
    const auto golden = shared_data::folder("reference/golden"), meshes = shared_data::folder("reference/meshes");
    if (!golden || !meshes) return;
    std::map<std::string, int> compared;
    for (const auto& path : shared_data::files(*meshes, ".obj"))
        for (const Peer& peer : k_peers) {
            const std::string name = path.stem().string();
            const std::string file = name + "." + peer.file + ".L" + std::to_string(peer.level) + ".obj.gz";
            if (!std::filesystem::exists(*golden / file)) continue;
            INFO(file);
            ControlMeshData data = read_obj(path);
            // The two others do not know corners.
            if (file.find(".osd.") == std::string::npos) data.boundary_rule = BoundaryRule::edge_only;
            const ControlMesh mesh = ControlMesh::build(std::move(data));
            bool holes = false;
            for (std::uint32_t f = 0; f < mesh.face_count(); ++f) holes = holes || mesh.is_hole(FaceId(f));
            if (holes || mesh.boundary_rule() == BoundaryRule::none) continue;
            // OpenMesh has its own ways beside boundaries: Catmull-Clark's vertices there get 2/3, 1/6, 1/6; Butterfly,
            // see below.
            const std::string scheme = peer.scheme, of = peer.file;
            if (of.ends_with(".openmesh") && (scheme == "modified-butterfly" || scheme == "catmull-clark") &&
                has_boundary(mesh))
                continue;
            const PolygonMesh ours = refine_by_rules(mesh, *find_scheme(peer.scheme), peer.steps);
            const GoldenMesh theirs = read_golden(*golden / file);
            const double tolerance = 1e-12 * bounding_box(theirs.points).diagonal();
            const PointMatch match(ours.positions);
            REQUIRE(ours.face_count() == theirs.faces.size());
            std::multiset<std::vector<std::uint32_t>> faces, expected;
            double worst = 0;
            for (const auto& face : theirs.faces) {
                std::vector<std::uint32_t> numbers;
                for (const std::uint32_t v : face) {
                    numbers.push_back(match.nearest(theirs.points[v]));
                    worst = std::max(worst, glm::length(ours.positions[numbers.back()] - theirs.points[v]));
                }
                expected.insert(rotated(numbers));
            }
            for (std::uint32_t f = 0; f < ours.face_count(); ++f)
                faces.insert(rotated({ours.face_vertices.begin() + ours.face_offsets[f],
                                      ours.face_vertices.begin() + ours.face_offsets[f + 1]}));
            CHECK(worst < tolerance);
            CHECK(faces == expected);
            ++compared[peer.file];
        }
    for (const Peer& peer : k_peers) {
        CAPTURE(peer.file);
        CHECK(compared[peer.file] >= 3);
    }
}

// Traced edge by edge: OpenMesh 9.0 knows no rule for edges that end on a boundary. It takes the eight-point rule
// there, points beyond the boundary by reflection, whatever the number of triangles at the boundary vertex, and the
// rule of the extraordinary vertex where the other end is one inside the mesh. That is the original Butterfly with
// reflection, and not the rules of Zorin's thesis (crease neighbours, regular and not), which differ from it by up to
// 0.3 here; those give C1 boundaries, and the scheme's own analysis and its tests of quadratic reproduction
// (butterfly_rules_test.cpp), where the reflection fails, speak for ours.
TEST_CASE("[golden] Butterfly beside boundaries: OpenMesh's is the reflection, ours the rules of the thesis") {
    const auto golden = shared_data::folder("reference/golden"), meshes = shared_data::folder("reference/meshes");
    if (!golden || !meshes) return;
    int beside_regular = 0, beside_extraordinary = 0, inside = 0;
    for (const std::string name : {"cone9_tri", "grid_tri", "pipe3_tri"}) {
        CAPTURE(name);
        ControlMeshData data = read_obj(*meshes / (name + ".obj"));
        data.boundary_rule = BoundaryRule::edge_only;
        const ControlMesh mesh = ControlMesh::build(std::move(data));
        const RuleMesh rules = rule_mesh(mesh);
        const PolygonMesh thesis = refine_by_rules(mesh, *find_scheme("modified-butterfly"), 1),
                          reflected = refine_by_rules(mesh, *find_scheme("butterfly"), 1);
        const GoldenMesh theirs = read_golden(*golden / (name + ".butterfly.openmesh.L1.obj.gz"));
        const PointMatch match(theirs.points);
        const auto distance = [&](const Vec3d& p) { return glm::length(theirs.points[match.nearest(p)] - p); };
        // Of each edge the new point comes after the vertices.
        for (int e = 0; e < rules.edge_count(); ++e) {
            const int h = rules.edge_halfedge(e), u = rules.origin(h), v = rules.target(h);
            const std::size_t at = static_cast<std::size_t>(rules.vertex_count() + e);
            const auto extraordinary = [&](int w) { return !rules.on_boundary(w) && rules.ring(w).edges() != 6; };
            if (rules.sharp(h) || extraordinary(u) || extraordinary(v) ||
                (!rules.on_boundary(u) && !rules.on_boundary(v))) {
                CHECK(distance(thesis.positions[at]) < 1e-14);
                ++inside;
                continue;
            }
            CHECK(distance(reflected.positions[at]) < 1e-14);
            const auto regular = [&](int w) { return rules.ring(w).faces() == (rules.on_boundary(w) ? 3 : 6); };
            const double apart = glm::length(thesis.positions[at] - reflected.positions[at]);
            if (regular(u) && regular(v)) {
                CHECK(apart < 0.05);
                beside_regular += apart > 1e-3 ? 1 : 0;
            } else {
                CHECK(apart < 0.3);
                beside_extraordinary += apart > 1e-3 ? 1 : 0;
            }
        }
    }
    // Where they differ at all.
    CHECK(inside == 140);
    CHECK(beside_regular == 34);
    CHECK(beside_extraordinary == 11);
}

TEST_CASE("[bad-input] refining by rules says what a scheme cannot take") {
    ControlMeshData square;
    square.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
    square.face_offsets = {0, 4};
    square.face_vertices = {0, 1, 2, 3};
    const ControlMesh mesh = ControlMesh::build(std::move(square));
    CHECK_THROWS_WITH_AS(refine_by_rules(mesh, *find_scheme("loop"), 1), doctest::Contains("triangulate"), Error);
    CHECK_THROWS_AS(refine_by_rules(mesh, *find_scheme("catmull-clark"), -1), Error);
    CHECK(refine_by_rules(mesh, *find_scheme("doo-sabin"), 0).face_count() == 1);
}

TEST_SUITE_END();
