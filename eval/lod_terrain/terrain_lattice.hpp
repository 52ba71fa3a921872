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
};

/// The plane over a triangle: height = at + slopes * (place - corner).
struct GroundPlane {
    Vec2d corner, slopes;
    double at;
    double height(double x, double y) const { return at + slopes.x * (x - corner.x) + slopes.y * (y - corner.y); }
    Vec3d normal() const { return glm::normalize(Vec3d(-slopes.x, -slopes.y, 1)); }
};

/// The ground over a square of the lattice: two of the finest triangles. The diagonals run through the corners with two
/// even numbers.
struct GroundSquare {
    Vec3d nw, ne, sw, se;
    bool falls;  ///< whether the diagonal runs from the north-west to the south-east

    /// @param p         the north-west corner
    /// @param position  of points of the lattice
    template <class Position>
    GroundSquare(LatticePlace p, const Position& position)
        : nw(position(p)),
          ne(position(LatticePlace{p.x + 1, p.y})),
          sw(position(LatticePlace{p.x, p.y + 1})),
          se(position(LatticePlace{p.x + 1, p.y + 1})),
          falls(((p.x ^ p.y) & 1) == 0) {}

    lod::GroundPoint ground(const Vec2d& place) const {
        const GroundPlane over = plane(is_above(place.x, place.y));
        return {over.height(place.x, place.y), over.normal()};
    }
    /// @param above  the triangle to the north of the diagonal, else the one to the south
    GroundPlane plane(bool above) const;
    /// Whether a place is to the north of the diagonal.
    bool is_above(double x, double y) const;
};

/// The lattice that all roots over a height grid have together: x to the east, y to the south, 2^log_side steps a root.
/// Its lines are at samples, or between two that are side by side, so that grids of any size work.
struct TerrainLattice {
    TerrainLattice() = default;
    /// The one with the fewest points that has every sample of the grid, whose heights do not count.
    explicit TerrainLattice(const HeightGrid& grid);

    int log_side = 1;
    Vec2d origin{0, 0}, spacing{1, 1};  ///< the grid's
    std::vector<std::int32_t> xs, ys;   ///< of its columns and rows: places in the grid, as GridVertex has them

    std::int32_t last_x() const { return static_cast<std::int32_t>(xs.size()) - 1; }
    std::int32_t last_y() const { return static_cast<std::int32_t>(ys.size()) - 1; }
    /// On the ground.
    double east(std::int32_t x) const { return origin.x + spacing.x * in_samples(xs[static_cast<std::size_t>(x)]); }
    double north(std::int32_t y) const { return origin.y - spacing.y * in_samples(ys[static_cast<std::size_t>(y)]); }
    /// From (0, 0) at the first sample to (1, 1) at the last one.
    Vec2d uv(LatticePlace p) const {
        return {in_samples(xs[static_cast<std::size_t>(p.x)]) / in_samples(xs.back()),
                in_samples(ys[static_cast<std::size_t>(p.y)]) / in_samples(ys.back())};
    }

    /// Makes the roots, and place() work. @param position  of the roots' corners
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
    /// The north-west corner of the square that a place on the ground is in; nothing beside the grid.
    std::optional<LatticePlace> square_at(const Vec2d& place) const;

  private:
    /// How the frame of a half-edge's corner cell lies in the lattice: its origin, and the steps of its two axes.
    struct Frame {
        LatticePlace origin;
        std::array<std::int8_t, 4> axes;  ///< x of its x, y of its x, x of its y, y of its y
    };
    std::vector<Frame> frames_;
};

/// By the samples on both sides, where there are two.
Vec3d sample_normal(const HeightGrid& grid, std::uint32_t column, std::uint32_t row);

/// Where the edge from a to b passes a midpoint: its foot on that edge, on the ground.
inline Vec3d foot_on_edge(const Vec3d& midpoint, const Vec3d& a, const Vec3d& b) {
    const Vec3d along = b - a;
    const double t =
        ((midpoint.x - a.x) * along.x + (midpoint.y - a.y) * along.y) / (along.x * along.x + along.y * along.y);
    return a + t * along;
}

}  // namespace tetrakis::detail
