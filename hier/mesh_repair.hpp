#pragma once

#include "tetrakis/hier/control_mesh.hpp"

#include <string>
#include <vector>

namespace tetrakis {

/// Makes the data an oriented 2-manifold with sound tags by repairs that move no vertex and invent no face: layers
/// whose size is wrong are dropped, and so are faces with bad vertices, duplicate faces, isolated vertices and tags
/// that name nothing; a face that passes a vertex twice is cut into its loops, those with fewer than three corners
/// dropped; edges of more than two faces and vertices whose faces are no single fan are split into boundaries; faces
/// are oriented alike within each connected piece, as most of them were (a piece that has no orientation is cut open).
/// Texture coordinates, normals, materials, groups, lines and tags follow. Where any face is left, find_faults() finds
/// nothing afterwards.
/// @return  one sentence for each kind of repair done, with how many and the first; empty: the data was fine
/// @throws Error invalid_input: face_offsets and face_vertices do not fit together
/// Cost: O(H log H); the same result for any number of threads.
std::vector<std::string> repair(ControlMeshData& data);

}  // namespace tetrakis
