#include "camera_path.hpp"

#include "commands.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <fstream>
#include <iterator>
#include <string>

namespace tetrakis::cli {

lod::Camera CameraPlace::lod_camera(std::uint32_t width, std::uint32_t height) const {
    return {.eye = eye,
            .direction = forward(),
            .up = up(),
            .vertical_fov = fov_degrees * M_PI / 180,
            .width = width,
            .height = height};
}

std::vector<CameraPlace> read_camera_path(const std::filesystem::path& path, std::uint32_t frames) {
    std::ifstream file(path);
    if (!file) throw InputError(fmt::format("{}: cannot be read", path.string()));
    const std::string text{std::istreambuf_iterator<char>(file), {}};
    std::vector<CameraPlace> given;
    try {
        for (const nlohmann::json& entry : nlohmann::json::parse(text)) {
            const auto vec = [&](const char* key) {
                const auto v = entry.at(key).get<std::array<double, 3>>();
                return Vec3d(v[0], v[1], v[2]);
            };
            given.push_back({vec("eye"), vec("target"), entry.value("fov_degrees", 60.0)});
        }
    } catch (const nlohmann::json::exception& error) {
        const std::string reason = error.what();  // "[json.exception.type_error.304] cannot ..."
        throw InputError(
            fmt::format("{}: camera {}: {}; a camera path is a list of {{\"eye\": [x, y, z], \"target\": "
                        "[x, y, z], \"fov_degrees\": a}}",
                        path.string(), given.size(), reason.substr(reason.find("] ") + 2)));
    }
    for (std::size_t i = 0; i < given.size(); ++i)
        if (!(glm::length(given[i].target - given[i].eye) > 0 && given[i].fov_degrees > 0 &&
              given[i].fov_degrees < 180))
            throw InputError(
                fmt::format("{}: camera {} looks nowhere: its target is its eye, or its opening is not "
                            "between 0 and 180 degrees",
                            path.string(), i));
    if (given.empty()) throw InputError(fmt::format("{}: a camera path without cameras", path.string()));
    std::vector<CameraPlace> views;
    for (std::uint32_t i = 0; i < frames; ++i) {
        const double at = frames == 1 ? 0 : static_cast<double>(i) * (given.size() - 1.0) / (frames - 1.0);
        const auto k = static_cast<std::size_t>(at);
        const CameraPlace &a = given[k], &b = given[std::min(k + 1, given.size() - 1)];
        const double t = at - std::floor(at);
        views.push_back(
            {glm::mix(a.eye, b.eye, t), glm::mix(a.target, b.target, t), glm::mix(a.fov_degrees, b.fov_degrees, t)});
    }
    return views;
}

std::vector<CameraPlace> circle(const HeightGrid& grid, std::uint32_t frames, Circle kind) {
    const double width = (grid.columns - 1) * grid.spacing.x, height = (grid.rows - 1) * grid.spacing.y;
    const auto [low, high] = std::minmax_element(grid.heights.begin(), grid.heights.end());
    const double range = double{*high} - double{*low}, size = std::min(width, height);
    const Vec3d middle(grid.origin.x + width / 2, grid.origin.y - height / 2, double{*low} + 0.3 * range);
    const auto ground = [&](const Vec3d& p) {
        const auto sample = [](double at, std::uint32_t count) {
            return static_cast<std::uint32_t>(std::clamp(std::round(at), 0.0, count - 1.0));
        };
        return double{grid.at(sample((p.x - grid.origin.x) / grid.spacing.x, grid.columns),
                              sample((grid.origin.y - p.y) / grid.spacing.y, grid.rows))};
    };
    std::vector<CameraPlace> views;
    double above = 0;
    for (std::uint32_t i = 0; i < frames; ++i) {
        const double turn = 2 * M_PI * i / frames;
        const Vec3d out(std::cos(turn), std::sin(turn), 0), ahead(-std::sin(turn), std::cos(turn), 0);
        CameraPlace view;
        if (kind == Circle::fly) {
            view.eye = middle + 0.42 * size * out;
            // As high as the ground asks for, without jumps.
            const double wanted = std::max(ground(view.eye), ground(view.eye + 0.1 * size * ahead)) + 0.12 * size;
            above = i == 0 ? wanted : above + 0.2 * (wanted - above);
            view.eye.z = std::max(above, ground(view.eye) + 0.03 * size);
            view.target = view.eye + size * (ahead - 0.8 * out) - Vec3d(0, 0, 0.2 * size);
        } else {
            view.eye = middle + 1.2 * size * out + Vec3d(0, 0, 0.7 * size + range);
            view.target = middle;
        }
        views.push_back(view);
    }
    return views;
}

}  // namespace tetrakis::cli
