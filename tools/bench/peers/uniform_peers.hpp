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
    SchemeKind scheme;
    int levels;
    bool limit = false;       ///< limit positions and normals (OpenSubdiv)
    std::string_view name{};  ///< of another scheme, as the library calls it (CGAL and OpenMesh)
};

// Each call does the peer's whole job from flat arrays and returns the number of vertices of the last level.

/// OpenSubdiv Far: topology and positions of all levels.
std::uint64_t far_uniform(const UniformTask& task);
/// OpenSubdiv's stencil tables, made here; the function returned applies them (CpuEvaluator, float).
std::function<std::uint64_t()> stencil_evaluation(const UniformTask& task);
/// CGAL's Subdivision_method_3 and OpenMesh's subdividers work in place on a mesh of their own: make it, then refine it
/// by the function returned, which is empty where the peer does not have the scheme or does not take the mesh.
std::function<std::uint64_t()> cgal_uniform(const UniformTask& task);
std::function<std::uint64_t()> openmesh_uniform(const UniformTask& task);

}  // namespace tetrakis::bench
