#pragma once

#include "../../hier/base/run_context.hpp"
#include "byte_lengths.hpp"
#include "surface.hpp"

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace tetrakis::lod {

/// A surface that is known at the points of a lattice: 2^level() steps to a side of each corner cell of the roots'
/// faces (site.hpp). Between them it is flat, or its distance from the finest triangles is known. This class finds the
/// bounds of all diamonds, in one pass from the finest to the roots, and keeps two bytes a point for them. A derived
/// class says where the points are; it may compute or keep them.
class SampledSurface : public Surface {
  public:
    static constexpr int k_max_level = 13;  ///< 67 million points to a corner cell

    const ControlMesh& roots() const final { return roots_; }
    int max_depth() const final { return 2 * level_ + 1; }
    void places(std::span<const Site> sites, std::span<Place> places) const final;
    void bounds(std::span<const Site> sites, std::span<DiamondBounds> bounds) const final;

    int level() const { return level_; }
    /// Of what this class keeps.
    virtual std::uint64_t memory_bytes() const;

  protected:
    /// @throws Error  invalid_input: a level that is not from 1 to k_max_level; all faces are holes
    SampledSurface(ControlMesh roots, int level);

    /// Positions of canonical sites of levels up to level(). The same for the same site, from any thread.
    virtual void positions(std::span<const Site> sites, std::span<Vec3d> positions) const = 0;
    /// Normals and uvs of such sites; the places' positions are known.
    virtual void shade(std::span<const Site> sites, std::span<Place> places) const = 0;
    /// How far the surface over each of a finest square's two triangles is at most from that triangle, the larger of
    /// both: 4^level() numbers of a corner cell, row by row from (0, 0). Unless it is overridden, the triangles are the
    /// surface.
    virtual void finest_errors(HalfedgeId cell, std::span<float> errors) const;

    /// To be called once, when the functions above can be.
    /// @throws Error  cancelled
    /// Cost: O(points * level()), by all threads of the context, and room for a cell's points on each.
    void set_bounds(const RunContext& context);

    /// The site of a point in the frame of a corner cell continued over its sides, lattice steps; its root is invalid
    /// beyond the boundary.
    Site site_at(HalfedgeId cell, std::int64_t x, std::int64_t y) const;
    /// Where a canonical site's point is in an array over all points: cells one after the other, each row by row.
    std::size_t index(const Site& site) const {
        const std::size_t side = (std::size_t{1} << level_) + 1;
        const int shift = level_ - site.level;
        return (cell_of_[site.root.value] * side + (std::size_t{site.at.y} << shift)) * side +
               (std::size_t{site.at.x} << shift);
    }
    std::size_t point_count() const {
        const std::size_t side = (std::size_t{1} << level_) + 1;
        return cells_.size() * side * side;
    }
    /// Those of faces that are no holes.
    std::span<const HalfedgeId> cells() const { return cells_; }
    /// The canonical sites of a cell's points, row by row.
    std::vector<Site> sites_of(HalfedgeId cell) const;

  private:
    void measure_cell(HalfedgeId cell);
    void nest(HalfedgeId cell, std::int32_t step, bool centres);

    ControlMesh roots_;
    int level_ = 0;
    std::vector<HalfedgeId> cells_;
    std::vector<std::uint32_t> cell_of_;  // by half-edge
    // By point: of the diamond that has it as its middle.
    std::vector<std::uint8_t> errors_, radii_;
    detail::ByteLengths lengths_;
};

}  // namespace tetrakis::lod
