#pragma once

#include "tetrakis/hier/control_mesh.hpp"
#include "tetrakis/hier/run_context.hpp"
#include "tetrakis/refine/polygon_mesh.hpp"
#include "tetrakis/schemes/scheme_kind.hpp"

namespace tetrakis {

struct UniformOptions {
    bool limit = false;    ///< put the vertices on the limit surface
    bool normals = false;  ///< limit normals (with or without `limit`)
    RunContext context{};
};

/// The control mesh refined everywhere: quads for Catmull-Clark, triangles for Loop, as many levels as asked.
///
/// Vertex order, level by level: the old vertices, then (Catmull-Clark) one per face, then one per edge, each in the
/// order of its parents; faces: the children of a face follow each other (see detail::MeshLevel). Holes are left out,
/// and then, as isolated vertices always, the vertices that no face uses any more, in the same order. UVs follow the
/// face-varying rule (see uv_mesh()); materials and groups are those of the control face.
/// @param mesh    control mesh; Loop: triangles only
/// @param levels  >= 0; each level has four times as many faces
/// @throws Error  invalid_input: levels < 0, or Loop on other faces than triangles; unsupported: more elements than 32
///                bits can count; memory_limit; cancelled
/// Cost: O(H 4^levels), parallel over elements; the same bytes for any number of threads.
PolygonMesh refine_uniform(const ControlMesh& mesh, SchemeKind scheme, int levels, const UniformOptions& options = {});

}  // namespace tetrakis
