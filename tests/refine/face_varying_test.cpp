#include "../kit/meshes.hpp"
#include "../kit/scheme_meshes.hpp"

#include "../../refine/uniform/refine.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <utility>
#include <vector>

using namespace tetrakis;

namespace {

constexpr double k_shift = 100;  // between the charts of the grid, far beyond its size

/// n x n quads, or twice the triangles, over [0, n]^2. From the middle column on, below row `cut`, there is another
/// chart; UVs are x, y and the shift there.
ControlMesh grid_with_seam(std::uint32_t n, std::uint32_t cut, bool triangles, FaceVaryingRule rule) {
    ControlMeshData data = test::grid(n, triangles);
    data.face_varying_rule = rule;
    for (const double shift : {0.0, k_shift})
        for (const Vec3d& p : data.positions) data.uvs.emplace_back(p.x + shift, p.y);
    const auto count = static_cast<std::uint32_t>(data.positions.size());
    for (std::uint32_t f = 0; f + 1 < data.face_offsets.size(); ++f) {
        const std::uint32_t cell = triangles ? f / 2 : f;
        const bool right = cell % n >= n / 2 && cell / n < cut;
        data.face_material.push_back(right ? 1 : 0);
        for (std::uint32_t c = data.face_offsets[f]; c < data.face_offsets[f + 1]; ++c)
            data.face_uvs.push_back(data.face_vertices[c] + (right ? count : 0));
    }
    data.materials = {"left", "right"};
    return ControlMesh::build(std::move(data));
}

/// Every scheme by its own rules.
std::vector<test::SchemeVariant> all_choices() {
    std::vector<test::SchemeVariant> all = test::scheme_variants();
    std::erase_if(all, [](const auto& variant) { return variant.name.find(',') != std::string::npos; });
    return all;
}

/// Whether it has faces there.
bool across_seams(const test::SchemeVariant& choice) {
    return choice.scheme->refinement == Refinement::honeycomb ||
           fan_lattice(*choice.scheme, choice.options) == FanLattice::dual;
}

Vec2d uv_at(const PolygonMesh& mesh, std::uint32_t corner) { return mesh.uvs[mesh.face_uvs[corner]]; }

/// Edges whose two sides have different UV numbers: their midpoints.
std::vector<Vec3d> seam_edges(const PolygonMesh& mesh) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::pair<std::uint32_t, std::uint32_t>> uvs;
    std::vector<Vec3d> result;
    for (std::uint32_t f = 0; f < mesh.face_count(); ++f) {
        const std::uint32_t begin = mesh.face_offsets[f], end = mesh.face_offsets[f + 1];
        for (std::uint32_t c = begin; c < end; ++c) {
            const std::uint32_t n = c + 1 < end ? c + 1 : begin;
            const std::uint32_t a = mesh.face_vertices[c], b = mesh.face_vertices[n];
            const auto other = uvs.find({b, a});
            if (other == uvs.end())
                uvs[{a, b}] = {mesh.face_uvs[c], mesh.face_uvs[n]};
            else if (other->second != std::pair{mesh.face_uvs[n], mesh.face_uvs[c]})
                result.push_back(0.5 * (mesh.positions[a] + mesh.positions[b]));
        }
    }
    return result;
}

/// Every face a chart of its own, whose UVs are its number.
ControlMesh charts_of_one_face(ControlMeshData data) {
    data.uvs.clear();
    data.face_uvs.clear();
    for (std::uint32_t f = 0; f + 1 < data.face_offsets.size(); ++f)
        for (std::uint32_t c = data.face_offsets[f]; c < data.face_offsets[f + 1]; ++c) {
            data.face_uvs.push_back(static_cast<std::uint32_t>(data.uvs.size()));
            data.uvs.emplace_back(f, 0);
        }
    return ControlMesh::build(std::move(data));
}

}  // namespace

TEST_SUITE_BEGIN("refine");

TEST_CASE("[inv7] every scheme: charts that are affine in the plane stay so, up to their seam") {
    constexpr std::uint32_t n = 12;
    constexpr int levels = 2;
    for (const test::SchemeVariant& choice : all_choices())
        for (const FaceVaryingRule rule : {FaceVaryingRule::corners_only, FaceVaryingRule::linear_all}) {
            INFO(choice.name, ", rule ", static_cast<int>(rule));
            const ControlMesh mesh = grid_with_seam(n, n, choice.scheme->family == MeshFamily::triangles, rule);
            const PolygonMesh fine = refine(mesh, *choice.scheme, levels, {.rules = choice.options});
            CHECK(fine.warnings.size() == (across_seams(choice) && rule == FaceVaryingRule::linear_all ? 1 : 0));
            REQUIRE(fine.face_uvs.size() == fine.face_vertices.size());
            double off = 0, near_seam = 0, beside = -double(n), longest = 0;
            std::size_t left = 0, right = 0, wrong_material = 0;
            for (std::uint32_t f = 0; f < fine.face_count(); ++f) {
                const std::uint32_t begin = fine.face_offsets[f], end = fine.face_offsets[f + 1];
                const double shift = uv_at(fine, begin).x > k_shift / 2 ? k_shift : 0;
                wrong_material += fine.face_material[f] != (shift == 0 ? 0u : 1u);
                Vec2d centre(0);
                bool inside = true;
                double size = 0;
                for (std::uint32_t c = begin; c < end; ++c) {
                    const Vec2d p(fine.positions[fine.face_vertices[c]]);
                    centre += p / double(end - begin);
                    size = std::max(size, std::abs(p.x - fine.positions[fine.face_vertices[begin]].x));
                    inside = inside && std::min({p.x, p.y, n - p.x, n - p.y}) > 4;
                }
                if (!inside) continue;  // there the seam ends, and the boundary bends the parametrisation
                longest = std::max(longest, size);
                (shift == 0 ? left : right) += 1;
                beside = std::max(beside, shift == 0 ? centre.x - n / 2 : n / 2 - centre.x);
                for (std::uint32_t c = begin; c < end; ++c) {
                    const Vec2d expected(fine.positions[fine.face_vertices[c]].x + shift,
                                         fine.positions[fine.face_vertices[c]].y);
                    double& worst = std::abs(expected.x - shift - n / 2) < 1 ? near_seam : off;
                    worst = std::max(worst, glm::length(uv_at(fine, c) - expected));
                }
            }
            CHECK(off < 1e-12 * k_shift);
            // Beside a boundary sqrt3 has vertices with five neighbours, whose mean is 1/27 off.
            const bool bends = choice.scheme->refinement == Refinement::sqrt3 && rule != FaceVaryingRule::linear_all;
            CHECK(near_seam < (bends ? 1.01 / 27 : 1e-12 * k_shift));
            CHECK(wrong_material == 0);
            CHECK(left > 0);
            CHECK(right > 0);
            // A face belongs to the side that its centre is on; one across the seam to either.
            if (across_seams(choice))
                CHECK(beside < 1e-12);
            else
                CHECK(beside < 0);
            const std::vector<Vec3d> seam = seam_edges(fine);
            CHECK(!seam.empty());
            double apart = 0;
            for (const Vec3d& p : seam)
                if (p.y > 4 && p.y < n - 4) apart = std::max(apart, std::abs(p.x - n / 2));
            CHECK(apart < (across_seams(choice) ? longest : 1e-12));
        }
}

TEST_CASE("[inv7] [slow] every scheme: the weights of UVs sum to one in charts of any shape") {
    for (const std::string name : {"cube", "extruded_pentagon", "pipe3", "tetrahedron", "bracket"})
        for (const test::SchemeVariant& choice : all_choices()) {
            INFO(name, ", ", choice.name);
            const ControlMeshData surface = test::mesh_for(*choice.scheme, test::model(name)).data();
            const ControlMesh mesh = charts_of_one_face(surface);
            const PolygonMesh fine = refine(mesh, *choice.scheme, name == "bracket" ? 1 : 2, {.rules = choice.options});
            // Averaging says that it leaves creases alone, other dual schemes that semi-sharp ones stay sharp.
            for (const std::string& warning : fine.warnings)
                CHECK((warning.starts_with("the creases were ignored") || warning.starts_with("semi-sharp edges")));
            REQUIRE(fine.face_uvs.size() == fine.face_vertices.size());
            double off = 0;
            std::vector<char> met(mesh.face_count(), 0);
            for (std::uint32_t f = 0; f < fine.face_count(); ++f) {
                const auto chart = static_cast<std::size_t>(std::lround(uv_at(fine, fine.face_offsets[f]).x));
                met.at(chart) = 1;
                for (std::uint32_t c = fine.face_offsets[f]; c < fine.face_offsets[f + 1]; ++c)
                    off = std::max(off, glm::length(uv_at(fine, c) - Vec2d(double(chart), 0)));
            }
            CHECK(off < 1e-12 * mesh.face_count());
            CHECK(std::count(met.begin(), met.end(), 0) == 0);
        }
}

TEST_CASE("every scheme: without seams UVs are refined as any attribute of the vertices") {
    ControlMeshData tagged = test::grid(4, false);
    tagged.creases = {{2, 7, k_infinite_sharpness}, {7, 12, 1.5f}};
    tagged.corners = {{1, k_infinite_sharpness}, {8, 2}};
    const ControlMesh meshes[] = {test::model("extruded_pentagon"), ControlMesh::build(tagged)};
    for (const test::SchemeVariant& choice : all_choices())
        for (const ControlMesh& mesh : meshes) {
            INFO(choice.name);
            CAPTURE(mesh.face_count());
            ControlMeshData data = test::mesh_for(*choice.scheme, mesh).data();
            VertexAttribute same{"uv", 2, {}};
            data.uvs.clear();
            for (std::size_t v = 0; v < data.positions.size(); ++v) {
                same.values.push_back(static_cast<float>(v * 37 % 11));
                same.values.push_back(static_cast<float>(v * 17 % 7));
                data.uvs.emplace_back(same.values[2 * v], same.values[2 * v + 1]);
            }
            data.face_uvs = data.face_vertices;
            RefineOptions options{.rules = choice.options};
            options.attributes = {&same, 1};
            const PolygonMesh fine = refine(ControlMesh::build(std::move(data)), *choice.scheme, 2, options);
            REQUIRE(fine.face_uvs.size() == fine.face_vertices.size());
            double off = 0;
            for (std::uint32_t c = 0; c < fine.face_uvs.size(); ++c) {
                const float* at = fine.attributes[0].values.data() + 2 * std::size_t{fine.face_vertices[c]};
                off = std::max(off, glm::length(uv_at(fine, c) - Vec2d(at[0], at[1])));
            }
            CHECK(off < 1e-5);  // attributes are floats
            CHECK(seam_edges(fine).empty());
        }
}

TEST_CASE("every scheme: a seam that ends inside the mesh ends in its refinement, too") {
    constexpr std::uint32_t n = 12;
    for (const test::SchemeVariant& choice : all_choices()) {
        INFO(choice.name);
        const ControlMesh mesh =
            grid_with_seam(n, n / 2, choice.scheme->family == MeshFamily::triangles, FaceVaryingRule::corners_only);
        // The other chart is a quarter of the grid: a corner of it inside, where the main chart has a reflex one.
        const PolygonMesh fine = refine(mesh, *choice.scheme, 2, {.rules = choice.options});
        CHECK(fine.warnings.empty());
        const std::vector<Vec3d> seam = seam_edges(fine);
        CHECK(!seam.empty());
        double off = 0;
        for (const Vec3d& p : seam) {
            if (std::min(p.y, n - p.x) < 4) continue;  // the boundary bends it
            // Distance to the two arms, from (6, 0) and (12, 6) to (6, 6).
            const double up = glm::length(Vec2d(p.x - n / 2, std::max(p.y - n / 2, 0.0))),
                         along = glm::length(Vec2d(std::max(n / 2 - p.x, 0.0), p.y - n / 2));
            off = std::max(off, std::min(up, along));
        }
        CHECK(off < (across_seams(choice) ? 0.5 : 1e-12));
    }
}
