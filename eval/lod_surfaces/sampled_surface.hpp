#pragma once

#include "../../hier/base/run_context.hpp"
#include "byte_lengths.hpp"
#include "surface.hpp"

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace tetrakis::lod {

/// A surface that is known at the points of a lattice, with 2^level() steps to a side of each corner cell of the roots'
/// faces (site.hpp). Between the points it is flat, or finest_errors() bounds its distance from the finest triangles.
/// This class computes the bounds of all diamonds in one pass from the finest to the roots, and stores two bytes a
/// point for them. A derived class provides the points, which it may compute or store.
class SampledSurface : public Surface {
  public:
    static constexpr int k_max_level = 13;  ///< 67 million points to a corner cell

    const ControlMesh& roots() const final { return roots_; }
    int max_depth() const final { return 2 * level_ + 1; }
    void places(std::span<const Site> sites, std::span<Place> places) const final;
    void bounds(std::span<const Site> sites, std::span<DiamondBounds> bounds) const final;

    int level() const { return level_; }
    /// Memory of what this class stores.
    virtual std::uint64_t memory_bytes() const;

  protected:
    /// @param point_bytes  what the derived class is going to store for each point
    /// @param work_bytes   for each point of one corner cell, what each thread is going to need beside this class
    /// @throws Error  invalid_input: a level that is not from 1 to k_max_level; all faces are holes;
    ///                memory_limit: points that need more memory than the context allows
    SampledSurface(ControlMesh roots, int level, const RunContext& context = {}, std::uint64_t point_bytes = 0,
                   std::uint64_t work_bytes = 0);

    /// Positions of canonical sites of levels up to level(). Must return the same for the same site, in any thread.
    virtual void positions(std::span<const Site> sites, std::span<Vec3d> positions) const = 0;
    /// Normals and uvs of such sites; the places' positions are known.
    virtual void shade(std::span<const Site> sites, std::span<Place> places) const = 0;
    /// Bounds on the distance of the surface over a finest triangle from that triangle, for the 4^level() squares of a
    /// corner cell, row by row from (0, 0): the larger bound of a square's two triangles. By default the bounds are 0:
    /// the triangles are the surface.
    virtual void finest_errors(HalfedgeId cell, std::span<float> errors) const;

    /// To be called once, as soon as the functions above can be called.
    /// @throws Error  cancelled
    /// Cost: O(points * level()), by all threads of the context; memory for the points of one cell on each thread.
    void set_bounds(const RunContext& context);

    /// Site of the point (x, y), in lattice steps, in the frame of a corner cell, which continues across the cell's
    /// sides. The site's root is invalid beyond the boundary.
    Site site_at(HalfedgeId cell, std::int64_t x, std::int64_t y) const;
    /// Index of a canonical site's point in arrays over all points: cell by cell, and row by row in each cell.
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
    /// Corner cells of the faces that are no holes.
    std::span<const HalfedgeId> cells() const { return cells_; }
    /// The canonical sites of a cell's points, row by row.
    std::vector<Site> sites_of(HalfedgeId cell) const;

  private:
    Vec3d position(const Site& site) const;
    void measure_cell(HalfedgeId cell);
    void nest(HalfedgeId cell, std::int32_t step, bool centres);

    ControlMesh roots_;
    int level_ = 0;
    std::vector<HalfedgeId> cells_;
    std::vector<std::uint32_t> cell_of_;  // by half-edge
    // By point: codes of the diamond whose middle it is.
    std::vector<std::uint8_t> errors_, radii_;
    detail::ByteLengths lengths_;
};

}  // namespace tetrakis::lod
