#include "terrain_tiles.hpp"

#include "../../hier/base/error.hpp"
#include "../../hier/base/parallel.hpp"
#include "../lod_surfaces/surface.hpp"
#include "../terrain/grid_triangle.hpp"
#include "tile_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <vector>

namespace tetrakis::lod {

namespace {

using detail::HeightRange;
using detail::k_grid_unit;
using detail::LatticeDiamond;
using detail::LatticePlace;
using detail::TerrainLattice;
using detail::Tile;
using detail::TileLayout;
using detail::TilePoint;

/// A rectangle of a level's array of records.
template <class Record>
struct Block : detail::GridRectangle {
    explicit Block(const GridRectangle& rectangle)
        : GridRectangle(rectangle),
          width(static_cast<std::size_t>(x1 - x0 + 1)),
          records(width * static_cast<std::size_t>(y1 - y0 + 1)) {}
    std::size_t width;
    std::vector<Record> records;

    bool has(std::int32_t x, std::int32_t y) const { return x >= x0 && y >= y0 && x <= x1 && y <= y1; }
    const Record& at(std::int32_t x, std::int32_t y) const {
        return records[static_cast<std::size_t>(y - y0) * width + static_cast<std::size_t>(x - x0)];
    }
};

/// Bound on the vertical distance of the full-resolution surface from the two triangles at an edge, by the points and
/// errors of a finer level.
///
/// Repeated bisection cuts both into small triangles, within whose diamonds' errors the surface lies. Heights of a
/// small triangle over each of the two planes are linear, so corners decide (lemma, part 2, in README.md). If the upper
/// plane counts, a height above it is no larger than the height above either plane.
/// @param points    points of level `level`
/// @param diamond   a diamond of a coarser level
/// @param halvings  how often its edge is halved until it is an edge of the points' level
double gap_below(const TerrainLattice& lattice, const Block<TilePoint>& points, int level,
                 const LatticeDiamond& diamond, int halvings) {
    const auto vertex = [&lattice, &points, level](LatticePlace p) {
        return Vec3d(lattice.column(p.x), lattice.row(p.y), double{points.at(p.x >> level, p.y >> level).height});
    };
    std::array<LatticePlace, 2> apexes = diamond.apexes;  // one twice, if the other is outside
    for (const std::size_t i : {0u, 1u})
        if (!lattice.has(apexes[i])) apexes[i] = apexes[1 - i];
    const Vec3d start = vertex(diamond.ends[0]), end = vertex(diamond.ends[1]);
    const detail::Plane first(start, end, vertex(apexes[0])), second(start, end, vertex(apexes[1]));
    const double sign = first.above(vertex(apexes[1])) < 0 ? -1 : 1;
    /// A point, and its height over the two planes; negated if the lower plane is the surface.
    struct Corner {
        LatticePlace place;
        std::array<double, 2> above;
    };
    const auto corner = [=](LatticePlace p) {
        const Vec3d v = vertex(p);
        return Corner{p, {sign * first.above(v), sign * second.above(v)}};
    };
    const auto between = [](const Corner& a, const Corner& b) {
        return LatticePlace{(a.place.x + b.place.x) / 2, (a.place.y + b.place.y) / 2};
    };
    const auto over = [=, &points](const auto& self, const Corner& a, const Corner& b, const Corner& apex,
                                   int left) -> double {
        const LatticePlace middle = between(a, b);
        if (left > 0) {
            const Corner m = corner(middle), ma = corner(between(a, apex)), mb = corner(between(b, apex));
            return std::max({self(self, m, apex, ma, left - 1), self(self, a, m, ma, left - 1),
                             self(self, m, b, mb, left - 1), self(self, apex, m, mb, left - 1)});
        }
        const auto [low0, high0] = std::minmax({a.above[0], b.above[0], apex.above[0]});
        const auto [low1, high1] = std::minmax({a.above[1], b.above[1], apex.above[1]});
        return std::max({0.0, -low0, -low1, std::min(high0, high1)}) +
               points.at(middle.x >> level, middle.y >> level).error();
    };
    const Corner a = corner(diamond.ends[0]), b = corner(diamond.ends[1]);
    return std::max(over(over, a, b, corner(apexes[0]), halvings), over(over, a, b, corner(apexes[1]), halvings));
}

class Writer {
  public:
    Writer(HeightSource& source, const std::filesystem::path& path, const TileOptions& options)
        : source_(source),
          options_(options),
          frame_(source.frame()),
          lattice_(frame_),
          layout_(lattice_, static_cast<std::int32_t>(options.side)),
          file_(path) {
        if (layout_.tile_count > std::numeric_limits<std::int32_t>::max())
            throw Error(ErrorCode::unsupported, fmt::format("{} tiles; use larger ones", layout_.tile_count), path);
    }

    void run() {
        detail::TileHeader header{.columns = frame_.columns,
                                  .rows = frame_.rows,
                                  .side = options_.side,
                                  .spacing = frame_.spacing,
                                  .origin = frame_.origin};
        header.checksum = header.sum();
        file_.write(0, std::as_bytes(std::span(&header, 1)));
        write_finest();
        for (std::size_t k = 1; k < layout_.levels.size(); ++k) write_level(k);
        options_.context.report("write", 1);
        file_.commit();
    }

  private:
    static constexpr std::int32_t k_cell = TileLayout::k_cell;
    // On a fractal terrain such errors need 5 to 17 % more triangles than exact ones; one halving less: twice as much.
    static constexpr int k_halvings = 2;

    void write_finest() {
        const TileLayout::Level& level = layout_.levels[0];
        const std::int32_t side = layout_.side;
        for (std::int32_t row = 0; row < level.down; ++row) {
            options_.context.report("heights", 0.5 * row / level.down);
            const std::int32_t first = std::max(row * side - k_cell, 0),
                               last = std::min((row + 1) * side + k_cell, level.last_y);
            const HeightGrid band = read_band(first, last);
            for_each_index(
                static_cast<std::uint32_t>(level.across),
                [&](std::uint32_t column) {
                    write_finest(static_cast<std::uint64_t>(row) * level.across + column, band);
                },
                1);
        }
    }

    /// @param band  samples for the rows of the tile and of the cells around it
    void write_finest(std::uint64_t number, const HeightGrid& band) {
        Tile tile(layout_, number);
        const TileLayout::Level& level = layout_.levels[0];
        const auto vertex = [&](std::int32_t x, std::int32_t y) {
            return detail::sampled(band, lattice_.column(x), lattice_.row(y) - first_row_ * k_grid_unit);
        };
        const auto& points = tile.frame.points;
        for (std::int32_t y = points.y0; y <= points.y1; ++y)
            for (std::int32_t x = points.x0; x <= points.x1; ++x) {
                const detail::GridVertex v = vertex(x, y);
                TilePoint& p = tile.point(x, y);
                p.height = v.z;
                p.set_normal(detail::sample_normal(band, static_cast<std::uint32_t>(v.x / k_grid_unit),
                                                   static_cast<std::uint32_t>(v.y / k_grid_unit)));
            }
        set_errors(tile, nullptr, nullptr);
        set_cells(tile, [&](std::int32_t cx, std::int32_t cy) {
            return detail::heights_over({cx * k_cell, std::min((cx + 1) * k_cell, level.last_x), cy * k_cell,
                                         std::min((cy + 1) * k_cell, level.last_y)},
                                        [&](std::int32_t x, std::int32_t y) { return vertex(x, y).z; });
        });
        write(tile, number);
    }

    /// The samples for the rows `first` to `last` of the lattice, with the rows beside them for normals.
    HeightGrid read_band(std::int32_t first, std::int32_t last) {
        first_row_ = std::max(lattice_.row(first) / k_grid_unit - 1, 0);
        const std::int32_t end =
            std::min((lattice_.row(last) - 1) / k_grid_unit + 3, static_cast<std::int32_t>(frame_.rows));
        HeightGrid band = frame_;
        band.rows = static_cast<std::uint32_t>(end - first_row_);
        band.heights.resize(std::size_t{band.rows} * band.columns);
        source_.read(static_cast<std::uint32_t>(first_row_), band.rows, band.heights);
        if (options_.missing_height)
            std::ranges::replace_if(
                band.heights, [](float height) { return std::isnan(height); }, *options_.missing_height);
        detail::check_heights(band, static_cast<std::uint32_t>(first_row_),
                              "missing; TileOptions::missing_height (--missing; in C `gaps`) is one to take");
        return band;
    }

    void write_level(std::size_t k) {
        const TileLayout::Level& level = layout_.levels[k];
        const auto tiles = static_cast<std::uint32_t>(level.across * level.down);
        // Each level has a quarter of the tiles of the level below.
        const auto done = [](std::size_t levels) { return 1 - 2 * std::pow(0.25, levels); };
        for_each_reported(tiles, 1, options_.context, "levels", done(k), done(k + 1),
                          [&](std::uint32_t i) { write_coarser(level.first_tile + i); });
    }

    void write_coarser(std::uint64_t number) {
        Tile tile(layout_, number);
        const auto& [k, own] = tile.frame;
        const Block<TilePoint> points = read_points(tile, 1);
        for (std::int32_t y = own.y0; y <= own.y1; ++y)
            for (std::int32_t x = own.x0; x <= own.x1; ++x) {
                TilePoint& p = tile.point(x, y);
                p = points.at(2 * x, 2 * y);
                p.set_error(0);
            }
        const Block<TilePoint> fine = read_points(tile, halvings(tile));
        set_errors(tile, &points, &fine);
        const std::int32_t column = 2 * (own.x0 / k_cell), row = 2 * (own.y0 / k_cell),
                           last = 2 * layout_.side / k_cell + 1;
        const auto cells = read<HeightRange>(k - 1, layout_.cells, {column - 2, column + last, row - 2, row + last});
        set_cells(tile, [&](std::int32_t cx, std::int32_t cy) {
            return detail::heights_over(
                {2 * cx, std::min(2 * cx + 1, cells.x1), 2 * cy, std::min(2 * cy + 1, cells.y1)},
                [&](std::int32_t x, std::int32_t y) { return cells.at(x, y); });
        });
        write(tile, number);
    }

    static int halvings(const Tile& tile) { return std::min(tile.frame.level, k_halvings); }

    /// The points under the tile's diamonds, of the level that is finer by `halvings`.
    Block<TilePoint> read_points(const Tile& tile, int halvings) const {
        const auto& [k, own] = tile.frame;
        const std::int32_t steps = 1 << halvings;
        return read<TilePoint>(
            k - halvings, layout_.points,
            {(own.x0 - 1) * steps, (own.x1 + 1) * steps, (own.y0 - 1) * steps, (own.y1 + 1) * steps});
    }

    /// Reads the part of a rectangle that level k has, from all tiles under it.
    template <class Record>
    Block<Record> read(int k, const TileLayout::Array& array, const detail::GridRectangle& wanted) const {
        const TileLayout::Level& level = layout_.levels[k];
        Block<Record> block({std::max(wanted.x0, 0), std::min(wanted.x1, level.last_x >> array.shift),
                             std::max(wanted.y0, 0), std::min(wanted.y1, level.last_y >> array.shift)});
        std::span<Record> left(block.records);
        for (std::int32_t y = block.y0; y <= block.y1; ++y)
            for (std::int32_t x = block.x0; x <= block.x1;) {
                const std::uint64_t tile = layout_.tile(k, x << array.shift, y << array.shift);
                const TileLayout::Frame frame = layout_.frame(tile);
                const std::int32_t count = std::min(frame.points.x1 >> array.shift, block.x1) + 1 - x;
                const auto run = left.first(static_cast<std::size_t>(count));
                file_.read(layout_.offset(tile) + array.place(frame, x, y), std::as_writable_bytes(run));
                left = left.subspan(run.size());
                x += count;
            }
        return block;
    }

    /// @param finer, fine  read_points(tile, 1) and read_points(tile, halvings(tile)); nullptr: there is no finer level
    void set_errors(Tile& tile, const Block<TilePoint>* finer, const Block<TilePoint>* fine) const {
        const auto& [k, points] = tile.frame;
        const double beyond = share_beyond(std::size_t{1} << k);
        const auto set_error = [&](std::int32_t x, std::int32_t y) {
            const LatticeDiamond diamond({x << k, y << k});
            const auto vertex = [&](LatticePlace p) {
                return Vec3d(lattice_.column(p.x), lattice_.row(p.y), double{tile.point(p).height});
            };
            const Vec3d a = vertex(diamond.ends[0]), b = vertex(diamond.ends[1]), middle = vertex(diamond.middle);
            double own = 0, worst = 0;
            for (const LatticePlace apex : std::span(diamond.apexes).first(diamond.is_centre ? 2 : 1)) {
                // The middle of an edge along an axis is on that edge, so any third corner will do.
                const Vec3d c = diamond.is_centre ? vertex(apex) : a + Vec3d(a.y - b.y, b.x - a.x, 0);
                own = std::max(own, std::abs(detail::Plane(a, b, c).above(middle)));
            }
            for (const auto [px, py] : diamond.children())
                if (diamond.is_centre)
                    worst = std::max(worst, tile.point({px, py}).error());
                else if (finer != nullptr && finer->has(px >> (k - 1), py >> (k - 1)))
                    worst = std::max(worst, finer->at(px >> (k - 1), py >> (k - 1)).error());
            // A split moves the surface by its own error, and each of the four triangles then lies under one of the
            // diamonds that become possible: the full-resolution surface is no farther away than the sum.
            double error = own + worst;
            if (fine != nullptr)
                error =
                    std::min(error, std::max(gap_below(lattice_, *fine, k - halvings(tile), diamond, halvings(tile)),
                                             worst + own * (diamond.is_centre ? 0 : beyond)));
            tile.point(x, y).set_error(std::max(error, k_error_ratio * worst));
        };
        for (std::int32_t y = points.y0; y <= points.y1; ++y)
            for (std::int32_t x = points.x0 + (y % 2 == 0 ? 1 : 0); x <= points.x1; x += 2) set_error(x, y);
        // Centres of roots are there from the start.
        if (k + 1 < std::ssize(layout_.levels))
            for (std::int32_t y = points.y0 + 1; y <= points.y1; y += 2)
                for (std::int32_t x = points.x0 + 1; x <= points.x1; x += 2) set_error(x, y);
    }

    template <class Cell>
    void set_cells(Tile& tile, const Cell& cell) const {
        const auto& [k, own] = tile.frame;
        const TileLayout::Level& level = layout_.levels[k];
        const std::int32_t row = layout_.cells.row;
        for (std::int32_t y = own.y0 / k_cell - 1; y < own.y0 / k_cell - 1 + row; ++y)
            for (std::int32_t x = own.x0 / k_cell - 1; x < own.x0 / k_cell - 1 + row; ++x) {
                const bool is_there = x >= 0 && y >= 0 && x * k_cell < level.last_x && y * k_cell < level.last_y;
                tile.cell(x, y) = is_there ? cell(x, y) : HeightRange{};
            }
    }

    void write(Tile& tile, std::uint64_t number) {
        tile.seal();
        file_.write(layout_.offset(number), tile.bytes());
    }

    /// Part of a split's own error that can reach samples of a neighbour (lemma, part 3, in README.md). If lines are
    /// not evenly spaced, points that halve a diamond's diagonal sides are beside these, so that samples under the
    /// diamond can belong to a neighbour's triangles.
    double share_beyond(std::size_t step) const {
        // Half a sample along both axes, and half as much for each of the finer sides, which are diagonal.
        constexpr double k_beyond = 2 * std::numbers::sqrt2 / 2 * std::numbers::sqrt2 * k_grid_unit;
        // No other lines are nearer to each other than the first ones are.
        const auto &xs = lattice_.xs, &ys = lattice_.ys;
        const bool is_even = xs[1] * lattice_.last_x() == xs.back() && ys[1] * lattice_.last_y() == ys.back();
        return is_even ? 0 : std::min(1.0, k_beyond / std::min(xs[step], ys[step]));
    }

    HeightSource& source_;
    const TileOptions& options_;
    HeightGrid frame_;
    TerrainLattice lattice_;
    TileLayout layout_;
    detail::TileFile file_;
    std::int32_t first_row_ = 0;  // of the band
};

}  // namespace

void write_tiles(HeightSource& source, const std::filesystem::path& path, const TileOptions& options) {
    detail::check_frame(source.frame());
    if (options.side < 16 || options.side > 1024 || !std::has_single_bit(options.side))
        throw Error(ErrorCode::invalid_input,
                    fmt::format("tiles of {} steps; it has to be a power of two from 16 to 1024", options.side));
    if (options.missing_height && !std::isfinite(*options.missing_height))
        throw Error(
            ErrorCode::invalid_input,
            "the height to take where data are missing is no finite number; give one that single precision holds");
    with_threads(options.context, [&] { Writer(source, path, options).run(); });
}

}  // namespace tetrakis::lod
