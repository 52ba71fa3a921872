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
using detail::TileFile;
using detail::TileLayout;
using detail::TilePoint;

/// A rectangle of a level's array of records, from (x, y) on.
template <class Record>
struct Block {
    Block(std::int32_t first_x, std::int32_t first_y, std::int32_t last_x, std::int32_t last_y)
        : x(first_x),
          y(first_y),
          width(last_x - first_x + 1),
          height(last_y - first_y + 1),
          records(static_cast<std::size_t>(width) * static_cast<std::size_t>(height)) {}
    std::int32_t x, y, width, height;
    std::vector<Record> records;

    bool has(std::int32_t px, std::int32_t py) const { return px >= x && py >= y && px < x + width && py < y + height; }
    std::size_t index(std::int32_t px, std::int32_t py) const {
        return static_cast<std::size_t>(py - y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(px - x);
    }
    Record& at(std::int32_t px, std::int32_t py) { return records[index(px, py)]; }
    const Record& at(std::int32_t px, std::int32_t py) const { return records[index(px, py)]; }
};

/// A linear height function over the ground.
struct Plane {
    Plane() = default;
    Plane(const Vec3d& a, const Vec3d& b, const Vec3d& c) : at_a(a) {
        const Vec3d across = glm::cross(b - a, c - a);
        slopes = Vec2d(across) / -across.z;
    }
    double above(const Vec3d& p) const { return p.z - at_a.z - glm::dot(slopes, Vec2d(p - at_a)); }
    Vec3d at_a{};
    Vec2d slopes{};
};

/// Bound on the vertical distance of the full-resolution surface from the two triangles at an edge, by the points and
/// errors of a finer level.
///
/// Repeated bisection cuts both into small triangles, within whose diamonds' errors the surface lies. Heights of a
/// small triangle over each of the two planes are linear, so corners decide (lemma, part 2, in README.md). If the upper
/// plane counts, a height above it is no larger than the height above either plane.
class DiamondGap {
  public:
    /// @param points   points of level `level`
    /// @param diamond  a diamond of a coarser level
    DiamondGap(const TerrainLattice& lattice, const Block<TilePoint>& points, int level, const LatticeDiamond& diamond)
        : lattice_(lattice), points_(points), level_(level), diamond_(diamond) {
        for (const LatticePlace apex : diamond.apexes) {
            if (!lattice.has(apex)) continue;
            apexes_[count_] = apex;
            planes_[count_++] = {vertex(diamond.ends[0]), vertex(diamond.ends[1]), vertex(apex)};
        }
        if (count_ == 1) planes_[1] = planes_[0];
        if (planes_[0].above(vertex(apexes_[count_ - 1])) < 0) sign_ = -1;
    }

    /// @param halvings  how often the edge is halved until it is an edge of the points' level
    double largest(int halvings) const {
        const Corner a = corner(diamond_.ends[0]), b = corner(diamond_.ends[1]);
        double gap = 0;
        for (std::size_t i = 0; i < count_; ++i) gap = std::max(gap, over(a, b, corner(apexes_[i]), 2 * halvings));
        return gap;
    }

  private:
    /// A point, and its height over the two planes; negated if the lower plane is the surface.
    struct Corner {
        LatticePlace place;
        std::array<double, 2> above;
    };

    Vec3d vertex(LatticePlace p) const {
        return {lattice_.column(p.x), lattice_.row(p.y), double{points_.at(p.x >> level_, p.y >> level_).height}};
    }
    Corner corner(LatticePlace p) const {
        const Vec3d v = vertex(p);
        return {p, {sign_ * planes_[0].above(v), sign_ * planes_[1].above(v)}};
    }
    double over(const Corner& a, const Corner& b, const Corner& apex, int bisections) const {
        const LatticePlace middle{(a.place.x + b.place.x) / 2, (a.place.y + b.place.y) / 2};
        if (bisections > 0) {
            const Corner m = corner(middle);
            return std::max(over(apex, a, m, bisections - 1), over(b, apex, m, bisections - 1));
        }
        const auto [low0, high0] = std::minmax({a.above[0], b.above[0], apex.above[0]});
        const auto [low1, high1] = std::minmax({a.above[1], b.above[1], apex.above[1]});
        return std::max({0.0, -low0, -low1, std::min(high0, high1)}) +
               points_.at(middle.x >> level_, middle.y >> level_).error();
    }

    const TerrainLattice& lattice_;
    const Block<TilePoint>& points_;
    int level_;
    const LatticeDiamond& diamond_;
    std::size_t count_ = 0;
    std::array<LatticePlace, 2> apexes_{};
    std::array<Plane, 2> planes_{};
    double sign_ = 1;
};

class Writer {
  public:
    Writer(HeightSource& source, const std::filesystem::path& path, const TileOptions& options)
        : source_(source),
          options_(options),
          frame_(source.frame()),
          lattice_(frame_),
          layout_(lattice_, static_cast<std::int32_t>(options.side)),
          file_(path) {
        if (layout_.tile_count() > std::numeric_limits<std::int32_t>::max())
            throw Error(ErrorCode::unsupported, fmt::format("{} tiles; use larger ones", layout_.tile_count()), path);
    }

    void run() {
        file_.resize(layout_.file_bytes());
        detail::TileHeader header{.columns = frame_.columns,
                                  .rows = frame_.rows,
                                  .side = options_.side,
                                  .spacing = {frame_.spacing.x, frame_.spacing.y},
                                  .origin = {frame_.origin.x, frame_.origin.y}};
        header.checksum = header.sum();
        file_.write(0, std::as_bytes(std::span(&header, 1)));
        write_finest();
        for (std::size_t k = 1; k < layout_.levels().size(); ++k) write_level(k);
        options_.context.report("write", 1);
        file_.commit();
    }

  private:
    static constexpr std::int32_t k_cell = TileLayout::k_cell;
    // On a fractal terrain such errors need 5 to 17 % more triangles than exact ones; one halving less: twice as much.
    static constexpr int k_halvings = 2;

    /// A tile that is being made, with the points from (x, y) to (last_x, last_y) of its level.
    struct Work {
        Work(const TileLayout& layout, std::size_t k, std::int32_t column, std::int32_t row)
            : level(k), x(column * layout.side()), y(row * layout.side()), tile(layout) {
            const TileLayout::Level& l = layout.levels()[k];
            last_x = std::min(x + layout.side(), l.last_x);
            last_y = std::min(y + layout.side(), l.last_y);
        }
        std::size_t level;
        std::int32_t x, y, last_x, last_y;
        Tile tile;
    };
    TilePoint& point(Work& work, std::int32_t x, std::int32_t y) const {
        const auto& array = layout_.points();
        return work.tile.records<TilePoint>(array)[(y - work.y) * array.row + x - work.x];
    }

    void write_finest() {
        const TileLayout::Level& level = layout_.levels()[0];
        const std::int32_t side = layout_.side();
        for (std::int32_t row = 0; row < level.down; ++row) {
            options_.context.report("heights", 0.5 * row / level.down);
            const std::int32_t first = std::max(row * side - k_cell, 0),
                               last = std::min((row + 1) * side + k_cell, level.last_y);
            const HeightGrid band = read_band(first, last);
            for_each_index(
                static_cast<std::uint32_t>(level.across),
                [&](std::uint32_t column) {
                    write_finest({layout_, 0, static_cast<std::int32_t>(column), row}, band);
                },
                1);
        }
    }

    /// @param band  samples for the rows of the tile and of the cells around it
    void write_finest(Work work, const HeightGrid& band) {
        const TileLayout::Level& level = layout_.levels()[0];
        const auto vertex = [&](std::int32_t x, std::int32_t y) {
            return detail::sampled(band, lattice_.column(x), lattice_.row(y) - first_row_ * k_grid_unit);
        };
        for (std::int32_t y = work.y; y <= work.last_y; ++y)
            for (std::int32_t x = work.x; x <= work.last_x; ++x) {
                const detail::GridVertex v = vertex(x, y);
                TilePoint& p = point(work, x, y);
                p.height = v.z;
                p.set_normal(detail::sample_normal(band, static_cast<std::uint32_t>(v.x / k_grid_unit),
                                                   static_cast<std::uint32_t>(v.y / k_grid_unit)));
            }
        set_errors(work, nullptr, [](std::int32_t, std::int32_t) { return 0.0; });
        set_cells(work, [&](std::int32_t cx, std::int32_t cy) {
            HeightRange range;
            for (std::int32_t y = cy * k_cell; y <= std::min((cy + 1) * k_cell, level.last_y); ++y)
                for (std::int32_t x = cx * k_cell; x <= std::min((cx + 1) * k_cell, level.last_x); ++x) {
                    const float height = vertex(x, y).z;
                    range.add({height, height});
                }
            return range;
        });
        write(work);
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
        for (std::size_t i = 0; i < band.heights.size(); ++i) {
            float& height = band.heights[i];
            if (std::isfinite(height)) continue;
            if (std::isinf(height) || !options_.missing_height)
                throw Error(
                    ErrorCode::invalid_input,
                    fmt::format("the height at column {}, row {} is {}", i % band.columns,
                                i / band.columns + static_cast<std::size_t>(first_row_),
                                std::isinf(height) ? "larger than single precision holds; take a smaller scale"
                                                   : "missing; TileOptions::missing_height (--missing; in C `gaps`) "
                                                     "is one to take"));
            height = *options_.missing_height;
        }
        return band;
    }

    void write_level(std::size_t k) {
        const TileLayout::Level& level = layout_.levels()[k];
        const auto tiles = static_cast<std::uint32_t>(level.across * level.down);
        const double coarser = static_cast<double>(layout_.tile_count() - layout_.levels()[1].first_tile);
        const auto done = [&](std::uint64_t tile) {
            return 0.5 + 0.5 * static_cast<double>(tile - layout_.levels()[1].first_tile) / coarser;
        };
        for_each_reported(tiles, 1, options_.context, "levels", done(level.first_tile), done(level.first_tile + tiles),
                          [&](std::uint32_t i) {
                              write_coarser({layout_, k, static_cast<std::int32_t>(i) % level.across,
                                             static_cast<std::int32_t>(i) / level.across});
                          });
    }

    void write_coarser(Work work) {
        const std::size_t finer = work.level - 1;
        const Block<TilePoint> points = read_points(work, 1);
        for (std::int32_t y = work.y; y <= work.last_y; ++y)
            for (std::int32_t x = work.x; x <= work.last_x; ++x) {
                TilePoint& p = point(work, x, y);
                p = points.at(2 * x, 2 * y);
                p.set_error(0);
            }
        const Block<TilePoint> fine = read_points(work, halvings(work));
        set_errors(work, &fine, [&](std::int32_t x, std::int32_t y) {
            double worst = 0;
            for (const std::int32_t dy : {-1, 1})
                for (const std::int32_t dx : {-1, 1})
                    if (points.has(2 * x + dx, 2 * y + dy))
                        worst = std::max(worst, points.at(2 * x + dx, 2 * y + dy).error());
            return worst;
        });
        const TileLayout::Level& level = layout_.levels()[finer];
        const auto first = [](std::int32_t at) { return std::max(2 * (at / k_cell - 1), 0); };
        const auto last = [&](std::int32_t at, std::int32_t end) {
            return std::min(2 * (at + layout_.side()) / k_cell + 1, (end - 1) / k_cell);
        };
        Block<HeightRange> cells(first(work.x), first(work.y), last(work.x, level.last_x), last(work.y, level.last_y));
        read(finer, layout_.cells(), cells);
        set_cells(work, [&](std::int32_t cx, std::int32_t cy) {
            HeightRange range;
            for (const std::int32_t y : {2 * cy, 2 * cy + 1})
                for (const std::int32_t x : {2 * cx, 2 * cx + 1})
                    if (cells.has(x, y)) range.add(cells.at(x, y));
            return range;
        });
        write(work);
    }

    static int halvings(const Work& work) { return std::min(static_cast<int>(work.level), k_halvings); }

    /// The points under the tile's diamonds, of the level that is finer by `halvings`.
    Block<TilePoint> read_points(const Work& work, int halvings) const {
        const std::size_t k = work.level - static_cast<std::size_t>(halvings);
        const TileLayout::Level& level = layout_.levels()[k];
        Block<TilePoint> points(std::max((work.x - 1) * (1 << halvings), 0),
                                std::max((work.y - 1) * (1 << halvings), 0),
                                std::min((work.last_x + 1) << halvings, level.last_x),
                                std::min((work.last_y + 1) << halvings, level.last_y));
        read(k, layout_.points(), points);
        return points;
    }

    /// Reads a block from all tiles that own records of it.
    template <class Record>
    void read(std::size_t k, const TileLayout::Array& array, Block<Record>& block) const {
        const TileLayout::Level& level = layout_.levels()[k];
        const std::int32_t end = block.x + block.width;
        for (std::int32_t y = block.y; y < block.y + block.height; ++y) {
            const std::int32_t row = std::min(y / array.step, level.down - 1);
            for (std::int32_t x = block.x; x < end;) {
                const std::int32_t column = std::min(x / array.step, level.across - 1);
                const std::int32_t next = column + 1 == level.across ? end : std::min((column + 1) * array.step, end);
                const std::uint64_t tile = level.first_tile + static_cast<std::uint64_t>(row) * level.across + column;
                const std::int32_t at =
                    (y - row * array.step + array.margin) * array.row + x - column * array.step + array.margin;
                file_.read(layout_.offset(tile) + array.offset + static_cast<std::size_t>(at) * sizeof(Record),
                           std::as_writable_bytes(std::span(&block.at(x, y), static_cast<std::size_t>(next - x))));
                x = next;
            }
        }
    }

    /// @param fine          read_points(work, halvings(work)); nullptr: there is no finer level
    /// @param worst_centre  the largest error of the finer level's diamonds around a point
    template <class WorstCentre>
    void set_errors(Work& work, const Block<TilePoint>* fine, const WorstCentre& worst_centre) const {
        const auto k = static_cast<int>(work.level);
        const double beyond = share_beyond(std::size_t{1} << k);
        const auto set_error = [&](std::int32_t x, std::int32_t y, double worst) {
            const LatticeDiamond diamond({x << k, y << k});
            const auto vertex = [&](LatticePlace p) {
                return Vec3d(lattice_.column(p.x), lattice_.row(p.y), double{point(work, p.x >> k, p.y >> k).height});
            };
            const Vec3d a = vertex(diamond.ends[0]), b = vertex(diamond.ends[1]), middle = vertex(diamond.middle);
            double own = 0;
            for (const LatticePlace apex : diamond.apexes) {
                // The middle of an edge along an axis is on that edge, so any third corner will do.
                const Vec3d c = diamond.is_centre ? vertex(apex) : a + Vec3d(a.y - b.y, b.x - a.x, 0);
                own = std::max(own, std::abs(Plane(a, b, c).above(middle)));
            }
            // A split moves the surface by its own error, and each of the four triangles then lies under one of the
            // diamonds that become possible: the full-resolution surface is no farther away than the sum.
            double error = own + worst;
            if (fine != nullptr)
                error = std::min(
                    error, std::max(DiamondGap(lattice_, *fine, k - halvings(work), diamond).largest(halvings(work)),
                                    worst + own * (diamond.is_centre ? 0 : beyond)));
            point(work, x, y).set_error(std::max(error, k_error_ratio * worst));
        };
        for (std::int32_t y = work.y; y <= work.last_y; ++y)
            for (std::int32_t x = work.x + (y % 2 == 0 ? 1 : 0); x <= work.last_x; x += 2)
                set_error(x, y, worst_centre(x, y));
        // Centres of roots are there from the start.
        if (work.level + 1 < layout_.levels().size())
            for (std::int32_t y = work.y + 1; y <= work.last_y; y += 2)
                for (std::int32_t x = work.x + 1; x <= work.last_x; x += 2)
                    set_error(x, y,
                              std::max({point(work, x - 1, y).error(), point(work, x + 1, y).error(),
                                        point(work, x, y - 1).error(), point(work, x, y + 1).error()}));
    }

    template <class Cell>
    void set_cells(Work& work, const Cell& cell) const {
        const auto& cells = layout_.cells();
        auto* const ranges = work.tile.records<HeightRange>(cells);
        const TileLayout::Level& level = layout_.levels()[work.level];
        for (std::int32_t r = 0; r < cells.row; ++r)
            for (std::int32_t c = 0; c < cells.row; ++c) {
                const std::int32_t x = work.x / k_cell + c - 1, y = work.y / k_cell + r - 1;
                const bool is_there = x >= 0 && y >= 0 && x * k_cell < level.last_x && y * k_cell < level.last_y;
                ranges[r * cells.row + c] = is_there ? cell(x, y) : HeightRange{};
            }
    }

    void write(Work& work) {
        work.tile.seal();
        file_.write(layout_.offset(layout_.tile(work.level, work.x, work.y)), work.tile.bytes());
    }

    /// Part of a split's own error that can reach samples of a neighbour (lemma, part 3, in README.md). If lines are
    /// not evenly spaced, points that halve a diamond's diagonal sides are beside these, so that samples under the
    /// diamond can belong to a neighbour's triangles.
    double share_beyond(std::size_t step) const {
        // Half a sample along both axes, and half as much for each of the finer sides, which are diagonal.
        constexpr double k_beyond = 2 * std::numbers::sqrt2 / 2 * std::numbers::sqrt2 * k_grid_unit;
        bool is_even = true;
        std::int32_t nearest = std::numeric_limits<std::int32_t>::max();
        for (const auto* const axis : {&lattice_.xs, &lattice_.ys}) {
            const std::span<const std::int32_t> lines = *axis;
            for (std::size_t i = 1; i < lines.size(); ++i) is_even &= lines[i] - lines[i - 1] == lines[1] - lines[0];
            for (std::size_t i = step; i < lines.size(); i += step)
                nearest = std::min(nearest, lines[i] - lines[i - step]);
        }
        return is_even ? 0 : std::min(1.0, k_beyond / nearest);
    }

    HeightSource& source_;
    const TileOptions& options_;
    HeightGrid frame_;
    TerrainLattice lattice_;
    TileLayout layout_;
    TileFile file_;
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
