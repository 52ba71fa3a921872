#pragma once

#include "../../hier/base/memory.hpp"
#include "loop_ring.hpp"
#include "loop_star.hpp"

#include <atomic>
#include <cstdint>
#include <memory>

namespace tetrakis::detail {

/// A chain of stars, each inside the one before, towards an extraordinary corner: the first link holds a star's points,
/// each further one a step (loop_star_step). Links grow on demand; every thread would build the same bits. They belong
/// to the pool.
class LoopStarChain {
  public:
    /// A link with room for `size` points.
    static LoopStarChain& make(RecordPool& pool, int valence, int size);
    LoopStarChain(const LoopStarChain&) = delete;
    LoopStarChain& operator=(const LoopStarChain&) = delete;

    int valence() const { return valence_; }
    Vec3d* points() { return reinterpret_cast<Vec3d*>(this + 1); }
    const Vec3d* points() const { return reinterpret_cast<const Vec3d*>(this + 1); }
    /// The next link, which is one step finer.
    const LoopStarChain& next() const;
    /// No point of the star is farther from its corner, points()[0]; nor is the surface of the cell.
    float reach() const { return reach_; }
    /// Once the points are there.
    void find_reach();

  private:
    LoopStarChain(RecordPool& pool, int valence) : pool_(&pool), valence_(valence) {}

    mutable std::atomic<LoopStarChain*> next_{nullptr};
    RecordPool* pool_;
    int valence_;
    float reach_ = 0;
};

class LoopNode;

/// A cell of the patch tree as a descent sees it. Its frame is the parent's quarter turned by `turn`: its corner i is
/// corner (i + turn) mod 3 of that quarter.
struct LoopCell {
    enum class Kind : std::uint8_t {
        regular,  ///< one patch
        star,     ///< corner 0 is smooth and extraordinary, the others are regular
        generic,  ///< tags or irregular boundaries: the rings of its corners
        split,    ///< a root with two or three smooth extraordinary corners
    };
    Kind kind = Kind::regular;
    int turn = 0;
    Net12 net;                            ///< regular
    const LoopStarChain* star = nullptr;  ///< star
    const LoopNode* node = nullptr;       ///< generic
    std::uint32_t face = 0;               ///< split

    LoopCell() {}
    LoopCell(const LoopCell& other) { *this = other; }
    /// The net is copied only where there is one: cells change hands more often than patches are met.
    LoopCell& operator=(const LoopCell& other) {
        kind = other.kind;
        turn = other.turn;
        star = other.star;
        node = other.node;
        face = other.face;
        if (kind == Kind::regular) net = other.net;
        return *this;
    }
};

/// A node of the tree below a generic cell.
class LoopNode {
  public:
    LoopNode(LoopRings rings, RecordPool& pool);
    LoopNode(const LoopNode&) = delete;
    LoopNode& operator=(const LoopNode&) = delete;
    ~LoopNode();

    /// The cell, in its simplest form.
    void cell(LoopCell& out) const;
    const LoopNode& child(int quarter) const;
    const LoopRings& rings() const { return *rings_; }  ///< of a generic cell

  private:
    LoopCell::Kind kind_ = LoopCell::Kind::generic;
    int turn_ = 0;
    std::unique_ptr<Net12> net_;
    LoopStarChain* star_ = nullptr;
    std::unique_ptr<LoopRings> rings_;
    using Children = std::array<std::unique_ptr<LoopNode>, 4>;
    mutable std::atomic<Children*> children_{nullptr};
    RecordPool* pool_;
};

/// Which corner of its cell a point is, or -1.
inline int corner_at(const Bary& b) { return b[0] == 1 ? 0 : b[1] == 1 ? 1 : b[2] == 1 ? 2 : -1; }

/// Which quarter of its cell a point is in: 0, 1, 2 at the corners, 3 the centre. On the border of several, not 0 if it
/// can be avoided (a star's quarter 0 is the irregular one).
inline int quarter_of(const Bary& b) { return b[1] >= 0.5 ? 1 : b[2] >= 0.5 ? 2 : b[0] > 0.5 ? 0 : 3; }

/// Coordinates in a quarter from those in its cell; exact for lattice points.
inline Bary in_quarter(const Bary& b, int quarter) {
    if (quarter == 3) return {1 - 2 * b[0], 1 - 2 * b[1], 1 - 2 * b[2]};
    Bary out{2 * b[0], 2 * b[1], 2 * b[2]};
    out[quarter] -= 1;
    return out;
}

inline Bary turned(const Bary& b, int turn) {
    return turn == 0 ? b : turn == 1 ? Bary{b[1], b[2], b[0]} : Bary{b[2], b[0], b[1]};
}

}  // namespace tetrakis::detail
