#pragma once

#include "../../hier/base/run_context.hpp"
#include "../surface/triangle_mesh.hpp"
#include "triangle_bvh.hpp"

#include <cstdint>
#include <vector>

namespace tetrakis {

/// Distances found by dense sampling, in the unit of the model. Forward distances are exact: from a point of the
/// reference to the nearest point of the mesh. Backward distances to a limit surface are never too small. They are too
/// large where descent, from the parameters of every triangle near enough, ends in local minima only. Nothing here is
/// cut down to what is certified: more than that means an error in the bound, or backward such a local minimum.
struct MeasuredError {
    double forward = 0;    ///< reference (limit surface, displaced surface or target) -> mesh, largest
    double backward = 0;   ///< mesh -> reference, largest
    double hausdorff = 0;  ///< the larger of both
    /// Over the samples of both directions, weighted by area.
    double mean = 0, rms = 0;
    std::uint64_t forward_samples = 0, backward_samples = 0;
};

/// How densely a mesh is sampled. Every vertex is a sample; so is at least one point inside each triangle and one on
/// each side of each edge; the rest of `samples` goes to the triangles by area, one to each of m^2 equal parts, and to
/// long thin triangles along their edges.
struct SamplingOptions {
    std::uint64_t samples = 500'000;  ///< aimed at for each direction; small triangles may make it more
    /// Searches from the worst samples for a still worse point nearby (0: none), so that the largest distance does not
    /// hang on where the samples happen to lie.
    std::uint32_t climbs = 32;
    bool per_triangle = false;  ///< also give the largest distance of each triangle, of both meshes
    /// A sample counts for the triangle of the other mesh that it is nearest to only within that one's longest side:
    /// samples farther off lie beyond a boundary, where smaller triangles would not help.
    bool within_size = false;
    /// For meshes whose vertices are points of a surface, and which are finer than what they are measured against. Mean
    /// and RMS weigh a vertex by a third of its triangles' area.
    bool vertices_alone = false;
};

/// Distances from the points of one mesh to another.
struct DirectedDistance {
    double max = 0, mean = 0, rms = 0;  ///< mean and RMS are weighted by area
    double area = 0;                    ///< of the sampled mesh
    std::uint64_t samples = 0;
    Vec3d worst_point{0.0};            ///< on the sampled mesh, where `max` was found
    std::uint32_t worst_triangle = 0;  ///< of the sampled mesh
    std::vector<float> triangle_max;   ///< largest sample of each triangle, rounded up; if asked for
    std::vector<float> nearest_max;    ///< the same of the samples that are nearest to each triangle of the other mesh
};

/// Both directions, and what they are made of.
struct MeshComparison {
    MeasuredError error;                 ///< forward: reference to mesh; backward: mesh to reference
    DirectedDistance forward, backward;  ///< forward samples the reference, backward the mesh
    std::uint64_t bvh_bytes = 0;         ///< memory of the larger hierarchy; one at a time is held
};

/// Distances from samples of `mesh` to the nearest point of `to`. Same bytes for any number of threads.
/// @throws Error invalid_input: no triangles, an index out of range or a position that is not finite; cancelled
/// Cost: about half a microsecond a sample and thread for meshes that are close to each other.
DirectedDistance directed_distance(const TriangleMesh& mesh, const TriangleBvh& to, const SamplingOptions& options = {},
                                   const RunContext& context = {});

/// Joins two directions into one measured error: from the reference to the mesh, and back.
MeasuredError measured_error(const DirectedDistance& forward, const DirectedDistance& backward);

/// Symmetric Hausdorff distance of two triangle meshes by dense sampling. What it finds is a lower bound of the true
/// one: each number is the distance of an actual point.
MeshComparison compare(const TriangleMesh& reference, const TriangleMesh& mesh, const SamplingOptions& options = {},
                       const RunContext& context = {});

}  // namespace tetrakis
