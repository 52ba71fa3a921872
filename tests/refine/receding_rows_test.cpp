#include "../kit/random_mesh.hpp"
#include "../kit/repeated_rows_helpers.hpp"

#include "../../hier/base/error.hpp"
#include "../../refine/uniform/refine.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

using namespace tetrakis;

namespace {

/// An open mesh, every face of a material of its own.
ControlMesh open_mesh(std::uint64_t seed) {
    test::RandomMeshOptions random = test::random_options(seed);
    random.topology = test::Topology::plane;
    random.columns = random.rows = 7;
    random.removed_faces = seed % 3 == 0 ? 0 : 1;
    random.hole = 0;
    ControlMeshData data = test::random_mesh_data(seed, random);
    data.uvs.clear();
    data.face_uvs.clear();
    data.face_material.clear();
    data.materials.clear();
    for (std::uint32_t f = 0; f + 1 < data.face_offsets.size(); ++f) {
        data.face_material.push_back(f);
        data.materials.push_back(std::to_string(f));
    }
    return ControlMesh::build(std::move(data));
}

/// Each of one set's points with the nearest of another's: the largest distance, and who they are.
double find(const std::vector<Vec3d>& these, const std::vector<Vec3d>& among, std::vector<std::uint32_t>& found) {
    const PointMatch match(among);
    double worst = 0;
    found.clear();
    for (const Vec3d& p : these) {
        found.push_back(match.nearest(p));
        worst = std::max(worst, glm::length(p - among[found.back()]));
    }
    return worst;
}

}  // namespace

TEST_SUITE_BEGIN("refine");

TEST_CASE(
    "[slow] boundaries that recede: smoothing, normals by rows that repeat themselves are those "
    "of the rules") {
    int repeated = 0, all = 0;
    for (const std::uint64_t seed : test::seeds(8))
        for (int steps = 1; steps <= 5; ++steps) {
            CAPTURE(seed);
            CAPTURE(steps);
            const ControlMesh mesh = open_mesh(seed);
            RefineOptions options;
            options.smoothing = static_cast<int>(seed % 3);
            options.normals = seed % 4 >= 2;
            options.limit = seed % 4 == 3 && steps < 5;
            options.rules.averaging_steps = steps;
            options.rules.averaging_boundary = AveragingBoundary::recede;
            const SchemeInfo& scheme = *find_scheme(steps == 3 ? "biquartic" : "averaging");
            const std::optional<PolygonMesh> expected = test::by_stencils(mesh, scheme, 4, options);
            if (!expected) continue;
            const PolygonMesh ours = refine(mesh, scheme, 4, options);
            const double size = bounding_box(mesh.positions()).diagonal();
            ++all;
            // By rules they would be in the same order.
            if (ours.positions != expected->positions) ++repeated;

            std::vector<std::uint32_t> vertex, face;
            CHECK(find(expected->positions, ours.positions, vertex) < 1e-12 * size);
            const std::vector<Vec3d> our_faces = test::marks(ours, false);
            CHECK(find(test::marks(*expected, false), our_faces, face) < 1e-11 * (size + size * size));
            if (!options.normals) {
                CHECK(ours.positions.size() == expected->positions.size());
                CHECK(ours.face_count() == expected->face_count());
            }
            CHECK(ours.warnings == expected->warnings);
            int other_material = 0;
            for (std::size_t f = 0; f < face.size(); ++f)
                other_material += ours.face_material[face[f]] != expected->face_material[f];
            CHECK(other_material == 0);
            double worst = 0;
            REQUIRE(ours.normals.size() == (options.normals ? ours.positions.size() : 0));
            for (std::size_t v = 0; v < expected->normals.size(); ++v)
                worst = std::max(worst, glm::length(ours.normals[vertex[v]] - expected->normals[v]));
            CHECK(worst < 1e-7);
            for (const Vec3d& n : ours.normals) CHECK(std::abs(glm::length(n) - 1) < 1e-9);
        }
    CHECK(repeated > all / 2);
}

TEST_SUITE_END();
