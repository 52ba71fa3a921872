#pragma once

#include "../../hier/base/run_context.hpp"
#include "../../hier/forest/sqrt3_forest.hpp"
#include "../rules/polygon_mesh.hpp"

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

namespace tetrakis {

class Sqrt3Levels;

struct Sqrt3MeshOptions {
    bool limit = true;     ///< vertices on the limit surface; else in the net of the finest level around each
    bool normals = false;  ///< limit normals
    /// In the net a half triangle counts as one of the level that the whole one over its edge belongs to, at all its
    /// corners; else at its apex alone, which is the first to have it.
    bool halves_are_finer = false;
    bool leaves = true;    ///< list them, a hundred bytes each
    bool vertices = true;  ///< say what they are, twenty bytes each
    RunContext context{};
};

/// An adaptive sqrt(3) mesh: triangles in the order of Sqrt3Forest::leaves(), vertices in order of first use. It
/// depends on the set of split faces alone. Materials and groups are those of the control face that a triangle comes
/// from, in which it lies where the edges between are kept (Sqrt3Forest); no UVs.
struct Sqrt3Mesh {
    PolygonMesh mesh;
    std::vector<Sqrt3Vertex> vertices;  ///< empty unless the options ask for them, as are levels
    std::vector<int> levels;            ///< per vertex: the finest level around it
    std::vector<Sqrt3Leaf> leaves;      ///< of the triangles; empty unless the options ask for them
};

/// Refuses a mesh with a vertex that has no limit: where a crease that stays sharp ends between two triangles.
/// O(vertices).
/// @throws Error  unsupported: names the vertex
void require_sqrt3_limits(const ControlMesh& mesh);

/// Cost: 0.15 to 1 microsecond a vertex, limit included. What vertices depend on around the leaves, some two
/// hundred points of each level where few leaves are side by side, is raised for parts of the leaves at a time where it
/// would take more than 256 bytes a leaf and 32 MiB, or than the context allows. By the context's threads.
/// @throws Error  memory_limit: the context does not even allow the levels of the leaves; cancelled; with limits or
///                normals as require_sqrt3_limits()
Sqrt3Mesh sqrt3_mesh(const Sqrt3Forest& forest, const Sqrt3MeshOptions& options = {});
/// And shows the levels that it is made from.
/// @param show  called once, with the number of each vertex among those of the levels
Sqrt3Mesh sqrt3_mesh(
    const Sqrt3Forest& forest, const Sqrt3MeshOptions& options,
    const std::function<void(const Sqrt3Levels& levels, std::span<const std::uint32_t> vertices)>& show);

}  // namespace tetrakis
