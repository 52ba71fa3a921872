#pragma once

#include "../../hier/base/memory.hpp"
#include "../../hier/base/vec.hpp"
#include "../../hier/forest/sqrt3_levels.hpp"

#include <cstdint>
#include <span>

namespace tetrakis::detail {

/// Points of all vertices of Sqrt3Levels, level by level, where what they depend on has been raised. They are those of
/// Sqrt3Points, bit for bit.
class Sqrt3Net {
  public:
    /// At level 0. Keeps a reference.
    explicit Sqrt3Net(const Sqrt3Levels& levels);

    int level() const { return level_; }
    bool at_last() const { return level_ + 1 == static_cast<int>(levels_->levels.size()); }
    /// Whether the vertex has a point at this level.
    bool has(std::uint32_t vertex) const { return has_[vertex] != 0; }
    const Vec3d& point(std::uint32_t vertex) const { return points_[vertex]; }

    /// Where limits go: vertex v has the place number[v], if it is there. Those found are marked.
    struct Limits {
        std::span<const std::uint32_t> number;
        std::span<Vec3d> positions;
        std::span<Vec3d> normals;  ///< may be empty
        std::span<std::uint8_t> found;
    };
    /// Goes to the next level, unless this is the last, and writes the limits of the vertices whose rings have them
    /// here.
    void step(const Limits& limits);

    static constexpr std::uint32_t no_number = 0xFFFF'FFFFu;

  private:
    class Worker;

    const Sqrt3Level& here() const { return levels_->levels[static_cast<std::size_t>(level_)]; }
    bool may_be_flipped() const;
    /// Then face f has point f of those that came with the last step.
    bool is_whole() const { return all_raised_ && !has_cuts_; }
    bool is_smooth_cut(std::uint32_t h) const;
    std::uint32_t born_at(int level) const;
    void find_leaving();

    const ControlMesh* mesh_;
    const Sqrt3Levels* levels_;
    bool tagged_ = false;     ///< some vertices of the mesh are
    bool has_cuts_ = false;   ///< some edges are not flipped
    bool all_raised_ = true;  ///< no face of a level before is left out: all vertices have points
    int level_ = 0;
    std::uint32_t first_new_ = 0;  ///< vertices from here on came with the last step
    HugeBuffer<double> memory_[2];
    Vec3d *points_, *next_points_;             // per vertex, of which those that has_ says are written
    PoolVector<std::uint8_t> has_, next_has_;  // of the vertices that the level has
    PoolVector<std::uint32_t> leaving_;        // per vertex: the first half-edge of the level that leaves it
};

}  // namespace tetrakis::detail
