#pragma once

#include "../../../hier/mesh/control_mesh.hpp"
#include "../../../schemes/core/scheme_table.hpp"

#include <cstdint>
#include <functional>
#include <memory>
#include <string_view>

namespace tetrakis::bench {

/// What a peer's uniform refinement is asked for.
struct UniformTask {
    const ControlMeshData& data;
    std::string_view scheme;
    int levels;
    bool limit = false;  ///< limit positions and normals (OpenSubdiv)
};

// Each makes what the peer starts from, and returns what is to be timed, which returns the number of vertices of the
// last level; nothing where the peer does not have the scheme or does not take the mesh.

/// OpenSubdiv Far: topology and positions of all levels, from flat arrays.
std::function<std::uint64_t()> far_uniform(const UniformTask& task);
/// OpenSubdiv's stencil tables, applied by its CpuEvaluator, in float.
std::function<std::uint64_t()> stencil_evaluation(const UniformTask& task);
/// CGAL's Subdivision_method_3 and OpenMesh's subdividers, in place on a mesh of their own.
std::function<std::uint64_t()> cgal_uniform(const UniformTask& task);
std::function<std::uint64_t()> openmesh_uniform(const UniformTask& task);

}  // namespace tetrakis::bench
