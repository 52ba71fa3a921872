#pragma once

#include "../../eval/lod/view.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <vector>

namespace tetrakis::test {

/// A view's buffers as a graphics card has them: only what updates said to have changed was copied.
struct Copied {
    std::vector<lod::Vertex> vertices;
    std::vector<lod::Triangle> triangles;

    void take(const lod::View& view, const lod::Update& update) {
        vertices.resize(view.vertices().size());
        triangles.resize(view.triangles().size());
        for (const auto& [first, count] : update.vertices)
            std::memcpy(&vertices[first], &view.vertices()[first], count * sizeof(lod::Vertex));
        for (const auto& [first, count] : update.triangles)
            std::memcpy(&triangles[first], &view.triangles()[first], count * sizeof(lod::Triangle));
    }
    bool equals(const lod::View& view) const {
        return vertices.size() == view.vertices().size() && triangles.size() == view.triangles().size() &&
               std::memcmp(vertices.data(), view.vertices().data(), vertices.size() * sizeof(lod::Vertex)) == 0 &&
               std::memcmp(triangles.data(), view.triangles().data(), triangles.size() * sizeof(lod::Triangle)) == 0;
    }
};

inline std::vector<lod::Triangle> used(const lod::View& view) {
    std::vector<lod::Triangle> triangles;
    for (const lod::Triangle& t : view.triangles())
        if (t != lod::Triangle{}) triangles.push_back(t);
    return triangles;
}

inline Vec3d position(const lod::View& view, std::uint32_t v) {
    const auto& p = view.vertices()[v].position;
    return view.origin() + Vec3d(p[0], p[1], p[2]);
}

/// What a camera sees, without anything of the library's.
struct Sight {
    Vec3d eye, forward, right, up;
    double tan_x, tan_y, pixels;  ///< pixels of length 1 at distance 1

    explicit Sight(const lod::Camera& camera)
        : eye(camera.eye),
          forward(glm::normalize(camera.direction)),
          right(glm::normalize(glm::cross(forward, camera.up))),
          up(glm::cross(right, forward)),
          tan_x(std::tan(camera.vertical_fov / 2) * camera.width / camera.height),
          tan_y(std::tan(camera.vertical_fov / 2)),
          pixels(camera.height / (2 * tan_y)) {}
    bool sees(const Vec3d& p) const {
        const double depth = glm::dot(p - eye, forward);
        return depth > 0 && std::abs(glm::dot(p - eye, right)) < tan_x * depth &&
               std::abs(glm::dot(p - eye, up)) < tan_y * depth;
    }
};

}  // namespace tetrakis::test
