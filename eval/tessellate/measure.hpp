#pragma once

#include "../../hier/base/run_context.hpp"
#include "../distance/hausdorff.hpp"
#include "../distance/limit_samples.hpp"
#include "../distance/surface_family.hpp"
#include "surface_map.hpp"
#include "tessellate.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <numbers>
#include <vector>

namespace tetrakis::detail {

/// How often a reference cuts each piece in four: at least twice, or once if there are more than 250 000 pieces. It is
/// more often, up to 4 times, as long as the reference has less than 60 000 triangles.
int reference_bits(std::size_t pieces, int deepest_lattice_level);

/// @throws Error  memory_limit: a reference with this number of triangles does not fit
void check_reference_memory(std::uint64_t triangles, const RunContext& context);

/// Measures a tessellation against a reference in both directions, with compare()'s sampling, and sets its
/// measured_error and triangle_error. A distance from a point of the reference counts for the triangle that is nearest
/// to the point.
void measure_triangles(const TriangleMesh& reference, Tessellation& result, std::uint64_t samples,
                       const RunContext& context);

/// Corner i of the regular polygon of n corners about the origin.
inline Vec2d polygon_corner(std::uint32_t n, std::uint32_t i) {
    const double angle = 2 * std::numbers::pi / n * i;
    return {std::cos(angle), std::sin(angle)};
}
inline double cross2(const Vec2d& a, const Vec2d& b) { return a.x * b.y - a.y * b.x; }

/// Where a triangle of the output comes from: a triangle of the hierarchy, or one of a face's fan (eval/README.md).
struct OutputTriangle {
    CellTriangle cell;                          ///< unused if it belongs to a fan
    FaceId fan;                                 ///< the fan's face; invalid for triangles of the hierarchy
    std::array<std::uint32_t, 3> fan_corner{};  ///< numbers of the corners in the fan's face

    /// The surface parameter at barycentrics (b0, b1, b2). A fan's triangles cut a regular polygon whose corners are
    /// those of the face; each root lies over one sector of this polygon.
    template <class Family>
    SurfaceParameter parameter(const ControlMesh& mesh, double b0, double b1, double b2) const {
        if (!fan.valid()) return Family::parameter(mesh, cell, b0, b1, b2);
        const std::uint32_t n = mesh.face_size(fan);
        const auto corner = [n](std::uint32_t i) { return polygon_corner(n, i); };
        const Vec2d p = b0 * corner(fan_corner[0]) + b1 * corner(fan_corner[1]) + b2 * corner(fan_corner[2]);
        double turns = std::atan2(p.y, p.x) / (2 * std::numbers::pi);
        if (turns < 0) turns += 1;
        const std::uint32_t sector = std::min(n - 1, static_cast<std::uint32_t>(turns * n));
        const Vec2d from = corner(sector), to = corner(sector + 1);
        // Rounded to 2^-40, so that corners and sides are exact: patch trees would grow very deep close to them.
        const auto rounded = [](double value) { return std::round(std::max(0.0, value) * 0x1p40) * 0x1p-40; };
        const double det = cross2(from, to), v = rounded(cross2(p, to) / det), w = rounded(cross2(from, p) / det);
        const double sum = std::max(1.0, v + w);
        const CellTriangle root = root_triangle(HalfedgeId(mesh.face_halfedge(fan).value + sector));
        return Family::parameter(mesh, root, v / sum, w / sum, 1 - (v + w) / sum);
    }
    /// The site of corner k, as an address inside one root.
    template <class Family>
    Site corner_site(const ControlMesh& mesh, std::size_t k) const {
        if (!fan.valid()) return Family::corner_site(mesh, cell, k);
        return {HalfedgeId(mesh.face_halfedge(fan).value + fan_corner[k]), {0, 0}, 0};
    }
    /// The canonical site of a point inside the triangle near corner k: `steps` / 2^finer of the way to both others.
    /// For a fan's triangle, in the corner's own root. @param finer  number of levels below the triangle's level
    template <class Family>
    Site inner_site(const ControlMesh& mesh, std::size_t k, int finer, std::uint32_t steps) const {
        if (fan.valid())
            return Family::canonical_site(mesh, {HalfedgeId(mesh.face_halfedge(fan).value + fan_corner[k]),
                                                 {steps, steps},
                                                 static_cast<std::uint8_t>(finer)});
        std::array<int, 3> weight;
        weight.fill(static_cast<int>(steps));
        weight[k] = (1 << finer) - 2 * weight[k];
        return lattice_site_of<Family>(mesh, cell, finer, weight[0] + weight[1], weight[1]);
    }
};

/// Measures a tessellation against its surface by dense sampling, both directions (eval/README.md, Errors).
///
/// Samples: the barycentric lattice of every triangle (at least 3 intervals a side, more until there are about
/// `samples` in all), on the surface and on the triangle. Far below the tolerance, the distance of a surface point to
/// its own triangle counts. Else forward distances go from the surface point to the nearest triangle (Embree, then
/// double). Backward distances go from a point of the triangle to the surface: by Newton's method from its parameters,
/// above the tolerance also from nearby triangles' parameters. The farthest sample of a triangle in each direction
/// climbs to a local maximum. Without a tolerance, the largest distance takes its place. Mean and RMS are weighted by
/// area. With a target, the target itself is sampled, too, evenly by area, for parts that no point was projected to.
/// @param origin          (t) where triangle t comes from
/// @param samples         number of samples to aim at, in each direction
/// @param tolerance       infinite: none
/// @param triangle_error  receives the largest error found at each triangle
template <class Family>
MeasuredError measure(const TriangleMesh& mesh, const std::function<OutputTriangle(std::uint32_t)>& origin,
                      const SurfaceMap<Family>& map, std::uint64_t samples, double tolerance,
                      std::vector<double>& triangle_error, const RunContext& context);

}  // namespace tetrakis::detail
