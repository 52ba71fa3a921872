#pragma once

#include "../../hier/base/run_context.hpp"
#include "../../refine/adaptive/hierarchy.hpp"
#include "../distance/hausdorff.hpp"
#include "../distance/limit_samples.hpp"
#include "exported_mesh.hpp"
#include "surface_map.hpp"
#include "tessellate.hpp"

#include <functional>
#include <span>
#include <vector>

namespace tetrakis::detail {

/// How often pieces are cut in four for a reference: so that it has some ten thousands of triangles or more, and twice
/// at least (once where there are more than a quarter of a million pieces).
int reference_bits(std::size_t pieces, int deepest_lattice_level);

/// @throws Error  memory_limit: a reference of so many triangles does not fit
void check_reference_memory(std::uint64_t triangles, const RunContext& context);

/// A denser mesh of limit points to measure a tessellation against: the pieces (triangles of a hierarchy that meet edge
/// to edge), each cut in four `bits` times. Reports "measure" from 0 to `share`.
template <class Family>
TriangleMesh limit_reference(const Hierarchy& points, std::span<const CellTriangle> pieces, int bits,
                             const RunContext& context, double share);

/// The distances between a tessellation and its reference, both ways, by so many of compare()'s samples, into
/// measured_error and triangle_error: what a triangle of the reference is off counts for the triangle that it is
/// nearest to.
void measure_triangles(const TriangleMesh& reference, Tessellation& result, std::uint64_t samples,
                       const RunContext& context);

}  // namespace tetrakis::detail

namespace tetrakis {

/// Measures a tessellation against its surface by dense sampling, both directions (eval/README.md, Errors).
///
/// Samples: the barycentric lattice of every triangle (at least 3 intervals a side, more until there are about
/// `samples` in all), on the surface and on the triangle. What is far below the tolerance counts as far as it is from
/// its own triangle. Else, forward: each surface point to the nearest triangle by Embree, in double; backward: each
/// point of a triangle to the surface, by Newton's method from the parameters it came with, above the tolerance by
/// Embree's search of the whole surface; and from samples that their neighbours do not exceed up to local maxima.
/// Without a tolerance the largest distance takes its place. Mean and RMS weigh samples by the area of their triangle.
/// With a target, forward is sampled on the target too, evenly by area: what no point was projected to counts.
/// @param samples         that are aimed at, each way
/// @param tolerance       infinite: none
/// @param origin          where the triangle of that number comes from
/// @param triangle_error  receives the largest error found at each triangle
template <class Family>
MeasuredError measure(const TriangleMesh& mesh, const std::function<OutputTriangle(std::uint32_t)>& origin,
                      const SurfaceMap<Family>& map, const typename Family::Closest& closest, std::uint64_t samples,
                      double tolerance, std::vector<double>& triangle_error, const RunContext& context);

}  // namespace tetrakis
