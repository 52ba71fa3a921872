#pragma once

#include "tetrakis/hier/control_mesh.hpp"

namespace tetrakis {

/// The UV layer as a control mesh of its own: same faces, so the same half-edge numbers, but cut open along UV seams;
/// its positions are (u, v, 0). Refining it as a surface refines the UVs: an edge is a seam where the UV numbers of its
/// two sides differ, seams are boundaries, and creases and corners of the mesh carry over where they are not on a seam.
/// What the face-varying rule keeps is a corner of it; where several charts, or parts of one, touch in a single UV of a
/// vertex, it stays, as in OpenSubdiv; linear_all is not in the mesh: its caller interpolates linearly instead.
/// @param mesh  must have UVs
ControlMesh uv_mesh(const ControlMesh& mesh);

}  // namespace tetrakis
