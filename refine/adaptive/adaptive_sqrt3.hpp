#pragma once

#include "../../hier/base/run_context.hpp"
#include "../../hier/trees/sqrt3_forest.hpp"
#include "../rules/polygon_mesh.hpp"

#include <vector>

namespace tetrakis {

struct Sqrt3MeshOptions {
    /// Vertices on the limit surface; else in the net of the finest level around each. There a half triangle counts as
    /// one of the level that the whole one over its edge belongs to.
    bool limit = true;
    bool normals = false;  ///< limit normals
    RunContext context{};
};

/// An adaptive sqrt(3) mesh: triangles in the order of Sqrt3Forest::for_each_leaf(), vertices in order of first use. It
/// depends on the set of split faces alone. Materials and groups are those of the control face that a triangle comes
/// from, in which it lies where the edges between are kept (Sqrt3Forest); no UVs.
struct Sqrt3Mesh {
    PolygonMesh mesh;
    std::vector<PointId> points;  ///< of the forest, per vertex
};

/// Refuses a mesh with a vertex that has no limit: where a crease that stays sharp ends between two triangles.
/// O(vertices).
/// @throws Error  unsupported: names the vertex
void require_sqrt3_limits(const ControlMesh& mesh);

/// Level by level through the forest. Points whose rings the forest does not have, or that are on or beside edges that
/// are not flipped, are those of Sqrt3Points, as all others are, bit for bit.
/// Cost: 0.2 microseconds a vertex, limit included; of Sqrt3Points some five. By the context's threads.
/// @throws Error  memory_limit: the forest's points take more than the context allows; cancelled; with limits or
///                normals as require_sqrt3_limits()
Sqrt3Mesh sqrt3_mesh(const Sqrt3Forest& forest, const Sqrt3MeshOptions& options = {});

}  // namespace tetrakis
