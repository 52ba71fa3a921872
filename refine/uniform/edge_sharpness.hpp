#pragma once

#include "../../hier/mesh/control_mesh.hpp"

#include <cstdint>
#include <vector>

namespace tetrakis::detail {

/// Sharpness of the pieces of control edges at any level, without storing the pieces. Level k cuts an edge into 2^k.
class EdgeSharpness {
  public:
    /// O(H); with Chaikin creasing also the levels' values at the ends of edges, until all finite sharpness is gone.
    explicit EdgeSharpness(const ControlMesh& mesh);

    /// Piece i, 0 <= i < 2^level, counted from origin(h), of h's edge. O(1); Chaikin: O(level) on a semi-sharp edge.
    float piece(HalfedgeId h, int level, std::uint64_t i) const;
    /// Piece 0 of h's edge: the sharpness at the vertex that h starts from. O(1).
    float at_origin(HalfedgeId h, int level) const;
    /// Sharpness of a vertex of the control mesh at that level.
    float vertex(VertexId v, int level) const;

  private:
    float chaikin_piece(EdgeId e, int level, std::uint64_t i) const;
    const ControlMesh* mesh_;
    bool chaikin_ = false;
    /// Chaikin: [level][2 e + side], the piece at the edge's origin (side 0) or target, seen from its first half-edge.
    std::vector<std::vector<float>> ends_;
};

}  // namespace tetrakis::detail
