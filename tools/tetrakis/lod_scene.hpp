#pragma once

#include "../../eval/lod/view.hpp"
#include "../../eval/lod_surfaces/surface.hpp"
#include "../../eval/lod_terrain/tiled_terrain.hpp"
#include "../../hier/mesh/control_mesh.hpp"
#include "../../hier/obj/obj_reader.hpp"
#include "files.hpp"
#include "run_options.hpp"

#include <cmath>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace tetrakis::cli {

/// Where the camera is and what it looks at, frame by frame.
struct CameraPlace {
    Vec3d eye{}, target{};
    double fov_degrees = 60;
    Vec3d about_up{0, 0, 1};

    Vec3d forward() const { return glm::normalize(target - eye); }
    /// about_up, but where it looks along that: another one.
    Vec3d up() const {
        return std::abs(glm::dot(forward(), about_up)) < 0.999 ? about_up : Vec3d(about_up.y, about_up.z, about_up.x);
    }
    lod::Camera lod_camera(int width, int height) const;
};

/// What `tetrakis lod` flies over.
struct LodScene {
    std::unique_ptr<const lod::Surface> surface;
    const lod::TiledTerrain* tiles = nullptr;  ///< the same, where it is one
    std::string description;                   ///< "512 x 512 samples"
    std::function<double(const Vec3d&)> low;   ///< of terrains and planets: the height of the ground below a place
    Vec3d middle{};
    double size = 1;        ///< of terrains the shorter side, else the diameter
    Vec3d up{0, 0, 1};      ///< of meshes y
    bool is_round = false;  ///< up is outwards
    std::uint64_t surface_bytes = 0;
};

/// A scene on the command line: heights, tiles of them, heights around a planet, a control mesh, or a fractal.
struct LodInput {
    HeightInput heights;                       ///< without a path: a fractal
    std::vector<std::filesystem::path> faces;  ///< of a planet from the six faces of a cube: the other five
    std::optional<std::uint64_t> fractal;      ///< its seed
    double planet_radius = 0;                  ///< 0: no planet
    std::string scheme;
    int level = 0;  ///< 0: the surface's own
    std::uint64_t cache_bytes = lod::TiledTerrainOptions().cache_bytes;
    ReadOptions read_mesh;

    void add(CommandLine command);
    std::filesystem::path title() const;  ///< for messages: the (first) file, or "fractal 7"
    /// The files that are read, and `path`.
    std::vector<std::filesystem::path> inputs(const std::filesystem::path& path) const;
    /// @param warnings  receives what was filled or cut
    /// @throws InputError, UsageError, Error (memory_limit, cancelled)
    LodScene load(const Run& process, std::vector<std::string>& warnings) const;
};

/// The cameras of a file: a list of {"eye": [x, y, z], "target": [x, y, z], "fov_degrees": a}, on which the frames lie
/// at equal steps.
/// @throws InputError
std::vector<CameraPlace> cameras_of(const std::filesystem::path& path, std::uint32_t frames);

/// Around the middle of a scene: from outside, looking at it; or above the ground, looking ahead.
std::vector<CameraPlace> circle(const LodScene& scene, std::uint32_t frames, bool fly);

}  // namespace tetrakis::cli
