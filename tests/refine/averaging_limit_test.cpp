#include "../../hier/mesh/control_mesh.hpp"
#include "../../refine/rules/mesh_part.hpp"
#include "../../refine/uniform/refine.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

// The ends of open meshes under repeated averaging with copies of the boundary.

using namespace tetrakis;

namespace {

/// columns x rows vertices over a rectangle, faces counter-clockwise from above, all of it curved.
ControlMeshData curved_grid(int columns, int rows) {
    ControlMeshData data;
    data.face_offsets.push_back(0);
    for (int y = 0; y < rows; ++y)
        for (int x = 0; x < columns; ++x)
            data.positions.push_back({x + 0.2 * std::sin(1.3 * y), y + 0.3 * std::sin(0.9 * x + 0.4 * y),
                                      0.7 * std::sin(0.8 * x) * std::cos(0.6 * y) + 0.1 * x * y});
    const auto at = [&](int x, int y) { return static_cast<std::uint32_t>(y * columns + x); };
    for (int y = 0; y + 1 < rows; ++y)
        for (int x = 0; x + 1 < columns; ++x) {
            for (const std::uint32_t v : {at(x, y), at(x + 1, y), at(x + 1, y + 1), at(x, y + 1)})
                data.face_vertices.push_back(v);
            data.face_offsets.push_back(static_cast<std::uint32_t>(data.face_vertices.size()));
        }
    return data;
}

/// Weights of control points i - 2 to i + 2, or at the ends of the two beyond and the two inside.
struct SplineRow {
    int first = 0;
    std::vector<double> value, derivative;
};

/// A quartic spline whose control points go on as an even function, at control point i: at the ends, which this moves
/// inwards from the control points, the second derivative in place of the first one, which is zero; towards greater i.
SplineRow quartic(int i, int count) {
    if (i > 0 && i + 1 < count)
        return {i - 2,
                {1.0 / 384, 76.0 / 384, 230.0 / 384, 76.0 / 384, 1.0 / 384},
                {-1.0 / 48, -22.0 / 48, 0, 22.0 / 48, 1.0 / 48}};
    const double sign = i == 0 ? 1 : -1;
    return {
        i == 0 ? -2 : i - 1, {1.0 / 24, 11.0 / 24, 11.0 / 24, 1.0 / 24}, {sign / 2, -sign / 2, -sign / 2, sign / 2}};
}

/// Number of the tagged corner that lies nearest: of those of finer meshes, the one that comes out of a corner.
int tip(const RuleMesh& mesh, const std::vector<Vec3d>& positions, const Vec3d& near) {
    int best = -1;
    for (int v = 0; v < mesh.vertex_count(); ++v)
        if (mesh.vertex_sharpness(v) > 0 &&
            (best < 0 || glm::length(positions[v] - near) < glm::length(positions[best] - near)))
            best = v;
    return best;
}

/// Where so many refinements of what is around a corner end.
Vec3d refined_away(RuleMesh mesh, std::vector<Vec3d> positions, int v, const SchemeInfo& scheme,
                   const RuleOptions& rules) {
    constexpr int k_steps = 50, k_rings = 10;
    detail::MeshPartFinder parts;
    for (int i = 0; i < k_steps; ++i) {
        const detail::MeshPart part = parts.find(mesh, std::span(&v, 1), k_rings);
        RuleStep step = scheme.step(part.mesh, rules);
        std::vector<Vec3d> finer(step.mesh.vertex_count(), Vec3d(0));
        for (int r = 0; r < step.mesh.vertex_count(); ++r)
            for (std::size_t t = 0; t < step.stencils.points(r).size(); ++t)
                finer[r] += step.stencils.weights(r)[t] * positions[part.vertex[step.stencils.points(r)[t]]];
        v = tip(step.mesh, finer, positions[v]);
        mesh = std::move(step.mesh);
        positions = std::move(finer);
    }
    return positions[v];
}

int reflected(int i, int count) { return i < 0 ? -1 - i : i >= count ? 2 * count - 1 - i : i; }

}  // namespace

TEST_SUITE_BEGIN("refine");

TEST_CASE("biquartic limits of an open grid are the even spline's, normals included") {
    constexpr int columns = 7, rows = 6;
    const ControlMeshData data = curved_grid(columns, rows);
    const ControlMesh mesh = ControlMesh::build(data);
    const PolygonMesh limit = refine(mesh, "biquartic", 0, {.limit = true, .normals = true});
    double apart = 0, tilted = 0;
    for (int y = 0; y < rows; ++y)
        for (int x = 0; x < columns; ++x) {
            const SplineRow u = quartic(x, columns), v = quartic(y, rows);
            Vec3d position(0), along_u(0), along_v(0);
            for (std::size_t j = 0; j < v.value.size(); ++j)
                for (std::size_t i = 0; i < u.value.size(); ++i) {
                    const int px = reflected(u.first + static_cast<int>(i), columns),
                              py = reflected(v.first + static_cast<int>(j), rows);
                    const Vec3d p = data.positions[py * columns + px];
                    position += u.value[i] * v.value[j] * p;
                    along_u += u.derivative[i] * v.value[j] * p;
                    along_v += u.value[i] * v.derivative[j] * p;
                }
            const std::size_t at = static_cast<std::size_t>(y) * columns + x;
            apart = std::max(apart, glm::length(position - limit.positions[at]));
            tilted = std::max(tilted, glm::length(glm::normalize(glm::cross(along_u, along_v)) - limit.normals[at]));
        }
    CHECK(apart < 1e-12);
    CHECK(tilted < 1e-12);
}

TEST_CASE(
    "[slow] limits of tagged corners under averaging are the same seen from any level, and where refinement ends") {
    // An L of quads: corners with one face by the boundary rule, and the one in the bend, with three, by a tag.
    ControlMeshData data = curved_grid(4, 4);
    constexpr std::size_t removed = 8;  // the last face
    data.face_vertices.resize(4 * removed);
    data.face_offsets.resize(removed + 1);
    data.positions.pop_back();
    constexpr int bend = 10;
    data.corners = {{bend, k_infinite_sharpness}};
    const ControlMesh mesh = ControlMesh::build(data);
    for (int m = 1; m <= 7; ++m) {
        if (m == 2) continue;
        CAPTURE(m);
        const SchemeInfo& scheme = *find_scheme("averaging");
        RefineOptions options{.limit = true, .normals = true};
        options.rules.averaging_steps = m;
        const RuleRefiner here(mesh, scheme, 0, options), below(mesh, scheme, 2, options);
        std::vector<Vec3d> positions(here.vertex_count()), normals(here.vertex_count()), finer(below.vertex_count()),
            finer_normals(below.vertex_count());
        here.refine(mesh.positions(), positions);
        here.normals(mesh.positions(), normals);
        below.refine(mesh.positions(), finer);
        below.normals(mesh.positions(), finer_normals);
        for (const int v : {0, 3, 12, bend}) {
            CAPTURE(v);
            CHECK(glm::length(finer[tip(below.last(), finer, positions[v])] - positions[v]) < 1e-12);
            const Vec3d end = refined_away(rule_mesh(mesh), {data.positions}, v, scheme, options.rules);
            CHECK(glm::length(end - positions[v]) < 1e-12);
            CHECK(glm::length(finer_normals[tip(below.last(), finer, positions[v])] - normals[v]) < 1e-9);
            // In the bend a dual scheme's surface, there that of one quad, may lie folded over.
            if (v != bend) CHECK(normals[v].z > 0.1);
        }
    }
}

TEST_SUITE_END();
