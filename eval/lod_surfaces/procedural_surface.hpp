#pragma once

#include "surface.hpp"

#include <cstdint>
#include <functional>
#include <vector>

namespace tetrakis::lod {

/// A height function, and bounds on it that hold everywhere. The functions must return the same each time, and may be
/// called by several threads at once.
struct ProceduralHeights {
    std::function<double(const Vec3d& place)> height;  ///< must be finite, or callers throw invalid_input
    /// Bound for any triangle in a ball of this radius: the largest difference between heights and their linear
    /// interpolation from the triangle's corners. Must not fall as the radius grows.
    std::function<double(double radius)> deviation;
    double slope = 0;          ///< largest change of height per length of a path
    double low = 0, high = 0;  ///< heights are between these
};

/// An example of such heights: `octaves` layers of waves in random directions, each with half the wavelength and half
/// the height of the one before. The bounds follow from the largest derivatives of the waves. Any thread may call it
/// at any time, and the result depends on the arguments alone.
/// @param amplitude   of the first layer: heights are less than twice as large
/// @param wavelength  of the first layer, about
/// @throws Error      invalid_input: an amplitude that is negative, a wavelength that is not positive, octaves that are
///                    not from 1 to 48
ProceduralHeights fractal_heights(double amplitude, double wavelength, int octaves, std::uint64_t seed = 1);

/// A plane or a ball with procedural heights, down to triangles of a given size: 1.2 centimetres on a ball of the
/// earth's radius, if the heights have such details. No points are stored.
class ProceduralSurface final : public Surface {
  public:
    /// A square about the origin; the height at (x, y, 0) is along z. uv: (x, y) from the corner with the lowest
    /// coordinates, in sides of the square.
    /// @param finest  triangles with longest sides of this length or less are not split; at most `side`
    /// @throws Error  invalid_input: lengths that are not positive, a function that is missing, bounds that contradict
    ///                each other; unsupported: more levels than sites have
    static ProceduralSurface plane(double side, double finest, ProceduralHeights heights);
    /// A ball about the origin; heights are outwards, for places on the ball. uv: as PlanetSurface has it.
    static ProceduralSurface ball(double radius, double finest, ProceduralHeights heights);

    const ControlMesh& roots() const override { return roots_; }
    int max_depth() const override { return max_depth_; }
    void places(std::span<const Site> sites, std::span<Place> places) const override;
    void bounds(std::span<const Site> sites, std::span<DiamondBounds> bounds) const override;

  private:
    ProceduralSurface(ControlMesh roots, double radius, double step, double finest, ProceduralHeights heights);
    Vec3d base(const Vec3d& on_roots) const;  // on the plane or ball
    Vec3d up(const Vec3d& base) const;
    Vec3d ground(const Vec3d& base) const;  // above that
    double error(double length) const;      // of triangles with such a longest side

    ControlMesh roots_;
    double radius_;  // infinite: a plane
    double step_;    // longest step of lattice level 0
    int max_depth_ = 0;
    double finest_step_ = 0;
    ProceduralHeights heights_;
    std::vector<double> errors_;  // by depth of the diamonds' triangles
};

}  // namespace tetrakis::lod
