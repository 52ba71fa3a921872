#pragma once

#include "../../hier/base/vec.hpp"
#include "../../hier/forest/site.hpp"
#include "../../hier/mesh/control_mesh.hpp"
#include "../terrain/height_grid.hpp"
#include "lattice_diamond.hpp"

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

namespace tetrakis::detail {

/// The lattice that all roots over a height grid have together: x to the east, y to the south, 2^log_side steps a root.
/// Its lines are at samples, or between two that are side by side, so that grids of any size work.
struct TerrainLattice {
    TerrainLattice() = default;
    /// The one with the fewest points that has every sample of the grid.
    TerrainLattice(std::uint32_t columns, std::uint32_t rows);

    int log_side = 1;
    std::vector<std::int32_t> xs, ys;  ///< of its columns and rows: places in the grid, as GridVertex has them

    std::int32_t last_x() const { return static_cast<std::int32_t>(xs.size()) - 1; }
    std::int32_t last_y() const { return static_cast<std::int32_t>(ys.size()) - 1; }

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
