#include "terrain_surface.hpp"

#include "../../hier/base/error.hpp"
#include "../../hier/base/parallel.hpp"
#include "../lod_surfaces/ray_cast.hpp"
#include "../terrain/grid_triangle.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <utility>

namespace tetrakis::lod {

namespace {

using detail::k_grid_unit;
using detail::LatticeDiamond;

constexpr int k_log_cell = 3;  // log2 of the steps of the finest cells with known heights

}  // namespace

TerrainSurface::TerrainSurface(HeightGrid grid, const RunContext& context) : grid_(std::move(grid)) {
    detail::check_surface(grid_);
    with_threads(context, [&] {
        lattice_ = detail::TerrainLattice(grid_);
        roots_ = lattice_.make_roots([&](LatticePlace p) { return position(p); });
        set_heights();
        set_errors(context);
    });
}

std::uint64_t TerrainSurface::memory_bytes() const {
    std::uint64_t bytes = grid_.heights.capacity() * sizeof(float) + codes_.capacity() +
                          (lattice_.xs.capacity() + lattice_.ys.capacity()) * sizeof(std::int32_t);
    for (const HeightLevel& level : heights_) bytes += level.cells.capacity() * sizeof(HeightRange);
    return bytes;
}

void TerrainSurface::set_heights() {
    constexpr std::int32_t k_cell = 1 << k_log_cell;
    HeightLevel finest;
    finest.columns = (static_cast<std::int32_t>(lattice_.xs.size()) - 2) / k_cell + 1;
    finest.rows = (static_cast<std::int32_t>(lattice_.ys.size()) - 2) / k_cell + 1;
    finest.cells.resize(static_cast<std::size_t>(finest.columns) * finest.rows);
    const auto samples = [](const std::vector<std::int32_t>& places, std::int32_t cell) {
        const auto last = std::min((static_cast<std::size_t>(cell) + 1) * k_cell, places.size() - 1);
        return std::array{places[static_cast<std::size_t>(cell) * k_cell] / k_grid_unit,
                          (places[last] + k_grid_unit - 1) / k_grid_unit};
    };
    for_each_index(
        static_cast<std::uint32_t>(finest.rows),
        [&](std::uint32_t r) {
            const auto rows = samples(lattice_.ys, static_cast<std::int32_t>(r));
            for (std::int32_t c = 0; c < finest.columns; ++c) {
                const auto columns = samples(lattice_.xs, c);
                finest.cells[r * static_cast<std::size_t>(finest.columns) + c] = detail::heights_over(
                    {columns[0], columns[1], rows[0], rows[1]}, [&](auto x, auto y) { return grid_.at(x, y); });
            }
        },
        4);
    heights_.push_back(std::move(finest));
    while (heights_.back().cells.size() > 1) {
        const HeightLevel& finer = heights_.back();
        HeightLevel level{(finer.columns + 1) / 2, (finer.rows + 1) / 2, {}};
        for (std::int32_t r = 0; r < level.rows; ++r)
            for (std::int32_t c = 0; c < level.columns; ++c)
                level.cells.push_back(detail::heights_over(
                    {2 * c, std::min(2 * c + 1, finer.columns - 1), 2 * r, std::min(2 * r + 1, finer.rows - 1)},
                    [&](auto x, auto y) { return finer.row(y)[x]; }));
        heights_.push_back(std::move(level));
    }
}

void TerrainSurface::set_errors(const RunContext& context) {
    const HeightRange all = heights_.back().cells[0];
    // If lines are not at samples, an error is the sum of a child's error and of a difference of heights. This factor
    // bounds such nested sums, each rounded up by an eighth.
    constexpr double k_sums = 16;
    lengths_ = detail::ByteLengths(k_sums * (double{all.high} - double{all.low}), max_depth());
    codes_.assign(lattice_.xs.size() * lattice_.ys.size(), 0);
    const auto last_x = lattice_.last_x(), last_y = lattice_.last_y();
    const auto set = [&](std::int32_t x, std::int32_t y) {
        const LatticeDiamond diamond({x, y});
        int worst = 0;
        if (diamond.is_centre || diamond.step > 1)
            for (const auto& child : diamond.children())
                if (lattice_.has(child)) worst = std::max(worst, int{codes_[code_index(child)]});
        const std::int32_t step = diamond.step;
        const bool all_at_samples =
            step > 1 &&
            lattice_.column(std::min(x + step, last_x)) - lattice_.column(std::max(x - step, 0)) >= 2 * k_grid_unit &&
            lattice_.row(std::min(y + step, last_y)) - lattice_.row(std::max(y - step, 0)) >= 2 * k_grid_unit;
        double error = step > 1 ? exact_error(diamond) : 0;
        if (!all_at_samples) {
            // Squares of two steps have lines in their middles, and narrow strips more of them. This bounds the
            // distance from the finer triangles.
            const auto [a, b] = diamond.ends;
            error = std::max(error, std::abs(height(diamond.middle) - (height(a) + height(b)) / 2)) +
                    lengths_.length(static_cast<std::uint8_t>(worst));
        }
        codes_[code_index({x, y})] = static_cast<std::uint8_t>(std::min(
            255, std::max(int{lengths_.code(error)}, worst == 0 ? 0 : worst + detail::ByteLengths::k_nesting)));
    };
    const std::int32_t half = 1 << (lattice_.log_side - 1);
    for (std::int32_t s = 1; s <= half; s *= 2) {
        context.report("errors",
                       static_cast<double>(std::countr_zero(static_cast<std::uint32_t>(s))) / lattice_.log_side);
        for (const bool centres : {false, true}) {
            if (centres && s == half) break;  // centres of roots are vertices from the start
            for_each_index(
                static_cast<std::uint32_t>(centres ? last_y / (2 * s) : last_y / s + 1),
                [&](std::uint32_t row) {
                    const std::int32_t y = static_cast<std::int32_t>(centres ? 2 * row + 1 : row) * s;
                    for (std::int32_t x = centres || row % 2 == 0 ? s : 0; x <= last_x; x += 2 * s) set(x, y);
                },
                static_cast<std::uint32_t>(std::max(1, 32 / s)));
        }
    }
}

double TerrainSurface::exact_error(const LatticeDiamond& diamond) const {
    const auto vertex = [&](LatticePlace p) { return detail::sampled(grid_, lattice_.column(p.x), lattice_.row(p.y)); };
    double error = 0;
    for (const LatticePlace& apex : diamond.apexes)
        if (lattice_.has(apex))
            error = std::max(
                error, detail::GridTriangle(grid_, {vertex(diamond.ends[0]), vertex(diamond.ends[1]), vertex(apex)})
                           .error(std::numeric_limits<double>::infinity()));
    return error;
}

double TerrainSurface::height(LatticePlace p) const {
    return double{detail::sampled(grid_, lattice_.column(p.x), lattice_.row(p.y)).z};
}

void TerrainSurface::places(std::span<const Site> sites, std::span<Place> places) const {
    // The loop below is bound by memory latency.
    for (const Site& site : sites) {
        const LatticePlace p = lattice_.place(site);
        const float* const at = grid_.heights.data() + std::size_t(lattice_.row(p.y) / k_grid_unit) * grid_.columns +
                                lattice_.column(p.x) / k_grid_unit;
        __builtin_prefetch(at);
        __builtin_prefetch(at + grid_.columns);
        __builtin_prefetch(at - grid_.columns);
    }
    for (std::size_t i = 0; i < sites.size(); ++i) {
        const LatticePlace p = lattice_.place(sites[i]);
        const Vec3d normal =
            detail::sample_normal(grid_, static_cast<std::uint32_t>(lattice_.column(p.x) / k_grid_unit),
                                  static_cast<std::uint32_t>(lattice_.row(p.y) / k_grid_unit));
        places[i] = lattice_.vertex(p, normal, [this](LatticePlace of) { return position(of); });
    }
}

std::optional<GroundPoint> TerrainSurface::at(const Vec2d& place) const {
    const auto corner = lattice_.square_at(place);
    if (!corner) return {};
    return detail::ground(square(*corner), place);
}

void TerrainSurface::search(detail::RayCast& ray, LatticePlace corner, std::int32_t side, HeightRange range) const {
    const auto last_x = lattice_.last_x(), last_y = lattice_.last_y();
    const auto [x, y] = corner;
    const int k = std::countr_zero(static_cast<std::uint32_t>(side)) - k_log_cell;
    if (k >= 0) range = heights_[static_cast<std::size_t>(k)].row(y / side)[x / side];
    const DiamondBounds box = lattice_.bounds({x, std::min(x + side, last_x), y, std::min(y + side, last_y)}, range, 0);
    if (!ray.enters(box.center, box.half_sides)) return;
    if (side == 1) {
        for (const auto& [a, b, c] : square(corner)) ray.meet(a, b, c);
        return;
    }
    const std::int32_t half = side / 2;
    // The nearest part first.
    const std::int32_t first_x = ray.direction().x < 0 ? half : 0, first_y = ray.direction().y > 0 ? half : 0;
    for (const std::int32_t dy : {first_y, half - first_y})
        for (const std::int32_t dx : {first_x, half - first_x})
            if (x + dx < last_x && y + dy < last_y) search(ray, {x + dx, y + dy}, half, range);
}

std::optional<SurfaceHit> TerrainSurface::hit(const Vec3d& origin, const Vec3d& direction, double farthest) const {
    detail::RayCast ray(origin, direction, farthest, roots_.bounding_box());
    if (!ray.is_valid()) return {};
    const int top = static_cast<int>(heights_.size()) - 1 + k_log_cell;
    search(ray, {0, 0}, 1 << top, {});
    return ray.hit();
}

void TerrainSurface::bounds(std::span<const Site> sites, std::span<DiamondBounds> bounds) const {
    // The cells that hold a diamond and all diamonds that its splits lead to. They are as wide as these together, so
    // there are at most two along each axis.
    struct Around {
        detail::GridRectangle within;
        const HeightRange *north, *south;
        std::int32_t east;
        const std::uint8_t* code;
    };
    std::array<Around, 32> batch;  // bound by memory latency: its cache misses overlap
    while (!sites.empty()) {
        const std::size_t count = std::min(batch.size(), sites.size());
        for (std::size_t i = 0; i < count; ++i) {
            const LatticePlace p = lattice_.place(sites[i]);
            const auto within = lattice_.around(p);
            const int wanted =
                std::bit_width(static_cast<std::uint32_t>(2 * LatticeDiamond::reach(p) - 1)) - k_log_cell;
            const int k = std::clamp(wanted, 0, static_cast<int>(heights_.size()) - 1), shift = k + k_log_cell;
            const HeightLevel& level = heights_[static_cast<std::size_t>(k)];
            const std::int32_t west = within.x0 >> shift;
            batch[i] = {within, level.row(within.y0 >> shift) + west,
                        level.row(std::min(within.y1 >> shift, level.rows - 1)) + west,
                        std::min(within.x1 >> shift, level.columns - 1) - west, codes_.data() + code_index(p)};
            __builtin_prefetch(batch[i].north);
            __builtin_prefetch(batch[i].south);
            __builtin_prefetch(batch[i].code);
        }
        for (std::size_t i = 0; i < count; ++i) {
            const auto& [within, north, south, east, code] = batch[i];
            HeightRange heights = north[0];
            for (const HeightRange& range : {north[east], south[0], south[east]}) heights.add(range);
            bounds[i] = lattice_.bounds(within, heights, lengths_.length(*code));
        }
        sites = sites.subspan(count);
        bounds = bounds.subspan(count);
    }
}

}  // namespace tetrakis::lod
