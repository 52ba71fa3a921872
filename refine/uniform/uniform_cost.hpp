#pragma once

#include "../../hier/mesh/control_mesh.hpp"
#include "uniform_refiner.hpp"

#include <cstdint>

namespace tetrakis::detail {

/// What a uniform refinement is asked to hold, for uniform_cost().
struct UniformDemand {
    SchemeKind scheme;
    int levels = 0;
    int scalar_bytes = 8;
    bool limit = false, normals = false;
    bool uvs = false;  ///< refined as well
};

/// Elements of the result, and the memory that it and the way to it take.
struct UniformCost {
    std::uint64_t vertices = 0, faces = 0, corners = 0, bytes = 0;
};

/// @throws Error  invalid_input: levels < 0, or Loop on other faces than triangles; unsupported: more than 32 bits can
///                count
UniformCost uniform_cost(const ControlMesh& mesh, const UniformDemand& demand);

/// @throws Error  memory_limit, with the numbers, where the cost is over the context's limit
void check_memory(const ControlMesh& mesh, int levels, const UniformCost& cost, const RunContext& context);

/// Whether all faces have four sides.
bool all_quads(const ControlMesh& mesh);

}  // namespace tetrakis::detail
