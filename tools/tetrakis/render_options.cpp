#include "render_options.hpp"

#include <charconv>
#include <cmath>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace tetrakis::cli {
namespace {

/// Numbers with one separator between them; nothing where there is anything else.
template <class T>
std::optional<std::vector<T>> split_numbers(std::string_view text, char separator) {
    std::vector<T> numbers;
    for (const char *at = text.data(), *const end = at + text.size();; ++at) {
        T number{};
        const auto [rest, error] = std::from_chars(at, end, number);
        if (error != std::errc{}) return std::nullopt;
        numbers.push_back(number);
        if (rest == end) return numbers;
        if (*rest != separator) return std::nullopt;
        at = rest;
    }
}

void set_size(const std::string& text, RenderOptions& render) {
    constexpr int k_largest_side = 16384;
    const auto sides = split_numbers<int>(text, 'x');
    if (!sides || sides->size() != 2 || (*sides)[0] < 1 || (*sides)[1] < 1 || (*sides)[0] > k_largest_side ||
        (*sides)[1] > k_largest_side)
        throw CLI::ValidationError("--size", text + " is no size such as 1200x900");
    render.width = (*sides)[0];
    render.height = (*sides)[1];
}

void set_camera(const std::string& text, RenderOptions& render) {
    const auto angles = split_numbers<double>(text, ',');
    if (!angles || angles->size() != 2 || !std::isfinite((*angles)[0]) || !(std::abs((*angles)[1]) <= 90))
        throw CLI::ValidationError("--camera", text + " is no pair of degrees such as 32,20 (elevation -90 to 90)");
    render.view.azimuth_degrees = std::remainder((*angles)[0], 360.0);
    render.view.elevation_degrees = (*angles)[1];
}

}  // namespace

void add_view_options(CLI::App& command, RenderOptions& render) {
    command
        .add_option_function<std::string>(
            "--size", [&render](const std::string& text) { set_size(text, render); },
            "Width and height of the picture in pixels; default: 1200x900")
        ->type_name("WxH");
    command
        .add_option_function<std::string>(
            "--camera", [&render](const std::string& text) { set_camera(text, render); },
            "Where to look from, in degrees: turned about the model from its front, then raised; default: 32,20")
        ->type_name("AZIMUTH,ELEVATION");
    command
        .add_option_function<std::string>(
            "--up",
            [&render](const std::string& axis) { render.view.up = axis == "z" ? Vec3d(0, 0, 1) : Vec3d(0, 1, 0); },
            "The model's axis that points upwards: y (default) or z")
        ->type_name("AXIS")
        ->check(CLI::IsMember({"y", "z"}).description(""));
}

std::string given_view_option(const CLI::App& command) {
    for (const char* name : {"--size", "--camera", "--up"})
        if (command.count(name) != 0) return name;
    return {};
}

}  // namespace tetrakis::cli
