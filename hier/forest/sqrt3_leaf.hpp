#pragma once

#include "../base/ids.hpp"
#include "sqrt3_lattice.hpp"

#include <array>
#include <cstdint>

namespace tetrakis {

/// A triangle of an adaptive sqrt(3) mesh.
struct Sqrt3Leaf {
    /// The face of a level itself; or, where `half`, the part of a split face over one of its half-edges, `face` being
    /// the half-edge's number: its edge is flipped when the face beyond is split, too.
    std::uint8_t level = 0;
    bool half = false;
    std::uint64_t face = 0;
    FaceId control_face;
    std::array<Sqrt3Vertex, 3> vertex{};
    /// Per vertex a level that has it (the finest that the leaf knows of), and a half-edge that leaves it there.
    std::array<std::uint8_t, 3> vertex_level{};
    std::array<std::uint64_t, 3> leaving{};
};

}  // namespace tetrakis
