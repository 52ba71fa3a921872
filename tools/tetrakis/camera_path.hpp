#pragma once

#include "../../eval/lod/height_grid.hpp"
#include "../../eval/lod/view.hpp"

#include <glm/geometric.hpp>

#include <cmath>
#include <cstdint>
#include <filesystem>
#include <vector>

namespace tetrakis::cli {

/// Where the camera is and what it looks at, frame by frame.
struct CameraPlace {
    Vec3d eye{}, target{};
    double fov_degrees = 60;

    Vec3d forward() const { return glm::normalize(target - eye); }
    /// z, but where it looks along that.
    Vec3d up() const { return std::abs(forward().z) < 0.999 ? Vec3d(0, 0, 1) : Vec3d(0, 1, 0); }
    lod::Camera lod_camera(std::uint32_t width, std::uint32_t height) const;
};

/// The cameras of a file: a list of {"eye": [x, y, z], "target": [x, y, z], "fov_degrees": a}, on which the frames lie
/// at equal steps.
/// @throws InputError  the file cannot be read, or is no such list
std::vector<CameraPlace> read_camera_path(const std::filesystem::path& path, std::uint32_t frames);

/// Around the middle of the grid: from outside, looking at it; or above the ground, looking ahead.
enum class Circle { orbit, fly };
std::vector<CameraPlace> circle(const HeightGrid& grid, std::uint32_t frames, Circle kind);

}  // namespace tetrakis::cli
