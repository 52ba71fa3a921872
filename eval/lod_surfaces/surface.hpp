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

/// Point of a surface at a site, where a view may have a vertex.
struct Place {
    Vec3d position{};
    Vec3d normal{};  ///< of length one; 0 where faces cancel out
    Vec2d uv{};
    /// Of a midpoint: the point of the bisected edge that is next to it, no farther away than the diamond's error (see
    /// Terrain for an exception). Of other vertices: the position.
    Vec3d on_edge{};
    bool known = true;  ///< false: not loaded yet, and the other members have no meaning
};

/// Box and error of a diamond, by which views decide whether to split it. A diamond is the two triangles at an edge
/// (one at the boundary); it is identified by the site of the edge's midpoint.
struct DiamondBounds {
    Vec3d center{};  ///< of a box that holds the surface under the diamond and under all diamonds that it can become
    Vec3d half_sides{};  ///< of that box, along the axes
    /// No point of the full-resolution surface over the diamond is farther from its triangles, or from those around it.
    double error = 0;
    bool known = true;  ///< false: not loaded yet, and the other members have no meaning
};

/// Where a ray meets a surface.
struct SurfaceHit {
    double t = 0;    ///< at origin + t * direction
    Vec3d normal{};  ///< of the finest triangle there: of length one (0: it has no area), to the side from which it is
                     ///< counter-clockwise
};

/// A diamond's error is at least this many times the error of the four that its split makes possible. So a morphing
/// vertex is nearer to its position than vertices that appear on its edges.
inline constexpr double k_error_ratio = 1.25;

/// A surface for view-dependent LOD: a mesh of root faces, and a place and bounds for each site of its 4-8 hierarchy
/// (corner_cell.hpp). They do not depend on the refinement elsewhere. Bounds are nested: a box contains the boxes of
/// the four diamonds that a split makes possible, and an error is at least k_error_ratio times theirs. All member
/// functions may be called by several threads at once, and return the same each time. A surface must outlive its views.
///
/// A surface may be larger than memory. Some diamonds and their midpoints are then not known at first: the surface
/// loads them, and changes its revision(). Vertices of roots and the centres of their faces are always known.
class Surface {
  public:
    virtual ~Surface() = default;

    /// One root (v, w, centre) per half-edge of a face that is no hole. Views use the size of the positions' box, which
    /// should be about the surface's, but not the positions.
    virtual const ControlMesh& roots() const = 0;
    /// Triangles of this depth are not split: they are the surface, or its finest approximation. At most
    /// k_max_bisection_depth.
    virtual int max_depth() const = 0;
    /// @param sites   canonical sites of vertices, up to those of triangles of depth max_depth()
    /// @param places  as many
    virtual void places(std::span<const Site> sites, std::span<Place> places) const = 0;
    /// @param sites   canonical sites of midpoints
    /// @param bounds  as many
    virtual void bounds(std::span<const Site> sites, std::span<DiamondBounds> bounds) const = 0;

    /// The first point where a ray meets the finest known triangles, from either side. Nothing if there is none with a
    /// t up to `farthest`, or if `origin` or `direction` is not finite. Cost: the bounds of all roots, and some
    /// hundreds of others for a steep ray, thousands for a ray along the surface.
    /// @param direction  of a length from 1e-100 to 1e100
    virtual std::optional<SurfaceHit> hit(const Vec3d& origin, const Vec3d& direction,
                                          double farthest = std::numeric_limits<double>::infinity()) const;

    /// Increases whenever something has become known.
    virtual std::uint64_t revision() const { return 0; }
    /// Begins a use. A midpoint whose bounds are found known then stays known, with its place, until end_use(result).
    virtual std::uint64_t begin_use() const { return 0; }
    virtual void end_use(std::uint64_t /*use*/) const {}
};

/// The ground of a terrain at a place, at full resolution.
struct GroundPoint {
    double height = 0;
    Vec3d normal{};  ///< of the finest triangle there: of length one, upwards
};

/// A surface of heights over a grid: x to the east, y to the north, z up. Errors are vertical. Where the grid's sides
/// are no powers of two, a midpoint may also be beside its edge, horizontally by up to a sample.
class Terrain : public Surface {
  public:
    /// The ground at a place, by the finest triangles. Nothing if the place is outside the grid, or if its ground is
    /// not in memory: it is then requested, and known some time later. Never waits for the disk. O(log samples).
    virtual std::optional<GroundPoint> at(const Vec2d& place) const = 0;
};

/// A use of a surface (see Surface::begin_use()), which lasts as long as this object.
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

/// Positions of random points of the surface's finest lattice, to measure how far a view is from the surface. Corner
/// cells have equal numbers of points on average. The result depends on the arguments alone. Any thread may call it.
std::vector<Vec3d> random_places(const Surface& surface, std::uint32_t count, std::uint64_t seed = 1);

}  // namespace tetrakis::lod
