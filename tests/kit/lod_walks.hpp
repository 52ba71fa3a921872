#pragma once

#include "../../eval/lod/view.hpp"
#include "../../eval/terrain/height_grid.hpp"
#include "judged_terrain.hpp"
#include "surface_topology.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <random>
#include <span>
#include <vector>

namespace tetrakis::test {

/// A view's buffers as a graphics card has them: only the ranges that updates report are copied.
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
    bool equals(std::span<const lod::Vertex> of, std::span<const lod::Triangle> with) const {
        return vertices.size() == of.size() && triangles.size() == with.size() &&
               std::memcmp(vertices.data(), of.data(), of.size_bytes()) == 0 &&
               std::memcmp(triangles.data(), with.data(), with.size_bytes()) == 0;
    }
    bool equals(const lod::View& view) const { return equals(view.vertices(), view.triangles()); }
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

/// The direction that an octahedral normal stands for (Meyer et al. 2010), without code of the library.
inline Vec3d unfolded(const std::array<std::int16_t, 2>& n) {
    Vec3d v(n[0], n[1], 32767 - std::abs(n[0]) - std::abs(n[1]));
    const double below = std::max(0.0, -v.z);
    v -= Vec3d(std::copysign(below, v.x), std::copysign(below, v.y), 0);
    return glm::normalize(v);
}

/// Projection and visibility of a camera, without code of the library.
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

/// Checks that the used triangles form a disc and cover the grid exactly once.
inline void check_whole(const lod::View& view, const HeightGrid& grid) {
    const auto triangles = used(view);
    REQUIRE(triangles.size() == view.leaf_count());
    const SurfaceTopology whole = topology(triangles);
    REQUIRE(whole.fault.empty());
    REQUIRE(whole.euler == 1);
    REQUIRE(whole.boundary_loops == 1);
    double area = 0;
    for (const auto& t : triangles) {
        const double part = twice_area(position(view, t[0]), position(view, t[1]), position(view, t[2]));
        REQUIRE(part > 0);
        area += part / 2;
    }
    REQUIRE(area ==
            doctest::Approx(grid.spacing.x * grid.spacing.y * (grid.columns - 1) * (grid.rows - 1)).epsilon(1e-6));
}

/// Largest error, in pixels, of the samples that the camera sees.
inline double judged_pixels(const lod::View& view, const HeightGrid& grid, const lod::Camera& camera) {
    const Sight sight(camera);
    double largest = 0;
    for (const auto& [i, j, k] : used(view))
        visit_samples(grid, {position(view, i), position(view, j), position(view, k)},
                      [&](std::uint32_t column, std::uint32_t row, double height) {
                          const Vec3d at(grid.origin.x + column * grid.spacing.x, grid.origin.y - row * grid.spacing.y,
                                         grid.at(column, row));
                          if (sight.sees(at))
                              largest = std::max(largest,
                                                 std::abs(height - at.z) * sight.pixels / glm::length(at - camera.eye));
                      });
    return largest;
}

/// A camera that wanders over a grid, jumps now and then, and looks about.
class Wanderer {
  public:
    Wanderer(const HeightGrid& grid, unsigned seed) : grid_(grid), random_(seed) {}
    lod::Camera next() {
        std::uniform_real_distribution<double> one(0, 1);
        const double width = (grid_.columns - 1) * grid_.spacing.x, height = (grid_.rows - 1) * grid_.spacing.y;
        if (frame_++ % 40 == 0) {
            at_ = {one(random_), one(random_)};
            high_ = std::pow(10, 2 * one(random_) - 1.5) * width / 10;
            turn_ = 6.28 * one(random_);
        }
        const double speed = 0.01 * one(random_);
        at_ += speed * Vec2d(std::sin(turn_), std::cos(turn_));
        turn_ += 0.2 * (one(random_) - 0.5);
        lod::Camera camera;
        camera.eye = {grid_.origin.x + at_.x * width, grid_.origin.y - (1 - at_.y) * height, high_};
        camera.direction = {std::sin(turn_), std::cos(turn_), -0.4};
        camera.width = 800;
        camera.height = 600;
        return camera;
    }

  private:
    const HeightGrid& grid_;
    std::mt19937 random_;
    int frame_ = 0;
    Vec2d at_{};
    double high_ = 1, turn_ = 0;
};

}  // namespace tetrakis::test
