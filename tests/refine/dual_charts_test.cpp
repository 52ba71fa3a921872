#include "../kit/nearest.hpp"
#include "../kit/random_mesh.hpp"

#include "../../hier/base/error.hpp"
#include "../../hier/obj/obj_reader.hpp"
#include "../../refine/adaptive/dual_charts.hpp"
#include "../../refine/points/level_source.hpp"
#include "../../refine/points/row_points.hpp"
#include "../../refine/points/vertex_links.hpp"
#include "../../refine/uniform/refine.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <utility>
#include <vector>

using namespace tetrakis;

namespace {

ControlMesh with_charts(const ControlMesh& mesh) {
    ControlMeshData data = mesh.data();
    test::add_charts(data);
    return ControlMesh::build(std::move(data));
}

/// Creases around regions of faces: none ends inside.
ControlMesh with_regions(const ControlMesh& mesh, std::uint64_t seed) {
    ControlMeshData data = mesh.data();
    const auto region = [&](HalfedgeId h) {
        return (mesh.face(h).value * 2654435761u + static_cast<std::uint32_t>(seed) * 40503u) >> 7 & 3;
    };
    for (std::uint32_t i = 0; i < mesh.halfedge_count(); ++i) {
        const HalfedgeId h(i), t = mesh.twin(h);
        if (t.valid() && t.value > i && region(h) != region(t))
            data.creases.push_back({mesh.origin(h).value, mesh.target(h).value, k_infinite_sharpness});
    }
    return ControlMesh::build(std::move(data));
}

ControlMesh plain_mesh(std::uint64_t seed) {
    test::RandomMeshOptions options = test::random_options(seed);
    options.hole = options.crease = options.corner = 0;
    options.boundary_rule = seed % 2 == 0 ? BoundaryRule::edge_only : BoundaryRule::edge_and_corner;
    return test::random_dual_mesh(seed, options);
}

/// Faces by the nearest of some points, from the least one on, with the UVs of their corners; those elsewhere left out.
using Cycle = std::vector<std::uint32_t>;
std::multimap<Cycle, std::vector<Vec2d>> faces_of(const PolygonMesh& mesh, std::span<const Vec3d> points) {
    const PointMatch match(points);
    const auto is_there = [&](std::uint32_t v) {
        return glm::length(points[match.nearest(mesh.positions[v])] - mesh.positions[v]) < 1e-10;
    };
    std::multimap<Cycle, std::vector<Vec2d>> result;
    for (std::uint32_t f = 0; f < mesh.face_count(); ++f) {
        Cycle cycle;
        std::vector<Vec2d> uvs;
        for (std::uint32_t c = mesh.face_offsets[f]; c < mesh.face_offsets[f + 1]; ++c) {
            if (!is_there(mesh.face_vertices[c])) break;
            cycle.push_back(match.nearest(mesh.positions[mesh.face_vertices[c]]));
            uvs.push_back(mesh.uvs[mesh.face_uvs[c]]);
        }
        if (cycle.size() < mesh.face_offsets[f + 1] - mesh.face_offsets[f]) continue;
        const auto first = std::min_element(cycle.begin(), cycle.end()) - cycle.begin();
        std::rotate(cycle.begin(), cycle.begin() + first, cycle.end());
        std::rotate(uvs.begin(), uvs.begin() + first, uvs.end());
        result.emplace(std::move(cycle), std::move(uvs));
    }
    return result;
}

/// The leaves, each with the point of its own level, and their UVs.
PolygonMesh net_of(const ControlMesh& mesh, const SchemeInfo& scheme, const VertexForest& forest) {
    DualFaces faces = forest.faces(FaceCorners::leaves);
    PolygonMesh net;
    net.positions.resize(faces.cells.size());
    written_positions(*detail::row_points(mesh, scheme, {}, &forest.roots(), {}, false), cell_sites(faces.cells),
                      net.positions);
    auto [uvs, face_uvs] = DualCharts(mesh, scheme, {}, forest.roots()).uvs(forest, faces, false);
    net.uvs = std::move(uvs);
    net.face_uvs = std::move(face_uvs);
    net.face_offsets = faces.face_offsets;
    net.face_vertices = faces.face_vertices;
    return net;
}

double apart(const std::vector<Vec2d>& a, const std::vector<Vec2d>& b) {
    double worst = 0;
    for (std::size_t i = 0; i < a.size(); ++i) worst = std::max(worst, glm::length(a[i] - b[i]));
    return worst;
}

/// How many faces of `got` are among those of uniform refinement; their UVs have to be the same.
/// @param creased  where a seam leaves a crease, a chart has a corner that the surface does not have; of the faces
///                 beside it half may lie on either side, and then there is no rule which it takes
int compare_faces(const PolygonMesh& got, const PolygonMesh& uniform, bool creased) {
    const auto expected = faces_of(uniform, uniform.positions);
    int found = 0, off = 0;
    for (const auto& [cycle, uvs] : faces_of(got, uniform.positions)) {
        auto [at, end] = expected.equal_range(cycle);
        if (at == end) continue;
        ++found;
        bool same = false;
        for (; at != end; ++at) same = same || apart(uvs, at->second) < 1e-10;
        off += !same;
    }
    CHECK(off <= (creased ? found / 50 : 0));
    return found;
}

}  // namespace

TEST_SUITE_BEGIN("refine");

TEST_CASE("[inv1] UVs of vertex quadtrees: in adaptive meshes the faces of one level have those of that level") {
    for (const char* name : {"doo-sabin", "doo-sabin-cc", "midedge", "midedge-simplest", "biquartic"})
        for (const std::uint64_t seed : test::seeds(3)) {
            CAPTURE(name);
            CAPTURE(seed);
            const ControlMesh plain = plain_mesh(seed);
            const bool creased = seed % 2 == 1;
            const ControlMesh mesh = with_charts(creased ? with_regions(plain, seed) : plain);
            VertexForest forest(vertex_roots(mesh, *find_scheme(name), {}));
            test::Random random(seed);
            ForestChange change;
            for (int i = 0; i < 3; ++i)
                forest.refine(test::random_subset(forest.ordered_leaves(), 0.15, random), change);
            const PolygonMesh got = net_of(mesh, *find_scheme(name), forest);
            int found = 0;
            for (int level = 1; level <= 3; ++level)
                found += compare_faces(got, refine_stencils(mesh, *find_scheme(name), level).mesh, creased);
            CHECK(found > static_cast<int>(got.face_count()) / 5);
            CHECK(found < static_cast<int>(got.face_count()));
        }
}

TEST_CASE("[bad-input] UVs of vertex quadtrees: a seam along a crease that ends inside is refused") {
    const ControlMesh mesh = ControlMesh::build(parse_obj(
        "v 0 0 0\nv 1 0 0\nv 2 0 0\nv 0 1 0\nv 1 1 0\nv 2 1 0\nv 0 2 0\nv 1 2 0\nv 2 2 0\n"
        "vt 0 0\nvt 1 0\nvt 2 0\nvt 0 1\nvt 1 1\nvt 2 1\nvt 0 2\nvt 1 2\nvt 2 2\nvt 5 0\nvt 5 1\n"
        "f 1/1 2/2 5/5 4/4\nf 2/10 3/3 6/6 5/5\nf 4/4 5/5 8/8 7/7\nf 5/5 6/6 9/9 8/8\nt crease 2/1/0 1 4 10\n",
        "dart.obj"));
    const SchemeInfo& scheme = *find_scheme("doo-sabin");
    const VertexForest forest(vertex_roots(mesh, scheme, {}));
    CHECK_THROWS_WITH_AS(net_of(mesh, scheme, forest), doctest::Contains("charts"), Error);
}

TEST_CASE("[slow] faces have the material of the side whose UVs they have, also beside creases that end near a seam") {
    constexpr std::uint32_t k_charts = 3;
    constexpr double k_apart = 100;
    std::size_t faces = 0, wrong = 0;
    for (const std::uint64_t seed : test::seeds(12)) {
        ControlMeshData data = test::random_mesh_data(seed, test::random_options(seed));
        const auto points = static_cast<std::uint32_t>(data.positions.size());
        for (std::uint32_t chart = 0; chart < k_charts; ++chart) {
            data.materials.push_back(std::to_string(chart));
            for (const Vec3d& p : data.positions) data.uvs.emplace_back(p.x + k_apart * chart, p.y + 0.5 * p.z);
        }
        test::Random random(seed);
        for (std::size_t f = 0; f + 1 < data.face_offsets.size(); ++f) {
            data.face_material.push_back(random.chance(0.3) ? random.below(k_charts) : 0);
            for (std::uint32_t k = data.face_offsets[f]; k < data.face_offsets[f + 1]; ++k)
                data.face_uvs.push_back(data.face_vertices[k] + points * data.face_material.back());
        }
        const ControlMesh mesh = ControlMesh::build(std::move(data));
        for (const char* name : {"doo-sabin", "midedge-simplest"}) {
            const PolygonMesh got = refine(mesh, *find_scheme(name), 4);
            if (got.face_uvs.empty()) continue;  // creases that come to a seam
            faces += got.face_count();
            for (std::uint32_t f = 0; f < got.face_count(); ++f) {
                const double u = got.uvs[got.face_uvs[got.face_offsets[f]]].x;
                wrong += std::lround(u / k_apart) == static_cast<long>(got.face_material[f]) ? 0 : 1;
            }
        }
    }
    CHECK(faces > 50'000);
    CHECK(wrong == 0);
}

TEST_SUITE_END();
