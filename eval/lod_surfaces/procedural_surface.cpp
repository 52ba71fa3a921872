#include "procedural_surface.hpp"

#include "../../hier/base/error.hpp"
#include "../../hier/forest/bisection_path.hpp"
#include "../triangles/point_triangle.hpp"
#include "cube_roots.hpp"
#include "lattice_diamond.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <utility>
#include <vector>

namespace tetrakis::lod {

namespace {

/// A layer is the sum of a few waves.
struct Wave {
    double height, phase;  // phase: in turns
    Vec3d direction;       // turns a unit of length
};
constexpr int k_waves = 3;

}  // namespace

ProceduralHeights fractal_heights(double amplitude, double wavelength, int octaves, std::uint64_t seed) {
    if (!(amplitude >= 0 && std::isfinite(amplitude) && wavelength > 0 && std::isfinite(wavelength) && octaves >= 1 &&
          octaves <= 48))
        throw Error(
            ErrorCode::invalid_input,
            fmt::format("a fractal of {} octaves with amplitude {} and wavelength {}; octaves are from 1 to 48, "
                        "wavelengths positive",
                        octaves, amplitude, wavelength));
    std::mt19937_64 random(seed);
    const auto between = [&](double low, double high) {
        return low + (high - low) * 0x1p-64 * static_cast<double>(random());
    };
    std::vector<Wave> waves;
    ProceduralHeights heights;
    for (int i = 0; i < k_waves * octaves; ++i) {
        const double part = std::ldexp(1, -i / k_waves), z = between(-1, 1), turn = between(0, 2 * M_PI),
                     number = between(0.7, 1.4) / (wavelength * part), aside = std::sqrt(1 - z * z);
        waves.push_back({part * amplitude / k_waves, between(0, 1),
                         number * Vec3d(aside * std::cos(turn), aside * std::sin(turn), z)});
        heights.slope += 2 * M_PI * number * waves.back().height;
    }
    heights.height = [waves](const Vec3d& place) {
        double sum = 0;
        for (const Wave& wave : waves)
            sum += wave.height * std::sin(2 * M_PI * (glm::dot(wave.direction, place) + wave.phase));
        return sum;
    };
    // In a ball of radius r linear interpolation is off by at most r^2 / 2 times the largest second derivative.
    heights.deviation = [waves](double radius) {
        double sum = 0;
        for (const Wave& wave : waves)
            sum += wave.height *
                   std::min(2.0, 2 * M_PI * M_PI * glm::dot(wave.direction, wave.direction) * radius * radius);
        return sum;
    };
    heights.high = 2 * amplitude;
    heights.low = -heights.high;
    return heights;
}

ProceduralSurface ProceduralSurface::plane(double side, double finest, ProceduralHeights heights) {
    if (!(side > 0 && std::isfinite(side)))
        throw Error(ErrorCode::invalid_input, fmt::format("a plane with sides of {}", side));
    ControlMeshData data;
    for (const Vec2d& p : {Vec2d(-1, -1), Vec2d(1, -1), Vec2d(1, 1), Vec2d(-1, 1)})
        data.positions.emplace_back(side / 2 * p.x, side / 2 * p.y, 0);
    data.face_vertices = {0, 1, 2, 3};
    data.face_offsets = {0, 4};
    return {ControlMesh::build(std::move(data)), std::numeric_limits<double>::infinity(), side / 2, finest,
            std::move(heights)};
}

ProceduralSurface ProceduralSurface::ball(double radius, double finest, ProceduralHeights heights) {
    if (!(radius >= detail::k_smallest_radius && radius <= detail::k_largest_radius))
        throw Error(ErrorCode::invalid_input, fmt::format("a ball with a radius of {}; it has to be from {} to {}",
                                                          radius, detail::k_smallest_radius, detail::k_largest_radius));
    if (!(radius + heights.low > 0))
        throw Error(ErrorCode::invalid_input, fmt::format("heights of {} on a ball of radius {}", heights.low, radius));
    return {detail::cube_roots(radius), radius, radius, finest, std::move(heights)};
}

ProceduralSurface::ProceduralSurface(ControlMesh roots, double radius, double step, double finest,
                                     ProceduralHeights heights)
    : roots_(std::move(roots)), radius_(radius), step_(step), finest_step_(finest), heights_(std::move(heights)) {
    if (!(finest > 0 && finest <= 2 * step))
        throw Error(ErrorCode::invalid_input,
                    fmt::format("finest triangles with sides of {}; they have to be above 0 and up to {} here", finest,
                                2 * step));
    if (!heights_.height || !heights_.deviation)
        throw Error(ErrorCode::invalid_input, "procedural heights without a function of heights or of deviations");
    if (!(heights_.slope >= 0 && std::isfinite(heights_.slope) && heights_.low <= heights_.high &&
          std::isfinite(heights_.low) && std::isfinite(heights_.high)))
        throw Error(ErrorCode::invalid_input, fmt::format("heights from {} to {} with slopes of {}", heights_.low,
                                                          heights_.high, heights_.slope));
    max_depth_ = static_cast<int>(std::ceil(2 * (1 + std::log2(step / finest)) - 1e-9));
    if (max_depth_ > k_max_bisection_depth)
        throw Error(ErrorCode::unsupported,
                    fmt::format("triangles with sides of {} are too small; {} is the least here", finest,
                                step * std::exp2(1 - 0.5 * k_max_bisection_depth)));
    errors_.resize(static_cast<std::size_t>(max_depth_));
    double below = 0;
    for (int depth = max_depth_ - 1; depth >= 0; --depth) {
        const double length = step_ * std::exp2(1 - 0.5 * depth), own = error(length);
        if (!(own >= 0 && std::isfinite(own)))
            throw Error(ErrorCode::invalid_input,
                        fmt::format("an error of {} for triangles with sides of {}; deviations have to be finite and "
                                    "not negative",
                                    own, length));
        below = std::max(own, k_error_ratio * below);
        errors_[static_cast<std::size_t>(depth)] = below;
    }
}

double ProceduralSurface::error(double length) const {
    if (!std::isfinite(radius_)) return heights_.deviation(length / 2);
    // A triangle lies in a ball whose radius is its longest side over sqrt(3) (Jung 1901).
    const double off = heights_.deviation(length / std::sqrt(3.0));
    // Of a cap that holds the triangle, which is flat: how high it is. Heights are between those at places on the ball
    // and in its triangle; along a ray the triangle over three heights is at their harmonic mean.
    const double angle = std::min(M_PI / 2, 0.65 * length / radius_),
                 cap = 2 * radius_ * std::pow(std::sin(angle / 2), 2),
                 change = std::min(heights_.high - heights_.low, heights_.slope * length);
    return (1 + heights_.high / radius_ + heights_.slope) * cap + off +
           change * change / (4 * (radius_ + heights_.low));
}

Vec3d ProceduralSurface::base(const Vec3d& on_roots) const {
    return std::isfinite(radius_) ? radius_ * glm::normalize(on_roots) : glm::clamp(on_roots, -step_, step_);
}
Vec3d ProceduralSurface::up(const Vec3d& base) const {
    return std::isfinite(radius_) ? base / radius_ : Vec3d(0, 0, 1);
}
Vec3d ProceduralSurface::ground(const Vec3d& base) const {
    const double height = heights_.height(base);
    if (!std::isfinite(height))
        throw Error(ErrorCode::invalid_input,
                    fmt::format("a procedural height of {} at ({}, {}, {}); heights are finite", height, base.x, base.y,
                                base.z));
    return base + height * up(base);
}

void ProceduralSurface::places(std::span<const Site> sites, std::span<Place> places) const {
    for (std::size_t i = 0; i < sites.size(); ++i) {
        const Site& site = sites[i];
        const Vec3d at = base(detail::on_flat_roots(roots_, site)), z = up(at);
        Place& place = places[i];
        place.position = place.on_edge = ground(at);
        const std::uint32_t n = 1u << site.level;
        if (site.at.x != site.at.y || (site.at.x != 0 && site.at.x != n)) {
            const detail::LatticeDiamond diamond(
                {static_cast<std::int32_t>(site.at.x), static_cast<std::int32_t>(site.at.y)});
            const auto end = [&](const detail::LatticePlace& p) {
                return ground(base(detail::on_flat_roots(roots_, site.root, std::ldexp(p.x, -site.level),
                                                         std::ldexp(p.y, -site.level))));
            };
            const Vec3d start = end(diamond.ends[0]), along = end(diamond.ends[1]) - start;
            place.on_edge = start + detail::nearest_on_segment(along, place.position - start) * along;
        }
        const Vec3d x = glm::normalize(glm::cross(std::abs(z.x) < 0.9 ? Vec3d(1, 0, 0) : Vec3d(0, 1, 0), z)),
                    y = glm::cross(z, x);
        const auto beside = [&](const Vec3d& aside) { return ground(base(at + finest_step_ * aside)); };
        place.normal = glm::normalize(glm::cross(beside(x) - beside(-x), beside(y) - beside(-y)));
        place.uv = std::isfinite(radius_) ? detail::longitude_latitude(at) : Vec2d(at) / (2 * step_) + 0.5;
    }
}

void ProceduralSurface::bounds(std::span<const Site> sites, std::span<DiamondBounds> bounds) const {
    // The middles of the diamonds that a split makes possible are 1 / (2 sqrt 2) of its longest side away, and their
    // sides are shorter by sqrt(2). This is the sum over all further splits.
    const double reach = 1 / (2 * M_SQRT2 - 2);
    for (std::size_t i = 0; i < sites.size(); ++i) {
        const Site& site = sites[i];
        const bool is_centre = (site.at.x & site.at.y & 1u) != 0;
        const int depth = 2 * site.level - (is_centre ? 1 : 0);
        const double length = step_ * std::exp2(1 - 0.5 * depth) *
                              (std::isfinite(radius_) ? 1 + std::max(0.0, heights_.high) / radius_ : 1);
        const Vec3d at = base(detail::on_flat_roots(roots_, site));
        // Heights differ by the slope times the way, along directions that differ from the middle's by way / radius.
        const Vec3d rise = heights_.slope * glm::min(glm::abs(up(at)) + reach * length / radius_, Vec3d(1));
        bounds[i] = {ground(at), reach * length * (1.0 + rise), errors_[static_cast<std::size_t>(depth)]};
    }
}

}  // namespace tetrakis::lod
