#pragma once

#include "control_mesh.hpp"

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

/// Joins vertices in one place, so that faces side by side share them, as those of STL converters and game exporters do
/// not: each becomes the first of those that are within the distance of it, of one of these, and so on. Texture
/// coordinates of the same values become one, so that no seam is left between such faces. Corners of a face that fall
/// together become one, and faces left with fewer than three are dropped; tags follow. What else joining brings about
/// (edges of three faces, ...) is left to find_faults() and repair().
/// @param distance  in the unit of the model; 0: the very same coordinates
/// @return  sentences as of repair(); empty: there is nothing to join
/// @throws Error invalid_input: a distance that is negative or not finite, or as repair()
/// Cost: O(V log V), where no vertex has too many others within a few distances.
std::vector<std::string> weld(ControlMeshData& data, double distance = 0);

}  // namespace tetrakis
