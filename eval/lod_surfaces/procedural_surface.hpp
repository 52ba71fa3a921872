#pragma once

#include "surface.hpp"

#include <cstdint>
#include <functional>
#include <vector>

namespace tetrakis::lod {

/// Heights that are computed where they are asked for, with what has to be known of them everywhere. The functions say
/// the same each time and may be called by any threads at once.
struct ProceduralHeights {
    std::function<double(const Vec3d& place)> height;  ///< finite: what asks for others throws invalid_input
    /// How far heights over a triangle in space, in a ball of this radius, are at most from the plane between those at
    /// its corners. Does not fall as radii grow.
    std::function<double(double radius)> deviation;
    double slope = 0;          ///< the most that a height changes along a way, as a part of its length
    double low = 0, high = 0;  ///< heights are between these
};

/// An example of such heights: `octaves` layers of waves in random directions, each with half the wavelength and half
/// the height of the one before. The bounds follow from the largest derivatives of the waves.
/// @param amplitude   of the first layer: heights are less than twice as large
/// @param wavelength  of the first layer, about
/// @throws Error      invalid_input: an amplitude that is negative, a wavelength that is not positive, octaves that are
///                    not from 1 to 48
ProceduralHeights fractal_heights(double amplitude, double wavelength, int octaves, std::uint64_t seed = 1);

/// A plane or a ball with procedural heights, down to triangles of a given size: of the earth's radius with details of
/// 1.2 centimetres, if heights have them. Nothing is stored.
class ProceduralSurface final : public Surface {
  public:
    /// A square about the origin, heights along z at (x, y, 0). uv: (x, y) from the corner of the lowest ones, in
    /// sides.
    /// @param finest  triangles with longest sides of this length or less are not split; a side at most
    /// @throws Error  invalid_input: lengths that are not positive, a function that is missing, bounds that contradict
    ///                each other; unsupported: more levels than sites have
    static ProceduralSurface plane(double side, double finest, ProceduralHeights heights);
    /// A ball about the origin, heights outwards, at places on the ball. uv: as of PlanetSurface.
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
    double step_;    // of lattice level 0, where it is longest
    int max_depth_ = 0;
    double finest_step_ = 0;
    ProceduralHeights heights_;
    std::vector<double> errors_;  // by depth of the diamonds' triangles
};

}  // namespace tetrakis::lod
