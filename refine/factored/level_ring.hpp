#pragma once

#include "../lattices/mesh_level.hpp"

#include <cstdint>
#include <vector>

namespace tetrakis::detail {

/// Around a tagged vertex, counter-clockwise: edge neighbours, half-edges and sharpness now and one level on.
struct LevelRing {
    std::vector<std::uint32_t> halfedges;  ///< outgoing, one per face
    std::vector<std::uint32_t> neighbours;
    std::vector<float> sharpness, child;
    bool boundary = false;

    /// @param v  has faces; the level has tags
    void gather(const MeshLevel& level, CreaseMethod method, std::uint32_t v);
};

/// Weight of the midpoint in the rule of edge e of a level with tags; see edge_crease_weight().
double crease_weight(const MeshLevel& level, CreaseMethod method, std::uint32_t e, LevelRing& scratch);

}  // namespace tetrakis::detail
