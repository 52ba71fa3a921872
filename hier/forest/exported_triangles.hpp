#pragma once

#include "../base/ids.hpp"
#include "../base/memory.hpp"
#include "site.hpp"

#include <array>
#include <cstdint>
#include <vector>

namespace tetrakis {

/// What a forest looks like from outside, in (root, path) order. All but `leaves` and `points` depends on the set of
/// leaves alone, not on how it came about.
struct ExportedTriangles {
    std::vector<std::array<std::uint32_t, 3>> triangles;  ///< corners: numbers into `sites`, counter-clockwise
    std::vector<FaceId> faces;                            ///< per triangle: its control face
    std::vector<Site> sites;                              ///< per point, in order of first use: its canonical site
    std::vector<LeafId> leaves;                           ///< per triangle: its leaf; invalid for a fan's triangles
    std::vector<PointId> points;                          ///< per point: its handle in the forest
};

namespace detail {

/// The same for a caller that copies the triangles: they are in memory that is used again.
struct PooledTriangles {
    RawPoolVector<std::array<std::uint32_t, 3>> triangles;
    std::vector<FaceId> faces;
    std::vector<Site> sites;
    std::vector<LeafId> leaves;
    std::vector<PointId> points;
};

}  // namespace detail

}  // namespace tetrakis
