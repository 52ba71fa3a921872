#pragma once

#include <cstdint>

namespace tetrakis {

/// Distances found by dense sampling, in the unit of the model.
struct MeasuredError {
    double forward = 0;    ///< reference (limit surface, displaced surface or target) -> mesh, largest
    double backward = 0;   ///< mesh -> reference, largest
    double hausdorff = 0;  ///< the larger of both
    /// Over the samples of both directions, weighted by area. Backward, from points that descent finds nearby, the
    /// largest by a search of all: never too small.
    double mean = 0, rms = 0;
    std::uint64_t forward_samples = 0, backward_samples = 0;
};

}  // namespace tetrakis
