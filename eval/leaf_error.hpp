#pragma once

namespace tetrakis {

/// What is known of the distance between a surface and a triangle of a hierarchy.
struct LeafError {
    double lower = 0;  ///< attained at a sample
    double upper = 0;  ///< never exceeded (rounding included)
};

}  // namespace tetrakis
