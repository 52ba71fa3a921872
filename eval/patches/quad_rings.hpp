#pragma once

#include "../loop_patches/corner_ring.hpp"

#include <array>
#include <cstddef>
#include <vector>

namespace tetrakis::detail {

struct QuadNode;

/// A cell of Catmull-Clark that is neither a regular patch nor a star, by the rings of its corners: (0,0) (1,0) (1,1)
/// (0,1).
struct QuadRings {
    std::array<CornerRing, 4> corner;

    /// The quarters at the corners. Their frames are the cell's: corner k of quarter k is corner k of the cell.
    std::array<QuadRings, 4> children() const;
    /// All points; the limit surface over the cell is in their convex hull.
    std::vector<Vec3d> points() const;
    std::size_t memory_bytes() const;
};

/// Turns a cell into the simplest node that represents it exactly.
void classify(QuadRings rings, QuadNode& node);

}  // namespace tetrakis::detail
