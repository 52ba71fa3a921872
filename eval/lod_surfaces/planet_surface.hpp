#pragma once

#include "../terrain/height_grid.hpp"
#include "sampled_surface.hpp"

#include <array>
#include <cstdint>
#include <span>

namespace tetrakis::lod {

struct PlanetOptions {
    double radius = 6'371'000;  ///< metres, or whatever heights are in; from 1e-37 to 1e37
    /// Triangles lie over a lattice of 2^(level + 1) steps to a side of each of a cube's six faces. 0: as fine as the
    /// heights are where the lattice is coarsest, up to level 12.
    int level = 0;
    RunContext context{};
};

/// A planet: heights over a ball about the origin, z to the north pole, x to where longitude and latitude are 0, as six
/// faces of a cube seen from the middle. Between samples heights are bilinear; the surface is the finest triangles.
/// Positions are doubles; uv: longitude from 0 to 1 (-180 to 180 degrees), latitude from 0 (north pole) to 1. A vertex
/// has only one uv. Shaders that need it across the antimeridian or at a pole should compute it from the normalised
/// position. All calls may come from several threads at once.
class PlanetSurface final : public SampledSurface {
  public:
    /// Heights over longitudes and latitudes: samples are in the middles of equal cells, the first row at the north
    /// pole, the first column east of the antimeridian. Origin and spacing of the grid are ignored.
    /// @throws Error  invalid_input: a height is missing or no number, no samples, a radius out of range,
    ///                heights as deep as the planet; memory_limit; cancelled
    /// Cost: O(points * level()), by all threads; memory: the grid's and two bytes a point, and 48 bytes for each point
    /// of one corner cell on each thread while bounds are computed
    explicit PlanetSurface(HeightGrid longitudes_latitudes, const PlanetOptions& options = {});
    /// Heights over the faces of a cube, towards +x, -x, +y, -y, +z, -z, as OpenGL's cube maps have them (OpenGL 4.6,
    /// table 8.19); the first and last rows and columns are on the cube's edges. Grids are square and of one size.
    explicit PlanetSurface(std::array<HeightGrid, 6> faces, const PlanetOptions& options = {});

    double radius() const { return radius_; }
    /// Height of the ground in a `direction` of any length but zero, before triangulation.
    double height(const Vec3d& direction) const;
    Vec3d normal(const Vec3d& direction) const;  ///< of that ground, of length one, outwards
    std::uint64_t memory_bytes() const override;

  private:
    PlanetSurface(std::span<HeightGrid> grids, const PlanetOptions& options);
    void positions(std::span<const Site> sites, std::span<Vec3d> positions) const override;
    void shade(std::span<const Site> sites, std::span<Place> places) const override;
    Vec3d direction(const Site& site) const;

    std::vector<HeightGrid> grids_;  // one, or six
    double radius_ = 1;
    double step_ = 0;  // between samples, radians
};

}  // namespace tetrakis::lod
