#pragma once

#include "../../hier/base/vec.hpp"
#include "../../hier/forest/site.hpp"
#include "../../hier/mesh/control_mesh.hpp"
#include "../lod_surfaces/lattice_diamond.hpp"
#include "../lod_surfaces/surface.hpp"
#include "../terrain/height_grid.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <vector>

namespace tetrakis::detail {

struct HeightRange {
    float low = std::numeric_limits<float>::max(), high = std::numeric_limits<float>::lowest();
    void add(const HeightRange& other) {
        low = std::min(low, other.low);
        high = std::max(high, other.high);
    }
    void add(float height) { add({height, height}); }
};

/// A rectangle of a lattice, or of any grid; borders included.
struct GridRectangle {
    std::int32_t x0, x1, y0, y1;
};
/// The range of all heights in a rectangle. @param at  returns the height, or a range of heights, at (x, y)
template <class At>
HeightRange heights_over(const GridRectangle& rectangle, const At& at) {
    HeightRange range;
    for (std::int32_t y = rectangle.y0; y <= rectangle.y1; ++y)
        for (std::int32_t x = rectangle.x0; x <= rectangle.x1; ++x) range.add(at(x, y));
    return range;
}

/// A linear height function over the ground.
struct Plane {
    Plane(const Vec3d& a, const Vec3d& b, const Vec3d& c) : at_a(a) {
        const Vec3d across = glm::cross(b - a, c - a);
        slopes = Vec2d(across) / -across.z;
    }
    double above(const Vec3d& p) const { return p.z - at_a.z - glm::dot(slopes, Vec2d(p - at_a)); }
    Vec3d at_a;
    Vec2d slopes;
};

/// The two finest triangles over a square of the lattice, counter-clockwise from above. Their common diagonal runs
/// through the corners with two even or two odd coordinates; it is the first side of the second triangle.
using GroundSquare = std::array<std::array<Vec3d, 3>, 2>;
/// @param p         the north-west corner
/// @param position  returns the position of a lattice point
template <class Position>
GroundSquare ground_square(LatticePlace p, const Position& position) {
    const Vec3d nw = position(p), ne = position(LatticePlace{p.x + 1, p.y}), sw = position(LatticePlace{p.x, p.y + 1}),
                se = position(LatticePlace{p.x + 1, p.y + 1});
    const bool falls = ((p.x ^ p.y) & 1) == 0;
    return falls ? GroundSquare{{{nw, se, ne}, {se, nw, sw}}} : GroundSquare{{{nw, sw, ne}, {ne, sw, se}}};
}
lod::GroundPoint ground(const GroundSquare& square, const Vec2d& place);

/// The common lattice of all roots over a height grid: x to the east, y to the south, 2^log_side steps to a root's
/// side. Its lines are at samples, or between two adjacent samples, so that grids of any size work.
struct TerrainLattice {
    TerrainLattice() = default;
    /// The lattice with the fewest points that contains every sample of the grid, whose heights are not used.
    explicit TerrainLattice(const HeightGrid& grid);

    int log_side = 1;
    Vec2d origin{0, 0}, spacing{1, 1};  ///< the grid's
    std::vector<std::int32_t> xs, ys;   ///< grid coordinates of its columns and rows, in the units of GridVertex

    std::int32_t last_x() const { return static_cast<std::int32_t>(xs.size()) - 1; }
    std::int32_t last_y() const { return static_cast<std::int32_t>(ys.size()) - 1; }
    bool has(LatticePlace p) const { return p.x >= 0 && p.y >= 0 && p.x <= last_x() && p.y <= last_y(); }
    /// Grid coordinates of the lattice's lines.
    std::int32_t column(std::int32_t x) const { return xs[static_cast<std::size_t>(x)]; }
    std::int32_t row(std::int32_t y) const { return ys[static_cast<std::size_t>(y)]; }
    /// Coordinates on the ground.
    double east(std::int32_t x) const { return origin.x + spacing.x * in_samples(column(x)); }
    double north(std::int32_t y) const { return origin.y - spacing.y * in_samples(row(y)); }
    Vec3d position(LatticePlace p, double height) const { return {east(p.x), north(p.y), height}; }

    /// Place of a point for views. uv: from (0, 0) at the first sample to (1, 1) at the last one.
    /// @param position  returns the position of a lattice point
    template <class Position>
    lod::Place vertex(LatticePlace p, const Vec3d& normal, const Position& position) const {
        lod::Place place{.position = position(p),
                         .normal = normal,
                         .uv = {double(column(p.x)) / xs.back(), double(row(p.y)) / ys.back()}};
        place.on_edge = place.position;
        if (is_fixed(p)) return place;
        // The edge's point that is nearest in plan.
        const LatticeDiamond diamond(p);
        const Vec3d a = position(diamond.ends[0]), along = position(diamond.ends[1]) - a, off = place.position - a;
        place.on_edge = a + (off.x * along.x + off.y * along.y) / (along.x * along.x + along.y * along.y) * along;
        return place;
    }

    /// Part of the lattice that holds a diamond and all diamonds that its splits lead to.
    GridRectangle around(LatticePlace p) const {
        const std::int32_t reach = LatticeDiamond::reach(p);
        return {std::max(p.x - reach, 0), std::min(p.x + reach, last_x()), std::max(p.y - reach, 0),
                std::min(p.y + reach, last_y())};
    }
    lod::DiamondBounds bounds(const GridRectangle& within, const HeightRange& heights, double error) const {
        const Vec3d first(east(within.x0), north(within.y1), heights.low),
            last(east(within.x1), north(within.y0), heights.high);
        return {(first + last) / 2.0, (last - first) / 2.0, error};
    }

    /// Makes the roots, and the frames that place() needs. @param position  returns positions of the roots' corners
    ControlMesh make_roots(const std::function<Vec3d(LatticePlace)>& position);
    LatticePlace place(const Site& site) const {
        const Frame& frame = frames_[site.root.value];
        const int shift = log_side - 1 - site.level;
        const auto x = static_cast<std::int32_t>(site.at.x << shift), y = static_cast<std::int32_t>(site.at.y << shift);
        return {frame.origin.x + frame.axes[0] * x + frame.axes[2] * y,
                frame.origin.y + frame.axes[1] * x + frame.axes[3] * y};
    }
    /// Corners and centres of roots halve no edge.
    bool is_fixed(LatticePlace p) const {
        const std::int32_t half = 1 << (log_side - 1);
        return ((p.x | p.y) & (2 * half - 1)) == 0 || ((p.x & p.y & half) != 0 && ((p.x | p.y) & (half - 1)) == 0);
    }
    /// North-west corner of the square that contains a place on the ground; nothing outside the grid.
    std::optional<LatticePlace> square_at(const Vec2d& place) const;

  private:
    /// How the frame of a half-edge's corner cell lies in the lattice: its origin, and the steps of its two axes.
    struct Frame {
        LatticePlace origin;
        std::array<std::int8_t, 4> axes;  ///< x of its x, y of its x, x of its y, y of its y
    };
    std::vector<Frame> frames_;
};

/// Normal at a sample, by differences of the neighbours on both sides; at the border, of the sample and one neighbour.
Vec3d sample_normal(const HeightGrid& grid, std::uint32_t column, std::uint32_t row);

}  // namespace tetrakis::detail
