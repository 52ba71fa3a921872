#pragma once

#include "../../eval/lod/view.hpp"
#include "../../eval/terrain/height_grid.hpp"

#include "judged_terrain.hpp"
#include "lod_views.hpp"
#include "surface_topology.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>

namespace tetrakis::test {

/// The used triangles are a disc, and cover the grid once.
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

/// The largest error of a sample, in pixels, of those that the camera sees.
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
