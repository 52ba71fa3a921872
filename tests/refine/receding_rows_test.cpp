#include "../kit/random_mesh.hpp"
#include "../kit/repeated_rows_helpers.hpp"

#include "../../refine/uniform/refine.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

using namespace tetrakis;

namespace {

/// An open mesh in two charts, every face of a material of its own.
/// @param simple  of quads, with one seam
ControlMesh open_mesh(std::uint64_t seed, bool one_chart, bool simple = false) {
    test::RandomMeshOptions random = test::random_options(seed);
    random.topology = test::Topology::plane;
    random.columns = random.rows = 7;
    random.removed_faces = seed % 3 == 0 ? 0 : 1;
    random.hole = 0;
    if (simple) random.split = random.merge = 0;
    if (seed % 4 != 0) random.edge_vertices = 0;  // seams over vertices of two faces go by rules
    ControlMeshData data = test::random_mesh_data(seed, random);
    data.uvs.clear();
    data.face_uvs.clear();
    data.face_material.clear();
    data.materials.clear();
    const auto count = static_cast<std::uint32_t>(data.positions.size());
    for (const double shift : {0.0, 100.0})
        for (const Vec3d& p : data.positions) data.uvs.emplace_back(p.x + shift, p.y + 0.5 * p.z);
    for (std::uint32_t f = 0; f + 1 < data.face_offsets.size(); ++f) {
        const bool second = !one_chart && (simple ? f >= 24 : seed % 2 == 0 ? f % 3 == 2 : f % 14 >= 7);
        for (std::uint32_t c = data.face_offsets[f]; c < data.face_offsets[f + 1]; ++c)
            data.face_uvs.push_back(data.face_vertices[c] + (second ? count : 0));
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
    "[slow] boundaries that recede: texture coordinates, smoothing, normals by rows that repeat themselves are those "
    "of the rules") {
    int repeated = 0, all = 0, dropped_by_rules = 0;
    for (const std::uint64_t seed : test::seeds(8))
        for (int steps = 1; steps <= 5; ++steps) {
            CAPTURE(seed);
            CAPTURE(steps);
            const ControlMesh mesh = open_mesh(seed, seed % 4 == 3);
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
            // Charts of which less is left, or parts that only touch, are no meshes for the rules.
            const bool dropped = expected->uvs.empty();
            dropped_by_rules += dropped;
            CHECK((dropped || ours.warnings == expected->warnings));
            if (!dropped && !options.normals) CHECK(ours.uvs.size() == expected->uvs.size());
            if (dropped) continue;
            REQUIRE(ours.face_uvs.size() == ours.face_vertices.size());
            const std::vector<Vec3d> our_uvs = test::marks(ours, true), uvs = test::marks(*expected, true);
            double worst = 0;
            int other_material = 0;
            for (std::size_t f = 0; f < face.size(); ++f) {
                worst = std::max(worst, glm::length(our_uvs[face[f]] - uvs[f]));
                other_material += ours.face_material[face[f]] != expected->face_material[f];
            }
            CHECK(worst < 1e-11 * (100 + size) * (100 + size));
            CHECK(other_material == 0);
            worst = 0;
            REQUIRE(ours.normals.size() == (options.normals ? ours.positions.size() : 0));
            for (std::size_t v = 0; v < expected->normals.size(); ++v)
                worst = std::max(worst, glm::length(ours.normals[vertex[v]] - expected->normals[v]));
            CHECK(worst < 1e-7);
            for (const Vec3d& n : ours.normals) CHECK(std::abs(glm::length(n) - 1) < 1e-9);
        }
    CHECK(repeated > all / 2);
    CHECK(dropped_by_rules < all / 4);
}

TEST_SUITE_END();
