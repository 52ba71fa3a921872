#pragma once

#include "control_mesh.hpp"

#include <string>
#include <vector>

namespace tetrakis {

/// Makes the data an oriented 2-manifold with sound tags, by repairs that move no vertex and invent no face. Dropped
/// are: layers of wrong size, faces with bad vertices, duplicate faces, isolated vertices, and tags that name nothing.
/// A face that visits a vertex twice is cut into its loops; loops of fewer than three corners are dropped. Edges of
/// more than two faces, and vertices whose faces are not one fan, are split into boundaries. Each connected piece gets
/// the orientation that most of its faces had; a piece that cannot be oriented is cut open. Bad texture coordinates
/// become (0, 0); the others, normals, materials, groups, lines and tags follow. If any face is left, find_faults()
/// finds nothing afterwards.
/// @return  one sentence for each kind of repair, with its count and first element; empty: the data was sound
/// @throws Error invalid_input: face_offsets and face_vertices do not match
/// Cost: O(H log H); the same result for any number of threads.
std::vector<std::string> repair(ControlMeshData& data);

/// Joins vertices at the same position, so that adjacent faces share them; files of STL converters and game exporters
/// need this. Vertices within the distance of each other, also by way of others in between, become the first of them.
/// Equal texture coordinates become one, so no seam remains between such faces. Corners of a face that coincide become
/// one, and faces with fewer than three corners left are dropped; tags follow. Other faults that this causes (such as
/// edges of three faces) are left to find_faults() and repair().
/// @param distance  in the unit of the model; 0: only exactly equal coordinates
/// @return  sentences as from repair(); empty: there was nothing to join
/// @throws Error invalid_input: a distance that is negative or not finite, or as repair()
/// Cost: O(V log V), unless vertices have very many others within a few distances.
std::vector<std::string> weld(ControlMeshData& data, double distance = 0);

}  // namespace tetrakis
