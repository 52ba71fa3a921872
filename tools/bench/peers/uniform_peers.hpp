#pragma once

#include "../../../hier/mesh/control_mesh.hpp"
#include "../../../schemes/core/scheme_table.hpp"

#include <cstdint>
#include <functional>
#include <memory>
#include <string_view>

namespace tetrakis::bench {

/// Task of a peer's uniform refinement.
struct UniformTask {
    const ControlMeshData& data;
    std::string_view scheme;
    int levels;
    bool limit = false;  ///< compute limit positions and normals (OpenSubdiv only)
};

// Each function makes the peer's input and returns the work to be timed, which returns the number of vertices of the
// last level. The result is empty if the peer does not have the scheme or does not accept the mesh.

/// OpenSubdiv Far: topology and positions of all levels, from flat arrays.
std::function<std::uint64_t()> far_uniform(const UniformTask& task);
/// OpenSubdiv's stencil tables, applied by its CpuEvaluator, in float.
std::function<std::uint64_t()> stencil_evaluation(const UniformTask& task);
/// CGAL's Subdivision_method_3 and OpenMesh's subdividers, in place on a mesh of their own.
std::function<std::uint64_t()> cgal_uniform(const UniformTask& task);
std::function<std::uint64_t()> openmesh_uniform(const UniformTask& task);

}  // namespace tetrakis::bench
