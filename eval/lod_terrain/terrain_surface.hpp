#pragma once

#include "../../hier/base/run_context.hpp"
#include "../lod_surfaces/byte_lengths.hpp"
#include "../lod_surfaces/lattice_diamond.hpp"
#include "../lod_surfaces/surface.hpp"
#include "../terrain/height_grid.hpp"
#include "terrain_lattice.hpp"

#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <vector>

namespace tetrakis::detail {
class RayCast;
}

namespace tetrakis::lod {

/// A height grid of any size as a surface: every sample is a vertex of its finest level. x to the east, y to the north,
/// z up, as in terrain_mesh(); uv from (0, 0) at the first sample to (1, 1) at the last one. A diamond's error is the
/// largest vertical distance of samples, but for nesting and rounding up by at most 1/8; for the smallest, a bound.
class TerrainSurface final : public Terrain {
  public:
    /// @throws Error  as detail::check_surface() does; cancelled
    /// Cost: O(samples * log samples), by all threads of the context; memory: the grid's and at most two bytes a
    /// sample, where both sides have at least a hundred.
    explicit TerrainSurface(HeightGrid grid, const RunContext& context = {});

    const HeightGrid& grid() const { return grid_; }
    std::uint64_t memory_bytes() const;

    std::optional<GroundPoint> at(const Vec2d& place) const override;
    std::optional<SurfaceHit> hit(const Vec3d& origin, const Vec3d& direction,
                                  double farthest = std::numeric_limits<double>::infinity()) const override;

    const ControlMesh& roots() const override { return roots_; }
    int max_depth() const override { return 2 * lattice_.log_side - 1; }
    void places(std::span<const Site> sites, std::span<Place> places) const override;
    void bounds(std::span<const Site> sites, std::span<DiamondBounds> bounds) const override;

  private:
    using LatticePlace = detail::LatticePlace;
    using HeightRange = detail::HeightRange;
    /// Lowest and highest heights of square cells of the lattice, 8 * 2^level steps wide.
    struct HeightLevel {
        std::int32_t columns = 0, rows = 0;
        std::vector<HeightRange> cells;
        const HeightRange* row(std::int32_t r) const {
            return cells.data() + static_cast<std::size_t>(r) * static_cast<std::size_t>(columns);
        }
    };

    void set_heights();
    void set_errors(const RunContext& context);
    double exact_error(const detail::LatticeDiamond& diamond) const;
    double height(LatticePlace p) const;
    Vec3d position(LatticePlace p) const { return lattice_.position(p, height(p)); }
    std::size_t code_index(LatticePlace p) const {
        return static_cast<std::size_t>(p.y) * lattice_.xs.size() + static_cast<std::size_t>(p.x);
    }
    detail::GroundSquare square(LatticePlace p) const {
        return detail::ground_square(p, [this](LatticePlace corner) { return position(corner); });
    }
    void search(detail::RayCast& ray, LatticePlace corner, std::int32_t side, HeightRange range) const;

    HeightGrid grid_;
    detail::TerrainLattice lattice_;
    ControlMesh roots_;
    std::vector<std::uint8_t> codes_;  ///< errors of the diamonds of the lattice's points
    detail::ByteLengths lengths_;
    std::vector<HeightLevel> heights_;
};

}  // namespace tetrakis::lod
