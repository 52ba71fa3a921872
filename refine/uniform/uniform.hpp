#pragma once

#include "../../hier/mesh/control_mesh.hpp"
#include "../rules/polygon_mesh.hpp"
#include "uniform_refiner.hpp"

namespace tetrakis {

/// The control mesh refined everywhere: quads for Catmull-Clark, triangles for Loop, as many levels as asked.
///
/// Faces and vertices are in the order of UniformRefiner, but holes are left out, and then, as isolated vertices
/// always, the vertices that no face uses any more; no level at all keeps the control faces as they are. UVs follow the
/// face-varying rule (see uv_mesh()); materials and groups are those of the control face.
/// @param mesh    control mesh; Loop: triangles only
/// @param levels  >= 0; each level has four times as many faces
/// @throws Error  invalid_input: levels < 0, or Loop on other faces than triangles; unsupported: corner angles, more
/// elements than 32
///                bits can count; memory_limit; cancelled
/// Cost: O(H 4^levels), parallel over elements; the same bytes for any number of threads.
PolygonMesh refine_uniform(const ControlMesh& mesh, SchemeKind scheme, int levels, const UniformOptions& options = {});

}  // namespace tetrakis
