#include "planet_surface.hpp"

#include "../../hier/base/error.hpp"
#include "cube_roots.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <span>

namespace tetrakis::lod {

namespace {

constexpr int k_finest_level = 12;  // unless it is asked for

/// Radians between samples where they are nearest to each other.
double step_of(std::span<const HeightGrid> grids) {
    for (const HeightGrid& grid : grids) {
        detail::check_surface(grid);
        if (grids.size() == 1) break;
        if (grid.columns != grid.rows || grid.columns != grids[0].columns)
            throw Error(
                ErrorCode::invalid_input,
                fmt::format("the faces of a planet have to be squares of one size; one has {} columns and {} rows, "
                            "the first one {} columns",
                            grid.columns, grid.rows, grids[0].columns));
    }
    return grids.size() == 1 ? std::min(2 * M_PI / grids[0].columns, M_PI / grids[0].rows)
                             : 2.0 / (grids[0].columns - 1);
}

int level_of(std::span<const HeightGrid> grids, const PlanetOptions& options) {
    if (!(options.radius >= detail::k_smallest_radius && options.radius <= detail::k_largest_radius))
        throw Error(ErrorCode::invalid_input,
                    fmt::format("a planet's radius of {}; it has to be from {} to {}", options.radius,
                                detail::k_smallest_radius, detail::k_largest_radius));
    const double step = step_of(grids);
    if (options.level != 0) return options.level;
    return std::clamp(static_cast<int>(std::ceil(-std::log2(step) - 1e-9)), 1, k_finest_level);
}

/// @param x, y       in samples
/// @param is_closed  whether the last column is beside the first one
double between_samples(const HeightGrid& grid, double x, double y, bool is_closed) {
    x = is_closed ? x - grid.columns * std::floor(x / grid.columns) : std::clamp(x, 0.0, grid.columns - 1.0);
    y = std::clamp(y, 0.0, grid.rows - 1.0);
    const auto west = std::min(static_cast<std::uint32_t>(x), grid.columns - (is_closed ? 1u : 2u)),
               north = std::min(static_cast<std::uint32_t>(y), grid.rows - 2), east = (west + 1) % grid.columns;
    const auto along = [&](std::uint32_t row) {
        return std::lerp(double{grid.at(west, row)}, double{grid.at(east, row)}, x - west);
    };
    return std::lerp(along(north), along(north + 1), y - north);
}

}  // namespace

PlanetSurface::PlanetSurface(HeightGrid longitudes_latitudes, const PlanetOptions& options)
    : PlanetSurface(std::span(&longitudes_latitudes, 1), options) {}

PlanetSurface::PlanetSurface(std::array<HeightGrid, 6> faces, const PlanetOptions& options)
    : PlanetSurface(std::span(faces), options) {}

PlanetSurface::PlanetSurface(std::span<HeightGrid> grids, const PlanetOptions& options)
    : SampledSurface(detail::cube_roots(options.radius), level_of(grids, options), options.context),
      grids_(std::make_move_iterator(grids.begin()), std::make_move_iterator(grids.end())),
      radius_(options.radius),
      step_(step_of(grids_)) {
    for (const HeightGrid& grid : grids_)
        if (const double low = double{*std::ranges::min_element(grid.heights)}; !(radius_ + low > 0))
            throw Error(ErrorCode::invalid_input,
                        fmt::format("a height of {} is as deep as the planet, whose radius is {}", low, radius_));
    set_bounds(options.context);
}

std::uint64_t PlanetSurface::memory_bytes() const {
    std::uint64_t bytes = SampledSurface::memory_bytes();
    for (const HeightGrid& grid : grids_) bytes += grid.heights.capacity() * sizeof(float);
    return bytes;
}

double PlanetSurface::height(const Vec3d& direction) const {
    if (grids_.size() == 1) {
        const Vec2d at = detail::longitude_latitude(direction);
        return between_samples(grids_[0], at.x * grids_[0].columns - 0.5, at.y * grids_[0].rows - 0.5, true);
    }
    const Vec3d size = glm::abs(direction);
    const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
    const double ahead = size[axis], sign = direction[axis] > 0 ? 1 : -1;
    const auto face = static_cast<std::size_t>(2 * axis + (sign > 0 ? 0 : 1));
    const Vec2d at = axis == 0   ? Vec2d(-sign * direction.z, -direction.y)
                     : axis == 1 ? Vec2d(direction.x, sign * direction.z)
                                 : Vec2d(sign * direction.x, -direction.y);
    const double last = grids_[face].columns - 1.0;
    return between_samples(grids_[face], (at.x / ahead + 1) / 2 * last, (at.y / ahead + 1) / 2 * last, false);
}

Vec3d PlanetSurface::normal(const Vec3d& direction) const {
    const Vec3d up = glm::normalize(direction);
    const Vec3d east = glm::normalize(glm::cross(std::abs(up.z) < 0.9 ? Vec3d(0, 0, 1) : Vec3d(1, 0, 0), up)),
                north = glm::cross(up, east);
    const auto ground = [&](const Vec3d& aside) {
        const Vec3d at = glm::normalize(up + step_ * aside);
        return (radius_ + height(at)) * at;
    };
    return glm::normalize(glm::cross(ground(east) - ground(-east), ground(north) - ground(-north)));
}

Vec3d PlanetSurface::direction(const Site& site) const { return glm::normalize(detail::on_flat_roots(roots(), site)); }

void PlanetSurface::positions(std::span<const Site> sites, std::span<Vec3d> positions) const {
    for (std::size_t i = 0; i < sites.size(); ++i) {
        const Vec3d up = direction(sites[i]);
        positions[i] = (radius_ + height(up)) * up;
    }
}

void PlanetSurface::shade(std::span<const Site> sites, std::span<Place> places) const {
    for (std::size_t i = 0; i < sites.size(); ++i) {
        const Vec3d up = direction(sites[i]);
        places[i].normal = normal(up);
        places[i].uv = detail::longitude_latitude(up);
    }
}

}  // namespace tetrakis::lod
