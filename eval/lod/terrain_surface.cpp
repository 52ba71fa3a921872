#include "terrain_surface.hpp"

#include "../../hier/base/error.hpp"
#include "../../hier/base/parallel.hpp"
#include "grid_triangle.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <utility>

namespace tetrakis::lod {

namespace {

using detail::GridTriangle;
using detail::GridVertex;
using detail::in_samples;
using detail::k_grid_unit;
using detail::LatticeDiamond;

constexpr int k_log_cell = 3;  // of the finest cells whose heights are known
constexpr std::uint32_t k_most_roots = 64;

constexpr std::uint32_t pieces(std::uint32_t length, std::uint32_t side) { return (length + side - 1) / side; }

/// Into what squares, of 2^result steps, a lattice for a grid is cut so that it has the fewest points.
int best_log_side(std::uint32_t width, std::uint32_t height) {
    int best = 0;
    std::uint64_t fewest = ~std::uint64_t{0};
    for (int log_side = 25; log_side >= 1; --log_side) {
        const std::uint32_t side = 1u << log_side;
        const std::uint64_t roots = std::uint64_t{pieces(width, side)} * pieces(height, side);
        if (best != 0 && roots > k_most_roots) break;
        const std::uint64_t points = roots << (2 * log_side);
        if (points < fewest) {
            fewest = points;
            best = log_side;
        }
    }
    return best;
}

/// Places of the lattice's lines along one axis.
std::vector<std::int32_t> lines(std::uint32_t length, int log_side) {
    const std::uint32_t side = 1u << log_side, count = pieces(length, side);
    std::vector<std::int32_t> places(std::size_t{count} * side + 1);
    for (std::size_t i = 0; i <= count; ++i)
        places[i * side] = static_cast<std::int32_t>(i * length / count) * k_grid_unit;
    for (std::size_t step = side / 2; step > 0; step /= 2)
        for (std::size_t i = step; i < places.size(); i += 2 * step)
            places[i] = detail::middle(places[i - step], places[i + step]);
    return places;
}

}  // namespace

TerrainSurface::TerrainSurface(HeightGrid grid, const RunContext& context) : grid_(std::move(grid)) {
    detail::check_surface(grid_);
    with_threads(context, [&] {
        set_roots();
        set_heights();
        set_errors(context);
    });
}

std::uint64_t TerrainSurface::memory_bytes() const {
    std::uint64_t bytes = grid_.heights.capacity() * sizeof(float) + codes_.capacity() +
                          (xs_.capacity() + ys_.capacity()) * sizeof(std::int32_t);
    for (const HeightLevel& level : heights_) bytes += level.cells.capacity() * sizeof(Heights);
    return bytes;
}

void TerrainSurface::set_roots() {
    log_side_ = best_log_side(grid_.columns - 1, grid_.rows - 1);
    xs_ = lines(grid_.columns - 1, log_side_);
    ys_ = lines(grid_.rows - 1, log_side_);
    const std::uint32_t side = 1u << log_side_;
    const auto across = static_cast<std::uint32_t>(xs_.size() - 1) / side,
               down = static_cast<std::uint32_t>(ys_.size() - 1) / side;
    ControlMeshData data;
    std::vector<LatticePlace> corners;
    for (std::uint32_t r = 0; r <= down; ++r)
        for (std::uint32_t c = 0; c <= across; ++c) {
            corners.push_back({static_cast<std::int32_t>(c * side), static_cast<std::int32_t>(r * side)});
            data.positions.push_back(position(corners.back()));
        }
    data.face_offsets = {0};
    for (std::uint32_t r = 0; r < down; ++r)
        for (std::uint32_t c = 0; c < across; ++c) {
            const std::uint32_t v = r * (across + 1) + c, below = v + across + 1;
            data.face_vertices.insert(data.face_vertices.end(), {v, below, below + 1, v + 1});
            data.face_offsets.push_back(static_cast<std::uint32_t>(data.face_vertices.size()));
        }
    roots_ = ControlMesh::build(std::move(data));
    for (std::uint32_t i = 0; i < roots_.halfedge_count(); ++i) {
        const HalfedgeId h(i);
        const LatticePlace at = corners[roots_.origin(h).value];
        const auto towards = [&](VertexId v) {
            const LatticePlace to = corners[v.value];
            const auto sign = [](std::int32_t d) { return static_cast<std::int8_t>(d > 0 ? 1 : d < 0 ? -1 : 0); };
            return std::array{sign(to.x - at.x), sign(to.y - at.y)};
        };
        const auto x = towards(roots_.target(h)), y = towards(roots_.origin(roots_.prev(h)));
        frames_.push_back({at, {x[0], x[1], y[0], y[1]}});
    }
}

void TerrainSurface::set_heights() {
    constexpr std::int32_t k_cell = 1 << k_log_cell;
    HeightLevel finest;
    finest.columns = (static_cast<std::int32_t>(xs_.size()) - 2) / k_cell + 1;
    finest.rows = (static_cast<std::int32_t>(ys_.size()) - 2) / k_cell + 1;
    finest.cells.resize(static_cast<std::size_t>(finest.columns) * finest.rows);
    const auto samples = [](const std::vector<std::int32_t>& places, std::int32_t cell) {
        const auto last = std::min((static_cast<std::size_t>(cell) + 1) * k_cell, places.size() - 1);
        return std::array{places[static_cast<std::size_t>(cell) * k_cell] / k_grid_unit,
                          (places[last] + k_grid_unit - 1) / k_grid_unit};
    };
    for_each_index(
        static_cast<std::uint32_t>(finest.rows),
        [&](std::uint32_t r) {
            const auto rows = samples(ys_, static_cast<std::int32_t>(r));
            for (std::int32_t c = 0; c < finest.columns; ++c) {
                const auto columns = samples(xs_, c);
                Heights range{std::numeric_limits<float>::max(), std::numeric_limits<float>::lowest()};
                for (std::int32_t y = rows[0]; y <= rows[1]; ++y) {
                    const float* const row = grid_.heights.data() + static_cast<std::size_t>(y) * grid_.columns;
                    const auto [low, high] = std::minmax_element(row + columns[0], row + columns[1] + 1);
                    range = {std::min(range.low, *low), std::max(range.high, *high)};
                }
                finest.cells[r * static_cast<std::size_t>(finest.columns) + c] = range;
            }
        },
        4);
    heights_.push_back(std::move(finest));
    while (heights_.back().cells.size() > 1) {
        const HeightLevel& finer = heights_.back();
        HeightLevel level{(finer.columns + 1) / 2, (finer.rows + 1) / 2, {}};
        for (std::int32_t r = 0; r < level.rows; ++r)
            for (std::int32_t c = 0; c < level.columns; ++c) {
                Heights range{std::numeric_limits<float>::max(), std::numeric_limits<float>::lowest()};
                for (std::int32_t y = 2 * r; y < std::min(2 * r + 2, finer.rows); ++y)
                    for (std::int32_t x = 2 * c; x < std::min(2 * c + 2, finer.columns); ++x) {
                        const Heights& part = finer.cells[static_cast<std::size_t>(y) * finer.columns + x];
                        range = {std::min(range.low, part.low), std::max(range.high, part.high)};
                    }
                level.cells.push_back(range);
            }
        heights_.push_back(std::move(level));
    }
}

void TerrainSurface::set_errors(const RunContext& context) {
    const Heights all = heights_.back().cells[0];
    // Nesting can lead to errors beyond the range of all heights.
    const double largest = double{all.high} - double{all.low};
    lengths_ = detail::ByteLengths(largest, 2 * largest);
    codes_.assign(xs_.size() * ys_.size(), 0);
    const auto last_x = static_cast<std::int32_t>(xs_.size() - 1), last_y = static_cast<std::int32_t>(ys_.size() - 1);
    const int nesting = static_cast<int>(std::ceil(std::log2(k_error_ratio) * detail::ByteLengths::k_a_doubling));
    const auto set = [&](std::int32_t x, std::int32_t y) {
        const LatticeDiamond diamond({x, y});
        int worst = 0;
        if (diamond.is_centre || diamond.step > 1)
            for (const auto& child : diamond.children())
                if (child.x >= 0 && child.y >= 0 && child.x <= last_x && child.y <= last_y)
                    worst = std::max(worst, int{code(child)});
        double error;
        if (diamond.step > 1) {
            error = exact_error(diamond);
        } else {
            // Squares of two steps have lines in their middles: the finer triangles are at most this far away.
            const auto [a, b] = diamond.ends;
            error = std::abs(height(diamond.middle) - (height(a) + height(b)) / 2) +
                    lengths_.length(static_cast<std::uint8_t>(worst));
        }
        codes_[code_index({x, y})] = static_cast<std::uint8_t>(
            std::min(255, std::max(int{lengths_.code(error)}, worst == 0 ? 0 : worst + nesting)));
    };
    const std::int32_t half = 1 << (log_side_ - 1);
    for (std::int32_t s = 1; s <= half; s *= 2) {
        context.report("errors", static_cast<double>(std::countr_zero(static_cast<std::uint32_t>(s))) / log_side_);
        const std::uint32_t grain = std::max(1, 32 / s);
        for_each_index(
            static_cast<std::uint32_t>(last_y / s + 1),
            [&](std::uint32_t row) {
                const std::int32_t y = static_cast<std::int32_t>(row) * s;
                for (std::int32_t x = row % 2 == 0 ? s : 0; x <= last_x; x += 2 * s) set(x, y);
            },
            grain);
        // Centres of roots are there from the start.
        if (s < half)
            for_each_index(
                static_cast<std::uint32_t>(last_y / (2 * s)),
                [&](std::uint32_t row) {
                    const std::int32_t y = static_cast<std::int32_t>(2 * row + 1) * s;
                    for (std::int32_t x = s; x <= last_x; x += 2 * s) set(x, y);
                },
                grain);
    }
}

double TerrainSurface::exact_error(const LatticeDiamond& diamond) const {
    const auto vertex = [&](LatticePlace p) {
        return detail::sampled(grid_, xs_[static_cast<std::size_t>(p.x)], ys_[static_cast<std::size_t>(p.y)]);
    };
    const GridVertex a = vertex(diamond.ends[0]), b = vertex(diamond.ends[1]);
    double error = 0;
    for (const LatticePlace& apex : diamond.apexes) {
        if (apex.x < 0 || apex.y < 0 || static_cast<std::size_t>(apex.x) >= xs_.size() ||
            static_cast<std::size_t>(apex.y) >= ys_.size())
            continue;
        error =
            std::max(error, GridTriangle(grid_, {a, b, vertex(apex)}).error(std::numeric_limits<double>::infinity()));
    }
    return error;
}

double TerrainSurface::height(LatticePlace p) const {
    return detail::sampled(grid_, xs_[static_cast<std::size_t>(p.x)], ys_[static_cast<std::size_t>(p.y)]).z;
}

double TerrainSurface::east_of(std::int32_t column) const {
    return grid_.origin.x + grid_.spacing.x * in_samples(xs_[static_cast<std::size_t>(column)]);
}
double TerrainSurface::north_of(std::int32_t row) const {
    return grid_.origin.y - grid_.spacing.y * in_samples(ys_[static_cast<std::size_t>(row)]);
}
Vec3d TerrainSurface::position(LatticePlace p) const { return {east_of(p.x), north_of(p.y), height(p)}; }

detail::LatticePlace TerrainSurface::lattice_place(const Site& site) const {
    const Frame& frame = frames_[site.root.value];
    const int shift = log_side_ - 1 - site.level;
    const auto x = static_cast<std::int32_t>(site.at.x << shift), y = static_cast<std::int32_t>(site.at.y << shift);
    return {frame.origin.x + frame.axes[0] * x + frame.axes[2] * y,
            frame.origin.y + frame.axes[1] * x + frame.axes[3] * y};
}

void TerrainSurface::places(std::span<const Site> sites, std::span<Place> places) const {
    const std::int32_t half = 1 << (log_side_ - 1);
    for (std::size_t i = 0; i < sites.size(); ++i) {
        const LatticePlace p = lattice_place(sites[i]);
        Place& place = places[i];
        place.position = place.on_edge = position(p);
        // Corners and centres of roots halve no edge.
        const bool fixed =
            ((p.x | p.y) & (2 * half - 1)) == 0 || ((p.x & p.y & half) != 0 && ((p.x | p.y) & (half - 1)) == 0);
        if (!fixed) {
            const LatticeDiamond diamond(p);
            const Vec3d a = position(diamond.ends[0]), b = position(diamond.ends[1]), along = b - a;
            // The place's foot on the edge, on the ground.
            const double t = ((place.position.x - a.x) * along.x + (place.position.y - a.y) * along.y) /
                             (along.x * along.x + along.y * along.y);
            place.on_edge = a + t * along;
        }
        const auto column = static_cast<std::uint32_t>(xs_[static_cast<std::size_t>(p.x)] / k_grid_unit),
                   row = static_cast<std::uint32_t>(ys_[static_cast<std::size_t>(p.y)] / k_grid_unit);
        const std::uint32_t west = column > 0 ? column - 1 : 0, east = std::min(column + 1, grid_.columns - 1),
                            north = row > 0 ? row - 1 : 0, south = std::min(row + 1, grid_.rows - 1);
        const double slope_x = (double{grid_.at(east, row)} - double{grid_.at(west, row)}) /
                               (grid_.spacing.x * (east - west)),
                     slope_y = (double{grid_.at(column, north)} - double{grid_.at(column, south)}) /
                               (grid_.spacing.y * (south - north));
        place.normal = glm::normalize(Vec3d(-slope_x, -slope_y, 1));
        place.uv = {in_samples(xs_[static_cast<std::size_t>(p.x)]) / (grid_.columns - 1),
                    in_samples(ys_[static_cast<std::size_t>(p.y)]) / (grid_.rows - 1)};
    }
}

// The finest triangles are halves of the lattice's squares. The diagonals run through the corners with two even
// numbers.
TerrainSurface::Plane TerrainSurface::plane(LatticePlace square, bool north) const {
    const auto [x, y] = square;
    const double west = east_of(x), east = east_of(x + 1), top = north_of(y), bottom = north_of(y + 1);
    const double nw = height({x, y}), ne = height({x + 1, y}), sw = height({x, y + 1}), se = height({x + 1, y + 1});
    // From the north-west to the south-east, or across.
    const bool falls = ((x ^ y) & 1) == 0;
    const double slope_x = (north ? ne - nw : se - sw) / (east - west);
    const bool west_side = falls != north;  // whether the triangle's other leg is in the west
    const double slope_y = (west_side ? nw - sw : ne - se) / (top - bottom);
    // The corner of the right angle.
    const Vec2d corner(west_side ? west : east, north ? top : bottom);
    return {corner, {slope_x, slope_y}, north ? west_side ? nw : ne : west_side ? sw : se};
}

bool TerrainSurface::is_north(LatticePlace square, double x, double y) const {
    const double west = east_of(square.x), east = east_of(square.x + 1), top = north_of(square.y),
                 bottom = north_of(square.y + 1);
    const double across = (x - west) / (east - west), down = (top - y) / (top - bottom);
    return ((square.x ^ square.y) & 1) == 0 ? down < across : down < 1 - across;
}

std::optional<TerrainSurface::GroundPoint> TerrainSurface::at(const Vec2d& place) const {
    const double x = (place.x - grid_.origin.x) / grid_.spacing.x * k_grid_unit,
                 y = (grid_.origin.y - place.y) / grid_.spacing.y * k_grid_unit;
    if (!(x >= 0 && y >= 0 && x <= xs_.back() && y <= ys_.back())) return {};
    const auto line = [](const std::vector<std::int32_t>& lines, double at) {
        const auto after = std::upper_bound(lines.begin(), lines.end(), at);
        return static_cast<std::int32_t>(std::min<std::ptrdiff_t>(after - lines.begin(), std::ssize(lines) - 1) - 1);
    };
    const LatticePlace square{line(xs_, x), line(ys_, y)};
    const Plane over = plane(square, is_north(square, place.x, place.y));
    return GroundPoint{over.height(place.x, place.y), glm::normalize(Vec3d(-over.slopes.x, -over.slopes.y, 1))};
}

struct TerrainSurface::RaySearch {
    Vec3d origin, direction;
    double first;  ///< the nearest hit, or the farthest that counts
    bool found = false;

    struct Way {
        double begin, end;
    };
    /// The part of the ray in a box; begin > end: none.
    Way in(const Vec3d& low, const Vec3d& high) const {
        Way way{0, first};
        for (int axis = 0; axis < 3; ++axis) {
            if (direction[axis] == 0) {
                if (origin[axis] < low[axis] || origin[axis] > high[axis]) return {1, 0};
                continue;
            }
            const double a = (low[axis] - origin[axis]) / direction[axis],
                         b = (high[axis] - origin[axis]) / direction[axis];
            way = {std::max(way.begin, std::min(a, b)), std::min(way.end, std::max(a, b))};
        }
        return way;
    }
};

void TerrainSurface::search(RaySearch& ray, LatticePlace corner, std::int32_t side, double low, double high) const {
    const auto last_x = static_cast<std::int32_t>(xs_.size() - 1), last_y = static_cast<std::int32_t>(ys_.size() - 1);
    const auto [x, y] = corner;
    const int k = std::countr_zero(static_cast<std::uint32_t>(side)) - k_log_cell;
    if (k >= 0) {
        const HeightLevel& level = heights_[static_cast<std::size_t>(k)];
        const Heights& range =
            level.cells[static_cast<std::size_t>(y / side) * static_cast<std::size_t>(level.columns) +
                        static_cast<std::size_t>(x / side)];
        low = double{range.low};
        high = double{range.high};
    }
    // Wider by what rounding may do.
    const double room = 1e-9 * (std::abs(low) + std::abs(high) + grid_.spacing.x + grid_.spacing.y);
    const auto way = ray.in({east_of(x) - room, north_of(std::min(y + side, last_y)) - room, low - room},
                            {east_of(std::min(x + side, last_x)) + room, north_of(y) + room, high + room});
    if (way.begin > way.end) return;
    if (side > 1) {
        const std::int32_t half = side / 2;
        // The nearest part first.
        const std::int32_t first_x = ray.direction.x < 0 ? half : 0, first_y = ray.direction.y > 0 ? half : 0;
        for (const std::int32_t dy : {first_y, half - first_y})
            for (const std::int32_t dx : {first_x, half - first_x})
                if (x + dx < last_x && y + dy < last_y) search(ray, {x + dx, y + dy}, half, low, high);
        return;
    }
    for (const bool north : {false, true}) {
        const Plane over = plane(corner, north);
        const auto above = [&](double t) {
            const Vec3d p = ray.origin + t * ray.direction;
            return p.z - over.height(p.x, p.y);
        };
        const double begin = above(way.begin), end = above(way.end);
        if ((begin > 0 && end > 0) || (begin < 0 && end < 0)) continue;
        const double t = begin == end ? way.begin : way.begin + (way.end - way.begin) * begin / (begin - end);
        const Vec3d p = ray.origin + t * ray.direction;
        // On the diagonal both planes are equal.
        const Plane other = plane(corner, !north);
        if (is_north(corner, p.x, p.y) != north && std::abs(p.z - other.height(p.x, p.y)) > room) continue;
        if (t < ray.first || !ray.found) {
            ray.first = std::min(ray.first, t);
            ray.found = true;
        }
    }
}

std::optional<double> TerrainSurface::hit(const Vec3d& origin, const Vec3d& direction, double farthest) const {
    RaySearch ray{origin, direction, farthest};
    const int top = static_cast<int>(heights_.size()) - 1 + k_log_cell;
    search(ray, {0, 0}, 1 << top, 0, 0);
    return ray.found ? std::optional(ray.first) : std::nullopt;
}

void TerrainSurface::bounds(std::span<const Site> sites, std::span<DiamondBounds> bounds) const {
    const auto last_x = static_cast<std::int32_t>(xs_.size() - 1), last_y = static_cast<std::int32_t>(ys_.size() - 1);
    // The loop waits for memory.
    for (const Site& site : sites) __builtin_prefetch(codes_.data() + code_index(lattice_place(site)));
    for (std::size_t i = 0; i < sites.size(); ++i) {
        const LatticePlace p = lattice_place(sites[i]);
        const LatticeDiamond diamond(p);
        const std::int32_t reach = diamond.reach();
        const std::int32_t x0 = std::max(p.x - reach, 0), x1 = std::min(p.x + reach, last_x),
                           y0 = std::max(p.y - reach, 0), y1 = std::min(p.y + reach, last_y);
        const int wanted = std::bit_width(static_cast<std::uint32_t>(2 * reach - 1)) - k_log_cell;
        const int k = std::clamp(wanted, 0, static_cast<int>(heights_.size()) - 1);
        const HeightLevel& level = heights_[static_cast<std::size_t>(k)];
        const int shift = k + k_log_cell;
        Heights range{std::numeric_limits<float>::max(), std::numeric_limits<float>::lowest()};
        for (std::int32_t r = y0 >> shift; r <= std::min(y1 >> shift, level.rows - 1); ++r)
            for (std::int32_t c = x0 >> shift; c <= std::min(x1 >> shift, level.columns - 1); ++c) {
                const Heights& part = level.cells[static_cast<std::size_t>(r) * level.columns + c];
                range = {std::min(range.low, part.low), std::max(range.high, part.high)};
            }
        const Vec3d first(east_of(x0), north_of(y1), double{range.low}),
            last(east_of(x1), north_of(y0), double{range.high});
        bounds[i].center = (first + last) / 2.0;
        bounds[i].half_sides = (last - first) / 2.0;
        bounds[i].error = lengths_.length(code(p));
    }
}

}  // namespace tetrakis::lod
