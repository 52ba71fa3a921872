#pragma once

#include "../../hier/base/run_context.hpp"
#include "../distance/hausdorff.hpp"
#include "../distance/surface_family.hpp"
#include "surface_map.hpp"
#include "tessellate.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <numbers>
#include <span>
#include <vector>

namespace tetrakis::detail {

/// How often pieces are cut in four for a reference: so that it has some ten thousands of triangles or more, and twice
/// at least (once where there are more than a quarter of a million pieces).
int reference_bits(std::size_t pieces, int deepest_lattice_level);

/// @throws Error  memory_limit: a reference of so many triangles does not fit
void check_reference_memory(std::uint64_t triangles, const RunContext& context);

/// The distances between a tessellation and its reference, both ways, by so many of compare()'s samples, into
/// measured_error and triangle_error: what a triangle of the reference is off counts for the triangle that it is
/// nearest to.
void measure_triangles(const TriangleMesh& reference, Tessellation& result, std::uint64_t samples,
                       const RunContext& context);

/// Corner i of the regular polygon of n corners about the origin.
inline Vec2d polygon_corner(std::uint32_t n, std::uint32_t i) {
    const double angle = 2 * std::numbers::pi / n * i;
    return {std::cos(angle), std::sin(angle)};
}
inline double cross2(const Vec2d& a, const Vec2d& b) { return a.x * b.y - a.y * b.x; }

}  // namespace tetrakis::detail

namespace tetrakis {

/// Where a triangle of the output comes from: a triangle of the hierarchy, or one of a face's fan (eval/README.md).
struct OutputTriangle {
    CellTriangle cell;                          ///< unless it belongs to a fan
    FaceId fan;                                 ///< the face; invalid for triangles of the hierarchy
    std::array<std::uint32_t, 3> fan_corner{};  ///< corners of the face, by number in it

    /// The surface point that belongs to barycentrics (b0, b1, b2). A fan's triangles lie in the regular polygon whose
    /// corners are the face's, each root over its sector of it.
    template <class Family>
    SurfaceParameter parameter(const ControlMesh& mesh, double b0, double b1, double b2) const {
        if (!fan.valid()) return Family::parameter(mesh, cell, b0, b1, b2);
        const std::uint32_t n = mesh.face_size(fan);
        using detail::cross2;
        const auto corner = [n](std::uint32_t i) { return detail::polygon_corner(n, i); };
        const Vec2d p = b0 * corner(fan_corner[0]) + b1 * corner(fan_corner[1]) + b2 * corner(fan_corner[2]);
        double turns = std::atan2(p.y, p.x) / (2 * std::numbers::pi);
        if (turns < 0) turns += 1;
        const std::uint32_t sector = std::min(n - 1, static_cast<std::uint32_t>(turns * n));
        const Vec2d from = corner(sector), to = corner(sector + 1);
        // Corners and sides are met exactly: trees would grow down to the last bits beside them.
        const auto rounded = [](double value) { return std::round(std::max(0.0, value) * 0x1p40) * 0x1p-40; };
        const double det = cross2(from, to), v = rounded(cross2(p, to) / det), w = rounded(cross2(from, p) / det);
        const double sum = std::max(1.0, v + w);
        const CellTriangle root = root_triangle(HalfedgeId(mesh.face_halfedge(fan).value + sector));
        return Family::parameter(mesh, root, v / sum, w / sum, 1 - (v + w) / sum);
    }
    /// An address of corner k inside one root.
    template <class Family>
    Site corner_site(const ControlMesh& mesh, std::size_t k) const {
        if (!fan.valid()) return Family::corner_site(mesh, cell, k);
        return {HalfedgeId(mesh.face_halfedge(fan).value + fan_corner[k]), {0, 0}, 0};
    }
    /// An address of a point inside the triangle near corner k: `steps` of 2^finer from the corner towards each of the
    /// two others. Of a fan's triangle, in the corner's own root. @param finer  levels below the triangle's
    template <class Family>
    Site inner_site(const ControlMesh& mesh, std::size_t k, int finer, std::uint32_t steps) const {
        if (fan.valid())
            return {HalfedgeId(mesh.face_halfedge(fan).value + fan_corner[k]),
                    {steps, steps},
                    static_cast<std::uint8_t>(finer)};
        const LatticePoint a = cell.corner[k], b = cell.corner[(k + 1) % 3], c = cell.corner[(k + 2) % 3];
        const std::uint32_t rest = (1u << finer) - 2 * steps;
        const LatticePoint p{rest * a.x + steps * (b.x + c.x), rest * a.y + steps * (b.y + c.y)};
        return Family::lattice_site(mesh, cell.root, p, cell.level + finer);
    }
};

/// Measures a tessellation against its surface by dense sampling, both directions (eval/README.md, Errors).
///
/// Samples: the barycentric lattice of every triangle (at least 3 intervals a side, more until there are about
/// `samples` in all), on the surface and on the triangle. What is far below the tolerance counts as far as it is from
/// its own triangle. Else, forward: each surface point to the nearest triangle by Embree, in double; backward: each
/// point of a triangle to the surface, by Newton's method from the parameters it came with, above the tolerance from
/// those of all triangles near enough, too; and from the farthest sample of a triangle, each way, up to a local
/// maximum. Without a tolerance the largest distance takes its place. Mean and RMS weigh samples by the area of their
/// triangle. With a target, forward is sampled on the target too, evenly by area: what no point was projected to
/// counts.
/// @param samples         that are aimed at, each way
/// @param tolerance       infinite: none
/// @param origin          where the triangle of that number comes from
/// @param triangle_error  receives the largest error found at each triangle
template <class Family>
MeasuredError measure(const TriangleMesh& mesh, const std::function<OutputTriangle(std::uint32_t)>& origin,
                      const SurfaceMap<Family>& map, std::uint64_t samples, double tolerance,
                      std::vector<double>& triangle_error, const RunContext& context);

}  // namespace tetrakis
