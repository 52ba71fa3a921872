#pragma once

#include "control_mesh.hpp"

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace tetrakis {

/// Faces with more corners keep their centre: n - 2 triangles instead of n would save almost nothing.
inline constexpr std::uint32_t k_max_fan_corners = 32;

/// For each accepted face of a control mesh, a triangulation of its corners (eval/README.md, Coarsest mesh).
struct FanChoice {
    std::vector<std::uint32_t> offsets;                  ///< F + 1 numbers into `triangles`
    std::vector<std::array<std::uint8_t, 3>> triangles;  ///< corner numbers within the face, counter-clockwise

    bool has(FaceId f) const { return f.value + 1ull < offsets.size() && offsets[f.value] < offsets[f.value + 1]; }
    /// The n - 2 triangles of a face; none if the face is not accepted.
    std::span<const std::array<std::uint8_t, 3>> of(FaceId f) const {
        return std::span(triangles).subspan(offsets[f.value], offsets[f.value + 1] - offsets[f.value]);
    }
};

/// Chooses triangulations for the faces that are no holes, in order. Ears are cut at the shortest diagonal first (in a
/// quadrilateral, the shorter one). A diagonal must lie inside the face, and no edge of the mesh or diagonal of an
/// earlier face may join its ends. If that fails, the face is not accepted; nor is a triangle whose three edges all
/// lead to one accepted neighbour. So any subset of the accepted faces may be output in this way, in a mesh whose other
/// vertices each belong to one site.
/// @param positions  output positions of the control vertices (limit points, displaced, ...)
/// Cost: O(H) for bounded valences and face sizes.
FanChoice choose_fans(const ControlMesh& mesh, std::span<const Vec3d> positions);

}  // namespace tetrakis
