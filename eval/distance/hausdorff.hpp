#pragma once

#include "../../hier/base/run_context.hpp"
#include "../surface/triangle_mesh.hpp"
#include "triangle_bvh.hpp"

#include <cstdint>
#include <vector>

namespace tetrakis {

/// Distances found by dense sampling, in the unit of the model. Forward distances go from a point of the reference to
/// the nearest point of the mesh and are exact. Backward distances to a limit surface are never too small. They are too
/// large if all descents, from the parameters of every triangle near enough, end in other local minima. Values are not
/// reduced to the certified bound: one above it shows an error in the bound or, backward, such a local minimum.
struct MeasuredError {
    double forward = 0;    ///< reference (limit surface, displaced surface or target) -> mesh, largest
    double backward = 0;   ///< mesh -> reference, largest
    double hausdorff = 0;  ///< the larger of both
    /// Mean and root mean square over the samples of both directions, weighted by area.
    double mean = 0, rms = 0;
    std::uint64_t forward_samples = 0, backward_samples = 0;
};

/// How densely a mesh is sampled. Samples are every vertex, at least one point inside each triangle, and at least one
/// on each edge of each triangle. The rest of `samples` is distributed by area, one to each of m^2 equal parts of a
/// triangle; long thin triangles also get more along their edges.
struct SamplingOptions {
    std::uint64_t samples = 500'000;  ///< aim for each direction; many small triangles may need more
    /// Number of the worst samples from which a still worse point nearby is searched. So the largest distance depends
    /// less on where the samples lie.
    std::uint32_t climbs = 32;
    bool per_triangle = false;  ///< also give the largest distance of each triangle, of both meshes
    /// In `nearest_max`, a sample counts only if its distance to the nearest triangle is at most that triangle's
    /// longest side. Samples farther off lie beyond a boundary, where smaller triangles would not help.
    bool within_size = false;
    /// Only vertices are samples: for meshes whose vertices are surface points, and which are finer than the other
    /// mesh. Mean and RMS weight a vertex by a third of its triangles' area.
    bool vertices_alone = false;
};

/// Distances from the points of one mesh to another.
struct DirectedDistance {
    double max = 0, mean = 0, rms = 0;  ///< mean and RMS are weighted by area
    double area = 0;                    ///< of the sampled mesh
    std::uint64_t samples = 0;
    Vec3d worst_point{0.0};            ///< point of the sampled mesh where `max` was found
    std::uint32_t worst_triangle = 0;  ///< its triangle in the sampled mesh
    std::vector<float> triangle_max;   ///< if per_triangle: largest distance at each triangle, rounded up
    std::vector<float> nearest_max;    ///< the same by triangle of the other mesh: of samples nearest to that one
};

/// Distances of two meshes: both directions together, and each direction.
struct MeshComparison {
    MeasuredError error;                 ///< forward: reference to mesh; backward: mesh to reference
    DirectedDistance forward, backward;  ///< forward samples the reference, backward the mesh
    std::uint64_t bvh_bytes = 0;         ///< memory of the larger of both hierarchies, which exist one at a time
};

/// Distances from samples of `mesh` to the nearest point of `to`. Same bytes for any number of threads.
/// @throws Error invalid_input: no triangles, an index out of range, a coordinate not finite or above 1e60; cancelled
/// Cost: about half a microsecond a sample and thread for meshes that are close to each other.
DirectedDistance directed_distance(const TriangleMesh& mesh, const TriangleBvh& to, const SamplingOptions& options = {},
                                   const RunContext& context = {});

/// Combines both directions, from the reference to the mesh and back, into one measured error.
MeasuredError measured_error(const DirectedDistance& forward, const DirectedDistance& backward);

/// Symmetric Hausdorff distance of two triangle meshes by dense sampling. The result is a lower bound of the true
/// distance, as each number is the distance of an actual point.
MeshComparison compare(const TriangleMesh& reference, const TriangleMesh& mesh, const SamplingOptions& options = {},
                       const RunContext& context = {});

}  // namespace tetrakis
