#include "terrain_lattice.hpp"

#include "../terrain/grid_triangle.hpp"

#include <algorithm>
#include <bit>
#include <cstddef>
#include <utility>

namespace tetrakis::detail {

namespace {

// More roots than this are for long strips alone, where fewer would need more than this many lattice points a sample.
constexpr std::uint32_t k_most_roots = 64, k_most_points_a_sample = 16;

constexpr std::uint32_t pieces(std::uint32_t length, std::uint32_t side) { return (length + side - 1) / side; }

/// Exponent of the roots' side, of 2^result steps, with which the lattice for a grid has the fewest points.
int best_log_side(std::uint32_t width, std::uint32_t height) {
    int best = 0;
    std::uint64_t fewest = ~std::uint64_t{0};
    // In larger squares, lines across a narrow strip would coincide.
    const std::uint64_t largest = std::uint64_t{k_grid_unit} / 2 * std::min(width, height);
    for (int log_side = std::clamp(static_cast<int>(std::bit_width(largest)) - 1, 1, 25); log_side >= 1; --log_side) {
        const std::uint32_t side = 1u << log_side;
        const std::uint64_t roots = std::uint64_t{pieces(width, side)} * pieces(height, side);
        if (roots > k_most_roots && fewest / k_most_points_a_sample <= std::uint64_t{width} * height) break;
        const std::uint64_t points = roots << (2 * log_side);
        if (points < fewest) {
            fewest = points;
            best = log_side;
        }
    }
    return best;
}

/// Grid coordinates of the lattice's lines along one axis.
std::vector<std::int32_t> lines(std::uint32_t length, int log_side) {
    const std::uint32_t side = 1u << log_side, count = pieces(length, side);
    std::vector<std::int32_t> places(std::size_t{count} * side + 1);
    for (std::size_t i = 0; i <= count; ++i)
        places[i * side] = static_cast<std::int32_t>(i * length / count) * k_grid_unit;
    for (std::size_t step = side / 2; step > 0; step /= 2)
        for (std::size_t i = step; i < places.size(); i += 2 * step)
            places[i] = middle(places[i - step], places[i + step]);
    return places;
}

}  // namespace

TerrainLattice::TerrainLattice(const HeightGrid& grid)
    : log_side(best_log_side(grid.columns - 1, grid.rows - 1)),
      origin(grid.origin),
      spacing(grid.spacing),
      xs(lines(grid.columns - 1, log_side)),
      ys(lines(grid.rows - 1, log_side)) {}

ControlMesh TerrainLattice::make_roots(const std::function<Vec3d(LatticePlace)>& position) {
    const std::uint32_t side = 1u << log_side;
    const auto across = static_cast<std::uint32_t>(xs.size() - 1) / side,
               down = static_cast<std::uint32_t>(ys.size() - 1) / side;
    const auto corner = [&](std::uint32_t c, std::uint32_t r) {
        return LatticePlace{static_cast<std::int32_t>(c * side), static_cast<std::int32_t>(r * side)};
    };
    ControlMeshData data;
    for (std::uint32_t r = 0; r <= down; ++r)
        for (std::uint32_t c = 0; c <= across; ++c) data.positions.push_back(position(corner(c, r)));
    data.face_offsets = {0};
    frames_.clear();
    for (std::uint32_t r = 0; r < down; ++r)
        for (std::uint32_t c = 0; c < across; ++c) {
            const std::uint32_t v = r * (across + 1) + c, below = v + across + 1;
            data.face_vertices.insert(data.face_vertices.end(), {v, below, below + 1, v + 1});
            data.face_offsets.push_back(static_cast<std::uint32_t>(data.face_vertices.size()));
            frames_.insert(frames_.end(), {{corner(c, r), {0, 1, 1, 0}},
                                           {corner(c, r + 1), {1, 0, 0, -1}},
                                           {corner(c + 1, r + 1), {0, -1, -1, 0}},
                                           {corner(c + 1, r), {-1, 0, 0, 1}}});
        }
    return ControlMesh::build(std::move(data));
}

std::optional<LatticePlace> TerrainLattice::square_at(const Vec2d& place) const {
    // Borders are compared as sums: the quotients below may be slightly beyond them by rounding.
    if (!(place.x >= origin.x && place.x <= east(last_x()) && place.y <= origin.y && place.y >= north(last_y())))
        return {};
    const double x = (place.x - origin.x) / spacing.x * k_grid_unit, y = (origin.y - place.y) / spacing.y * k_grid_unit;
    const auto line = [](const std::vector<std::int32_t>& lines, double at) {
        const auto after = std::upper_bound(lines.begin(), lines.end(), at);
        return static_cast<std::int32_t>(std::min<std::ptrdiff_t>(after - lines.begin(), std::ssize(lines) - 1) - 1);
    };
    return LatticePlace{line(xs, x), line(ys, y)};
}

lod::GroundPoint ground(const GroundSquare& square, const Vec2d& place) {
    const Vec2d along = square[1][1] - square[1][0], off = place - Vec2d(square[1][0]);
    const auto& [a, b, c] = square[along.x * off.y > along.y * off.x ? 1 : 0];
    const Plane plane(a, b, c);
    return {-plane.above(Vec3d(place, 0)), glm::normalize(Vec3d(-plane.slopes, 1))};
}

Vec3d sample_normal(const HeightGrid& grid, std::uint32_t column, std::uint32_t row) {
    const std::uint32_t west = column > 0 ? column - 1 : 0, east = std::min(column + 1, grid.columns - 1),
                        north = row > 0 ? row - 1 : 0, south = std::min(row + 1, grid.rows - 1);
    const double slope_x = (double{grid.at(east, row)} - double{grid.at(west, row)}) / (grid.spacing.x * (east - west)),
                 slope_y = (double{grid.at(column, north)} - double{grid.at(column, south)}) /
                           (grid.spacing.y * (south - north));
    return glm::normalize(Vec3d(-slope_x, -slope_y, 1));
}

}  // namespace tetrakis::detail
