#include "../kit/random_mesh.hpp"

#include "../../hier/base/error.hpp"
#include "../../hier/mesh/triangulate.hpp"
#include "../../refine/uniform/refine.hpp"
#include "../../schemes/core/scheme_kind.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <limits>
#include <map>
#include <set>

using namespace tetrakis;

namespace {

constexpr SchemeKind k_schemes[] = {SchemeKind::catmull_clark, SchemeKind::loop};

ControlMesh make_mesh(SchemeKind scheme, std::uint64_t seed) {
    const ControlMesh mesh = test::random_mesh(seed);
    return scheme == SchemeKind::loop ? triangulate(mesh) : mesh;
}

/// n x n quads (or twice the triangles) over [0, n]^2, with UVs; a seam between the columns if asked.
ControlMeshData grid(std::uint32_t n, bool triangles, bool seam, FaceVaryingRule rule) {
    ControlMeshData data;
    data.face_varying_rule = rule;
    data.face_offsets.push_back(0);
    const auto vertex = [n](std::uint32_t x, std::uint32_t y) { return y * (n + 1) + x; };
    for (std::uint32_t y = 0; y <= n; ++y)
        for (std::uint32_t x = 0; x <= n; ++x) data.positions.push_back({double(x), double(y), 0});
    // One chart left of the middle, one to its right that starts ten units away.
    for (int chart = 0; chart < 2; ++chart)
        for (const Vec3d& p : data.positions) data.uvs.push_back({p.x + 10 * chart, p.y});
    const auto count = static_cast<std::uint32_t>(data.positions.size());
    for (std::uint32_t y = 0; y < n; ++y)
        for (std::uint32_t x = 0; x < n; ++x) {
            const std::uint32_t q[] = {vertex(x, y), vertex(x + 1, y), vertex(x + 1, y + 1), vertex(x, y + 1)};
            const std::uint32_t chart = seam && x >= n / 2 ? count : 0;
            for (const std::vector<int>& face : triangles ? std::vector<std::vector<int>>{{0, 1, 2}, {0, 2, 3}}
                                                          : std::vector<std::vector<int>>{{0, 1, 2, 3}}) {
                for (const int i : face) {
                    data.face_vertices.push_back(q[i]);
                    data.face_uvs.push_back(q[i] + chart);
                }
                data.face_offsets.push_back(static_cast<std::uint32_t>(data.face_vertices.size()));
                data.face_material.push_back(x % 2);
            }
        }
    data.materials = {"even", "odd"};
    return data;
}

}  // namespace

TEST_SUITE_BEGIN("refine");

TEST_CASE("[inv7] a regular grid reproduces linear functions: the inside does not move") {
    for (const SchemeKind scheme : k_schemes) {
        const ControlMesh mesh =
            ControlMesh::build(grid(6, scheme == SchemeKind::loop, false, FaceVaryingRule::linear_all));
        RefineOptions options;
        options.limit = options.normals = true;
        const PolygonMesh limit = refine(mesh, name(scheme), 3, options);
        double worst = 0, tilt = 0;
        std::size_t corner = 0;
        for (const std::uint32_t v : limit.face_vertices) {
            // UVs are interpolated linearly here, so they tell where on the grid a vertex is.
            const Vec2d uv = limit.uvs[limit.face_uvs[corner++]];
            tilt = std::max(tilt, glm::length(limit.normals[v] - Vec3d(0, 0, 1)));
            if (uv.x < 2 || uv.y < 2 || uv.x > 4 || uv.y > 4) continue;
            worst = std::max(worst, glm::length(limit.positions[v] - Vec3d(uv.x, uv.y, 0)));
        }
        CHECK(worst < 1e-13);
        CHECK(tilt < 1e-12);
    }
}

TEST_CASE("no level at all gives the control mesh without its holes, or its limit") {
    for (const std::uint64_t seed : test::seeds(6)) {
        CAPTURE(seed);
        const ControlMesh mesh = test::random_mesh(seed);
        const PolygonMesh same = refine(mesh, name(SchemeKind::catmull_clark), 0);
        RefineOptions options;
        options.limit = options.normals = true;
        const PolygonMesh limit = refine(mesh, name(SchemeKind::catmull_clark), 0, options);
        const PolygonMesh finer = refine(mesh, name(SchemeKind::catmull_clark), 2, options);
        CHECK(limit.face_vertices == same.face_vertices);
        std::uint32_t f = 0;
        for (std::uint32_t i = 0; i < mesh.face_count(); ++i) {
            if (mesh.is_hole(FaceId(i))) continue;
            const std::uint32_t begin = same.face_offsets[f++], size = mesh.face_size(FaceId(i));
            REQUIRE(same.face_offsets[f] - begin == size);
            for (std::uint32_t k = 0; k < size; ++k) {
                const VertexId v = mesh.origin(HalfedgeId(mesh.face_halfedge(FaceId(i)).value + k));
                CHECK(same.positions[same.face_vertices[begin + k]] == mesh.position(v));
            }
        }
        CHECK(f == same.face_count());
        // A control vertex has one limit, whatever the level.
        double worst = 0;
        for (const Vec3d& p : limit.positions) {
            double nearest = std::numeric_limits<double>::infinity();
            for (const Vec3d& q : finer.positions) nearest = std::min(nearest, glm::length(p - q));
            worst = std::max(worst, nearest);
        }
        CHECK(worst < 1e-12 * bounding_box(mesh.positions()).diagonal());
    }
}

TEST_CASE("UVs: charts stay apart along a seam, corners as the tag says, materials follow their face") {
    for (const SchemeKind scheme : k_schemes) {
        INFO(name(scheme));
        const bool triangles = scheme == SchemeKind::loop;
        for (const FaceVaryingRule rule :
             {FaceVaryingRule::linear_all, FaceVaryingRule::corners_only, FaceVaryingRule::smooth_all}) {
            const ControlMesh mesh = ControlMesh::build(grid(4, triangles, true, rule));
            const PolygonMesh fine = refine(mesh, name(scheme), 3);
            REQUIRE(fine.face_uvs.size() == fine.face_vertices.size());
            std::map<std::uint32_t, std::set<std::uint32_t>> uvs_of_vertex;
            double left = 0, corner = 1e9;
            for (std::size_t c = 0; c < fine.face_uvs.size(); ++c) {
                const Vec2d uv = fine.uvs[fine.face_uvs[c]];
                uvs_of_vertex[fine.face_vertices[c]].insert(fine.face_uvs[c]);
                if (uv.x < 7) left = std::max(left, uv.x);
                corner = std::min(corner, glm::length(uv));
            }
            CHECK(left == doctest::Approx(2).epsilon(1e-14));  // the straight seam stays where it is
            std::size_t on_seam = 0;
            for (const auto& [v, uvs] : uvs_of_vertex) {
                CHECK(uvs.size() <= 2);
                on_seam += uvs.size() == 2;
            }
            CHECK(on_seam == 4 * 8 + 1);
            // In the triangle grid two faces meet at this corner, so only the linear rule keeps it.
            const bool kept =
                rule == FaceVaryingRule::linear_all || (rule == FaceVaryingRule::corners_only && !triangles);
            CHECK((corner < 1e-14) == kept);
            REQUIRE(fine.face_material.size() == fine.face_count());
            for (std::uint32_t f = 0; f < fine.face_count(); ++f) {
                const double x = fine.positions[fine.face_vertices[fine.face_offsets[f]]].x;
                const double u = fine.uvs[fine.face_uvs[fine.face_offsets[f]]].x;
                if (rule != FaceVaryingRule::linear_all || std::abs(x - std::round(x)) < 0.2) continue;
                CHECK(fine.face_material[f] == static_cast<std::uint32_t>(u) % 2);
            }
        }
    }
}

TEST_CASE("too many levels, too little memory and cancellation are refused with a reason") {
    const ControlMesh mesh = make_mesh(SchemeKind::catmull_clark, 2);
    RefineOptions options;
    const auto code = [&](int levels) {
        try {
            refine(mesh, name(SchemeKind::catmull_clark), levels, options);
        } catch (const Error& error) {
            return static_cast<int>(error.code());
        }
        return 0;
    };
    CHECK(code(-1) == static_cast<int>(ErrorCode::invalid_input));
    CHECK(code(16) == static_cast<int>(ErrorCode::unsupported));
    CHECK(code(1000) == static_cast<int>(ErrorCode::unsupported));
    options.context.max_memory_bytes = 1 << 20;
    CHECK(code(7) == static_cast<int>(ErrorCode::memory_limit));
    CHECK(code(1) == 0);
    options.context.max_memory_bytes = 0;
    options.context.progress = [](std::string_view, double fraction) { return fraction < 0.5; };
    CHECK(code(3) == static_cast<int>(ErrorCode::cancelled));
}

TEST_SUITE_END();
