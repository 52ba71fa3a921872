#include "tetrakis/eval/shading_normals.hpp"

#include "tetrakis/hier/parallel.hpp"

#include <glm/trigonometric.hpp>

#include <cmath>

namespace tetrakis::detail {

namespace {

// The corners (3 t + k) at each vertex, one after the other, by number.
struct VertexCorners {
    std::vector<std::uint64_t> first, corners;

    explicit VertexCorners(const TriangleMesh& mesh) : first(mesh.positions.size() + 1, 0) {
        for (const auto& triangle : mesh.triangles)
            for (const std::uint32_t v : triangle) ++first[v + 1];
        for (std::size_t v = 1; v < first.size(); ++v) first[v] += first[v - 1];
        corners.resize(first.back());
        std::vector<std::uint64_t> next(first.begin(), first.end() - 1);
        for (std::uint64_t t = 0; t < mesh.triangles.size(); ++t)
            for (std::uint64_t k = 0; k < 3; ++k) corners[next[mesh.triangles[t][k]]++] = 3 * t + k;
    }
};

double corner_angle(const TriangleMesh& mesh, std::uint64_t corner) {
    const auto& triangle = mesh.triangles[corner / 3];
    const std::uint64_t k = corner % 3;
    const Vec3d p = mesh.positions[triangle[k]];
    const Vec3d a = mesh.positions[triangle[(k + 1) % 3]] - p, b = mesh.positions[triangle[(k + 2) % 3]] - p;
    return std::atan2(glm::length(glm::cross(a, b)), glm::dot(a, b));
}

}  // namespace

Vec3d face_normal(const TriangleMesh& mesh, std::size_t t) {
    const auto& [a, b, c] = mesh.triangles[t];
    // Scaled first, so that squares of tiny or huge sides stay in range.
    const Vec3d ab = mesh.positions[b] - mesh.positions[a], ac = mesh.positions[c] - mesh.positions[a];
    const double l = glm::length(ab), m = glm::length(ac);
    if (!(l > 0) || !(m > 0)) return Vec3d(0);
    return unit_or_zero(glm::cross(ab / l, ac / m));
}

std::vector<std::array<Vec3f, 3>> corner_normals(const TriangleMesh& mesh, double crease_degrees) {
    const double least_cosine = std::cos(glm::radians(crease_degrees));
    const VertexCorners around(mesh);
    std::vector<std::array<Vec3f, 3>> result(mesh.triangles.size());
    for_each_index(static_cast<std::uint32_t>(mesh.triangles.size()), [&](std::uint32_t t) {
        const Vec3d face = face_normal(mesh, t);
        for (std::size_t k = 0; k < 3; ++k) {
            const std::uint32_t v = mesh.triangles[t][k];
            if (!mesh.normals.empty() && glm::dot(mesh.normals[v], face) >= least_cosine) {
                result[t][k] = Vec3f(mesh.normals[v]);
                continue;
            }
            Vec3d sum(0);
            for (std::uint64_t i = around.first[v]; i < around.first[v + 1]; ++i) {
                const Vec3d other = face_normal(mesh, around.corners[i] / 3);
                if (glm::dot(other, face) >= least_cosine) sum += corner_angle(mesh, around.corners[i]) * other;
            }
            const double length = glm::length(sum);
            result[t][k] = Vec3f(length > 0 ? sum / length : face);
        }
    });
    return result;
}

}  // namespace tetrakis::detail
