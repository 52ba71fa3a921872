#pragma once

#include "control_mesh.hpp"

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace tetrakis {

/// Faces with more corners keep their centre: n - 2 triangles instead of n would save next to nothing.
inline constexpr std::uint32_t k_max_fan_corners = 32;

/// For faces of a control mesh, a triangulation over their corners alone (eval/README.md, Coarsest mesh).
struct FanChoice {
    std::vector<std::uint32_t> offsets;                  ///< F + 1 numbers into `triangles`
    std::vector<std::array<std::uint8_t, 3>> triangles;  ///< corner numbers within the face, counter-clockwise

    bool has(FaceId f) const { return f.value + 1ull < offsets.size() && offsets[f.value] < offsets[f.value + 1]; }
    /// n - 2 triangles, or none.
    std::span<const std::array<std::uint8_t, 3>> of(FaceId f) const {
        return std::span(triangles).subspan(offsets[f.value], offsets[f.value + 1] - offsets[f.value]);
    }
};

/// Chooses the triangulations, of all faces but holes, face by face in order: ears are cut at the shortest diagonal
/// first (of a quadrilateral: the shorter diagonal) that lies inside the face, and joins two vertices which neither an
/// edge of the mesh nor a diagonal of an earlier face joins; a face where that fails is not accepted, nor is a triangle
/// whose three edges all lead to one neighbour that was. So any subset of the accepted faces may be output this way in
/// a mesh whose other vertices are of one site each.
/// @param positions  of the control vertices as they will be output (limit points, displaced, ...)
/// Cost: O(H) for bounded valences and face sizes.
FanChoice choose_fans(const ControlMesh& mesh, std::span<const Vec3d> positions);

}  // namespace tetrakis
