#pragma once

#include "../core/rule_mesh.hpp"

#include <vector>

namespace tetrakis {

/// The sharp edges of a mesh, boundary included, as control polygons of curves.
struct CreaseChain {
    std::vector<int> vertices;  ///< in order; a closed chain does not repeat its first
    bool closed = false;
};

/// Every sharp edge is in exactly one chain. Chains go on through vertices with two sharp edges and no tag, and end at
/// corners and darts, or close. Those with ends come first, in the order of
/// their first vertex, then loops in the order of their first edge.
std::vector<CreaseChain> crease_chains(const RuleMesh& mesh);

}  // namespace tetrakis
