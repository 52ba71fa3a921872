#include "../../hier/mesh/control_mesh.hpp"
#include "../../refine/uniform/refine.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
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

TEST_SUITE_END();
