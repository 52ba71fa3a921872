#pragma once

#include "tetrakis/eval/bicubic.hpp"
#include "tetrakis/hier/control_mesh.hpp"

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace tetrakis::detail {

/// A cell with all faces that touch it, as a small quad mesh of its own with tags: what is left when a cell is neither
/// a regular patch nor a star. Half-edge 4 f + k starts at corner k of face f; face 0 is the cell, its corners in the
/// order (0,0) (1,0) (1,1) (0,1). Only the rings around the cell's corners are complete; what lies beyond is never
/// needed.
struct QuadLocalMesh {
    static constexpr std::uint32_t none = 0xFFFF'FFFFu;

    std::vector<Vec3d> points;
    std::vector<std::array<std::uint32_t, 4>> faces;
    std::vector<std::uint32_t> twin;          ///< per half-edge; none on the boundary (or beyond the rings)
    std::vector<float> sharpness;             ///< per half-edge: that of its edge
    std::array<float, 4> corner_sharpness{};  ///< of the cell's four corners
    bool chaikin = false;
    /// Chaikin creases alone: per half-edge that starts at a corner of the cell, sharpness of the half at its far end
    /// one level further down (what is sharp around that end lies beyond the rings).
    std::vector<float> far_half;
    /// Chaikin creases alone: the first half-edge of the control vertex among the corners, or none; sums of sharpness
    /// start there.
    std::uint32_t first_half = none;

    static std::uint32_t next(std::uint32_t h) { return (h & ~3u) | ((h + 1) & 3u); }
    static std::uint32_t prev(std::uint32_t h) { return (h & ~3u) | ((h + 3) & 3u); }
    std::uint32_t origin(std::uint32_t h) const { return faces[h >> 2][h & 3]; }
    std::uint32_t ccw(std::uint32_t h) const { return twin[prev(h)]; }
    std::uint32_t cw(std::uint32_t h) const { return twin[h] == none ? none : next(twin[h]); }
};

/// The outgoing half-edges around one corner of the cell, counter-clockwise; at a boundary from its first edge on.
struct CornerFan {
    std::vector<std::uint32_t> outgoing;
    bool boundary = false;
    std::size_t cell_index = 0;  ///< which of them belongs to the cell

    std::size_t faces() const { return outgoing.size(); }
    std::size_t edges() const { return outgoing.size() + (boundary ? 1 : 0); }
};
CornerFan corner_fan(const QuadLocalMesh& mesh, int corner);
/// Sharpness of the fan's edges, counter-clockwise (with the last boundary edge where there is one).
std::vector<float> fan_sharpness(const QuadLocalMesh& mesh, const CornerFan& fan);
/// Ring in the order of RingLimit's weights: centre, e_0, f_0, e_1, f_1, ... (at a boundary the last edge neighbour
/// closes it).
std::vector<Vec3d> fan_ring(const QuadLocalMesh& mesh, const CornerFan& fan);

/// A corner's ring and its tags, apart from the cell: all that one more step around the corner needs, unless its
/// creases are Chaikin's (their sharpness depends on what is beyond the ring).
struct CornerRing {
    std::vector<Vec3d> points;  ///< as fan_ring() has them
    std::vector<float> sharp;   ///< per edge
    float own = 0;
    bool boundary = false;

    /// Tags that a step does not change.
    bool stationary() const;
    /// The ring of the next level.
    void refine();
};

/// Positions of one Catmull-Clark step around the cell: face points of all faces, edge points of the edges at the
/// cell's corners, vertex points of the corners; and the cells' meshes made of them.
class QuadLocalStep {
  public:
    explicit QuadLocalStep(const QuadLocalMesh& mesh);
    /// The quarter at corner k of the cell, with its faces; its frame is the cell's: corner k stays corner k.
    QuadLocalMesh child(int corner) const;

  private:
    float far_half(std::uint32_t h) const;
    std::vector<float> from_first(int corner, std::vector<float> sharpness) const;

    const QuadLocalMesh& mesh_;
    std::vector<Vec3d> face_points_, edge_points_;  ///< per face; per half-edge (both of an edge alike)
    std::array<Vec3d, 4> vertex_points_;
    std::array<CornerFan, 4> fans_;
    std::array<float, 4> child_corner_sharpness_{};
    std::array<std::vector<float>, 4> child_sharp_;  ///< of the fans' edges, in the order of fan_sharpness()
    std::vector<int> corner_of_point_;               ///< which corner of the cell a point is, or -1
    std::vector<float> half_sharpness_;  ///< per half-edge: of the half at its origin (corners of the cell only)
};

}  // namespace tetrakis::detail
