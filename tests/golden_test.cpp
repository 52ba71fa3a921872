#include "golden_mesh.hpp"
#include "point_match.hpp"
#include "shared_data.hpp"

#include "tetrakis/hier/obj_reader.hpp"
#include "tetrakis/refine/uniform.hpp"

#include <doctest/doctest.h>

#include <set>
#include <sstream>
#include <string>

using namespace tetrakis;

namespace {

struct Variant {
    const char* name;
    SchemeKind scheme;
    CreaseMethod method;
};
constexpr Variant k_variants[] = {
    {"catmark", SchemeKind::catmull_clark, CreaseMethod::uniform},
    {"loop", SchemeKind::loop, CreaseMethod::uniform},
    {"catmark-chaikin", SchemeKind::catmull_clark, CreaseMethod::chaikin},
    {"loop-chaikin", SchemeKind::loop, CreaseMethod::chaikin},
};

ControlMesh load(const std::filesystem::path& path, CreaseMethod method) {
    ControlMeshData data = read_obj(path);
    data.crease_method = method;
    return ControlMesh::build(std::move(data));
}

/// Limits agree to 1e-9 of the bounding box, the issue's figure; what is measured is 1e-15.
constexpr double k_relative_tolerance = 1e-9;

}  // namespace

TEST_SUITE_BEGIN("refine");

TEST_CASE("[golden] points and faces of levels 1 to 3 are OpenSubdiv's") {
    const auto golden = shared_data::folder("reference/golden"), meshes = shared_data::folder("reference/meshes");
    if (!golden || !meshes) return;
    int compared = 0;
    for (const auto& path : shared_data::files(*meshes, ".obj"))
        for (const Variant& variant : k_variants)
            for (int level = 1; level <= 3; ++level) {
                const std::string file = path.stem().string() + "." + variant.name + ".osd.L" + std::to_string(level);
                if (!std::filesystem::exists(*golden / (file + ".obj.gz"))) continue;
                INFO(file);
                const GoldenMesh theirs = read_golden(*golden / (file + ".obj.gz"));
                const PolygonMesh ours = refine_uniform(load(path, variant.method), variant.scheme, level);
                const double tolerance = k_relative_tolerance * bounding_box(theirs.points).diagonal();
                const PointMatch match(ours.positions);

                REQUIRE(ours.face_count() == theirs.faces.size());
                std::multiset<std::vector<std::uint32_t>> faces, expected;
                double worst = 0;
                std::set<std::uint32_t> used;
                for (const auto& face : theirs.faces) {
                    std::vector<std::uint32_t> numbers;
                    for (const std::uint32_t v : face) {
                        numbers.push_back(match.nearest(theirs.points[v]));
                        worst = std::max(worst, glm::length(ours.positions[numbers.back()] - theirs.points[v]));
                        used.insert(numbers.back());
                    }
                    expected.insert(rotated(numbers));
                }
                CHECK(worst < tolerance);
                CHECK(used.size() == ours.positions.size());
                for (std::uint32_t f = 0; f < ours.face_count(); ++f)
                    faces.insert(rotated({ours.face_vertices.begin() + ours.face_offsets[f],
                                          ours.face_vertices.begin() + ours.face_offsets[f + 1]}));
                CHECK(faces == expected);
                ++compared;
            }
    MESSAGE(compared, " golden meshes compared");
    CHECK(compared >= 100);
}

TEST_CASE("[golden] limit positions and normals are those of the golden files") {
    const auto golden = shared_data::folder("reference/golden"), meshes = shared_data::folder("reference/meshes");
    if (!golden || !meshes) return;
    int compared = 0, normals = 0;
    for (const auto& path : shared_data::files(*meshes, ".obj"))
        for (const Variant& variant : k_variants) {
            const std::string file = path.stem().string() + "." + variant.name + ".osd.limit.txt.gz";
            if (!std::filesystem::exists(*golden / file)) continue;
            INFO(file);
            const ControlMesh mesh = load(path, variant.method);
            const PolygonMesh control = refine_uniform(mesh, variant.scheme, 2);
            const PolygonMesh limit = refine_uniform(mesh, variant.scheme, 2, {.limit = true, .normals = true});
            REQUIRE(control.positions.size() == limit.positions.size());
            const double diagonal = bounding_box(control.positions).diagonal();
            const PointMatch match(control.positions);
            bool iterated = false;
            std::istringstream lines(unzip(*golden / file));
            for (std::string line; std::getline(lines, line);) {
                if (line.starts_with("#")) {
                    iterated = line.find("iterated") != std::string::npos;
                    continue;
                }
                std::istringstream words(line);
                Vec3d at, position, normal;
                words >> at.x >> at.y >> at.z >> position.x >> position.y >> position.z >> normal.x >> normal.y >>
                    normal.z;
                const std::uint32_t v = match.nearest(at);
                CAPTURE(line);
                CHECK(glm::length(control.positions[v] - at) < k_relative_tolerance * diagonal);
                CHECK(glm::length(limit.positions[v] - position) < k_relative_tolerance * diagonal);
                if (normal != Vec3d(0)) {
                    // Iterated normals are stable to 8.4e-7, says the data's README.
                    CHECK(glm::length(limit.normals[v] - normal) < (iterated ? 2e-6 : 1e-9));
                    ++normals;
                }
                iterated = false;
                ++compared;
            }
        }
    MESSAGE(compared, " limit points and ", normals, " normals compared");
    CHECK(compared > 3000);
}

TEST_SUITE_END();
