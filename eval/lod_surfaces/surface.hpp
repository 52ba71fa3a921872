#pragma once

#include "../../hier/base/vec.hpp"
#include "../../hier/forest/site.hpp"
#include "../../hier/mesh/control_mesh.hpp"

#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <vector>

namespace tetrakis::lod {

/// A place of a surface, where a vertex of a view can be.
struct Place {
    Vec3d position{};
    Vec3d normal{};  ///< of length one; 0 where faces cancel out
    Vec2d uv{};
    /// Of a midpoint: where the edge that it halves passes it, no farther away than the diamond's error (but for what
    /// Terrain says); of other vertices: the position.
    Vec3d on_edge{};
    bool known = true;  ///< false: still to be loaded; nothing else of it means anything
};

/// What decides where a diamond is split: the two triangles over an edge (at the boundary one), with the edge's
/// midpoint, by whose site the diamond is known.
struct DiamondBounds {
    Vec3d center{};  ///< of a box that holds the surface under the diamond and under all diamonds that it can become
    Vec3d half_sides{};  ///< of that box, along the axes
    /// No point of the full-resolution surface over the diamond is farther from its triangles, or from those around it.
    double error = 0;
    bool known = true;  ///< false: still to be loaded; nothing else of it means anything
};

/// Where a ray meets a surface.
struct SurfaceHit {
    double t = 0;    ///< at origin + t * direction
    Vec3d normal{};  ///< of the finest triangle there: of length one (0: it has no area), to the side from which it is
                     ///< counter-clockwise
};

/// A diamond's error is at least this many times the error of the four that its split makes possible, so that a vertex
/// is nearer to its place than others that appear on its edges.
inline constexpr double k_error_ratio = 1.25;

/// A surface of which views show as much as they have to: a mesh of root faces, and for each site of their 4-8
/// hierarchy (corner_cell.hpp) a place, and bounds that never depend on what is refined elsewhere. Bounds are nested:
/// boxes contain the boxes of the four diamonds that a split makes possible, errors are k_error_ratio times as large.
/// All member functions may be called by any threads at the same time, and say the same each time. A surface outlives
/// its views.
///
/// A surface may be larger than memory. It then says of some diamonds and their midpoints that they are not known,
/// loads them, and changes its revision(). Vertices of roots and the centres of their faces are always known.
class Surface {
  public:
    virtual ~Surface() = default;

    /// One root (v, w, centre) per half-edge of a face that is no hole. Their positions do not count, but for the size
    /// of their box, which is to be about the surface's.
    virtual const ControlMesh& roots() const = 0;
    /// Triangles of this depth are not split: they are the surface, or as near to it as it is known. At most
    /// k_max_bisection_depth.
    virtual int max_depth() const = 0;
    /// @param sites   canonical sites of vertices, up to those of triangles of depth max_depth()
    /// @param places  as many
    virtual void places(std::span<const Site> sites, std::span<Place> places) const = 0;
    /// @param sites   canonical sites of midpoints
    /// @param bounds  as many
    virtual void bounds(std::span<const Site> sites, std::span<DiamondBounds> bounds) const = 0;

    /// Where a ray meets the finest triangles first, of what is known, from either side. Nothing if it does not, or
    /// only at a t larger than `farthest`; nothing either for an origin or direction that is not finite. Some hundreds
    /// of bounds for a steep ray, thousands for one along the surface.
    /// @param direction  of a length from 1e-100 to 1e100
    virtual std::optional<SurfaceHit> hit(const Vec3d& origin, const Vec3d& direction,
                                          double farthest = std::numeric_limits<double>::infinity()) const;

    /// Changes, upwards, whenever something has become known.
    virtual std::uint64_t revision() const { return 0; }
    /// A use begins: a midpoint whose bounds are known stays known, with its place, until end_use() of the result.
    virtual std::uint64_t begin_use() const { return 0; }
    virtual void end_use(std::uint64_t /*use*/) const {}

  protected:
    /// Whether hit() can follow a ray.
    static bool is_ray(const Vec3d& origin, const Vec3d& direction, double farthest);

    Surface() = default;
    Surface(const Surface&) = default;
    Surface(Surface&&) = default;
    Surface& operator=(const Surface&) = default;
    Surface& operator=(Surface&&) = default;
};

/// The ground of a terrain at a place, full resolution.
struct GroundPoint {
    double height = 0;
    Vec3d normal{};  ///< of the finest triangle there: of length one, upwards
};

/// A surface of heights over a grid: x to the east, y to the north, z up. Errors are vertical. Where the grid's sides
/// are no powers of two, a midpoint may be beside its edge by up to a sample, too.
class Terrain : public Surface {
  public:
    /// The finest triangles at a place on the ground. Nothing where that is beside the grid, or where the ground is not
    /// in memory: it is then wanted, so that it is known some time after, as for views. Never waits for the disk.
    /// O(log samples).
    virtual std::optional<GroundPoint> at(const Vec2d& place) const = 0;
};

/// A use of a surface, as long as it lives.
class SurfaceUse {
  public:
    explicit SurfaceUse(const Surface& surface) : surface_(surface), use_(surface.begin_use()) {}
    ~SurfaceUse() { surface_.end_use(use_); }
    SurfaceUse(const SurfaceUse&) = delete;
    SurfaceUse& operator=(const SurfaceUse&) = delete;

  private:
    const Surface& surface_;
    std::uint64_t use_;
};

/// Places of the full surface, for a look at how far a view is from it: random points of its finest lattice, as many in
/// each corner cell on average. The same for the same arguments.
std::vector<Vec3d> random_places(const Surface& surface, std::uint32_t count, std::uint64_t seed = 1);

}  // namespace tetrakis::lod
