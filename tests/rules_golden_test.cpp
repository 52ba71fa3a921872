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
    {"doo-sabin", "doosabin.cgal", 1, 1},
    {"doo-sabin", "doosabin.cgal", 2, 2},
    {"sqrt3", "sqrt3.cgal", 2, 1},
    {"sqrt3", "sqrt3.openmesh", 2, 1},
    {"bilinear", "bilinear.osd", 1, 1},
    {"bilinear", "bilinear.osd", 2, 2},
    {"midedge-simplest", "midpoint.openmesh", 2, 1},  // joining midpoints twice
    {"modified-butterfly", "butterfly.openmesh", 1, 1},
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
            // OpenMesh's Butterfly has its own way beside boundaries, not the rules of the thesis.
            if (std::string(peer.scheme) == "modified-butterfly" && has_boundary(mesh)) continue;
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
