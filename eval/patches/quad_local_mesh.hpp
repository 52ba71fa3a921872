#pragma once

#include "../../hier/base/memory.hpp"
#include "../../hier/mesh/control_mesh.hpp"
#include "bicubic.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory_resource>
#include <span>
#include <vector>

namespace tetrakis::detail {

/// Memory of one growing step, given back as a whole: almost always the block in place is enough.
class GrowthScratch {
  public:
    GrowthScratch() = default;
    GrowthScratch(const GrowthScratch&) = delete;
    GrowthScratch& operator=(const GrowthScratch&) = delete;
    std::pmr::memory_resource* resource() { return &resource_; }

  private:
    alignas(std::max_align_t) std::array<std::byte, 40 * 1024> block_;
    std::pmr::monotonic_buffer_resource resource_{block_.data(), block_.size()};
};

/// Pool memory for what is kept.
class PoolResource final : public std::pmr::memory_resource {
    void* do_allocate(std::size_t bytes, std::size_t) override { return PoolNew::operator new(bytes); }
    void do_deallocate(void* memory, std::size_t bytes, std::size_t) override { free_memory(memory, bytes); }
    bool do_is_equal(const std::pmr::memory_resource& other) const noexcept override {
        return dynamic_cast<const PoolResource*>(&other) != nullptr;
    }
};
std::pmr::memory_resource* pool_resource();

/// A cell with all faces that touch it, as a small quad mesh of its own with tags: what is left when a cell is neither
/// a regular patch nor a star. Half-edge 4 f + k starts at corner k of face f; face 0 is the cell, its corners in the
/// order (0,0) (1,0) (1,1) (0,1). Only the rings around the cell's corners are complete; what lies beyond is never
/// needed.
struct QuadLocalMesh : PoolNew {
    static constexpr std::uint32_t none = 0xFFFF'FFFFu;

    explicit QuadLocalMesh(std::pmr::memory_resource* memory)
        : points(memory), faces(memory), twin(memory), sharpness(memory), far_half(memory) {}
    /// A copy of one.
    QuadLocalMesh(const QuadLocalMesh& from, std::pmr::memory_resource* memory)
        : points(from.points, memory),
          faces(from.faces, memory),
          twin(from.twin, memory),
          sharpness(from.sharpness, memory),
          corner_sharpness(from.corner_sharpness),
          chaikin(from.chaikin),
          far_half(from.far_half, memory),
          first_half(from.first_half) {}

    std::pmr::vector<Vec3d> points;
    std::pmr::vector<std::array<std::uint32_t, 4>> faces;
    std::pmr::vector<std::uint32_t> twin;     ///< per half-edge; none on the boundary (or beyond the rings)
    std::pmr::vector<float> sharpness;        ///< per half-edge: that of its edge
    std::array<float, 4> corner_sharpness{};  ///< of the cell's four corners
    bool chaikin = false;
    /// Chaikin creases alone: per half-edge that starts at a corner of the cell, sharpness of the half at its far end
    /// one level further down (what is sharp around that end lies beyond the rings).
    std::pmr::vector<float> far_half;
    /// Chaikin creases alone: the first half-edge of the control vertex among the corners, or none; sums of sharpness
    /// start there.
    std::uint32_t first_half = none;

    std::size_t memory_bytes() const {
        const auto bytes = [](const auto& values) { return values.capacity() * sizeof(values[0]); };
        return sizeof(QuadLocalMesh) + bytes(points) + bytes(faces) + bytes(twin) + bytes(sharpness) + bytes(far_half);
    }
    static std::uint32_t next(std::uint32_t h) { return (h & ~3u) | ((h + 1) & 3u); }
    static std::uint32_t prev(std::uint32_t h) { return (h & ~3u) | ((h + 3) & 3u); }
    std::uint32_t origin(std::uint32_t h) const { return faces[h >> 2][h & 3]; }
    std::uint32_t ccw(std::uint32_t h) const { return twin[prev(h)]; }
    std::uint32_t cw(std::uint32_t h) const { return twin[h] == none ? none : next(twin[h]); }
};

/// The outgoing half-edges around one corner of the cell, counter-clockwise; at a boundary from its first edge on.
struct CornerFan {
    std::pmr::vector<std::uint32_t> outgoing;
    bool boundary = false;
    std::size_t cell_index = 0;  ///< which of them belongs to the cell

    std::size_t faces() const { return outgoing.size(); }
    std::size_t edges() const { return outgoing.size() + (boundary ? 1 : 0); }
};
CornerFan corner_fan(const QuadLocalMesh& mesh, int corner, std::pmr::memory_resource* memory);
/// Sharpness of the fan's edges, counter-clockwise (with the last boundary edge where there is one).
std::pmr::vector<float> fan_sharpness(const QuadLocalMesh& mesh, const CornerFan& fan);
/// The far end of the fan's edge i, and the far corner of its face i.
inline const Vec3d& fan_edge(const QuadLocalMesh& mesh, const CornerFan& fan, std::size_t i) {
    if (i == fan.outgoing.size()) return mesh.points[mesh.origin(QuadLocalMesh::prev(fan.outgoing[i - 1]))];
    return mesh.points[mesh.origin(QuadLocalMesh::next(fan.outgoing[i]))];
}
inline const Vec3d& fan_face(const QuadLocalMesh& mesh, const CornerFan& fan, std::size_t i) {
    return mesh.points[mesh.origin(fan.outgoing[i] ^ 2u)];
}
/// Ring in the order of RingLimit's weights: centre, e_0, f_0, e_1, f_1, ... (at a boundary the last edge neighbour
/// closes it).
std::pmr::vector<Vec3d> fan_ring(const QuadLocalMesh& mesh, const CornerFan& fan);

/// Positions of one Catmull-Clark step around the cell: face points of all faces, edge points of the edges at the
/// cell's corners, vertex points of the corners; and the cells' meshes made of them.
class QuadLocalStep {
  public:
    /// `memory` outlives the step and the children it makes.
    QuadLocalStep(const QuadLocalMesh& mesh, std::pmr::memory_resource* memory);
    /// The quarter at corner k of the cell, with its faces; its frame is the cell's: corner k stays corner k.
    QuadLocalMesh child(int corner) const;

  private:
    float far_half(std::uint32_t h) const;
    std::pmr::vector<float> from_first(int corner, std::pmr::vector<float> sharpness) const;

    const QuadLocalMesh& mesh_;
    std::pmr::memory_resource* memory_;
    std::pmr::vector<Vec3d> face_points_, edge_points_;  ///< per face; per half-edge (both of an edge alike)
    std::array<Vec3d, 4> vertex_points_;
    std::array<CornerFan, 4> fans_;
    std::array<float, 4> child_corner_sharpness_{};
    std::array<std::pmr::vector<float>, 4> child_sharp_;  ///< of the fans' edges, in the order of fan_sharpness()
    std::pmr::vector<int> corner_of_point_;               ///< which corner of the cell a point is, or -1
    std::pmr::vector<float> half_sharpness_;  ///< per half-edge: of the half at its origin (corners of the cell only)
};

}  // namespace tetrakis::detail
