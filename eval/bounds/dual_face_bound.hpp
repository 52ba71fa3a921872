#pragma once

#include "dual_face_pieces.hpp"

#include <span>

namespace tetrakis::detail {

/// How far a face of the mesh of a vertex forest's leaves is from the part of the limit surface that it stands for, in
/// both directions, from what is known over the face alone; how, says DualBound.
/// @param end        whether it is no face, but the point where a crease ends
/// @param of_corner  per corner of the face, receives the error over that corner's leaf; where the face is bounded as a
///                   whole, its coarsest leaves have the error and the others none
void bound_dual_face(const DualSurface& surface, const DualFacePieces& pieces, bool end, std::span<double> of_corner);

}  // namespace tetrakis::detail
