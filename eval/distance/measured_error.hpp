#pragma once

#include <cstdint>

namespace tetrakis {

/// Distances found by dense sampling, in the unit of the model. Forward distances are exact: from a point of the
/// reference to the nearest point of the mesh. Backward distances to a limit surface are never too small. They are too
/// large where descent, from a lattice of points of every patch near enough, ends in local minima only. Nothing here is
/// cut down to what is certified: more than that means an error in the bound, or backward such a local minimum.
struct MeasuredError {
    double forward = 0;    ///< reference (limit surface, displaced surface or target) -> mesh, largest
    double backward = 0;   ///< mesh -> reference, largest
    double hausdorff = 0;  ///< the larger of both
    /// Over the samples of both directions, weighted by area.
    double mean = 0, rms = 0;
    std::uint64_t forward_samples = 0, backward_samples = 0;
};

}  // namespace tetrakis
