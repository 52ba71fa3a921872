#pragma once

#include "../../hier/base/memory.hpp"
#include "../../schemes/rules/loop.hpp"
#include "box_spline.hpp"
#include "corner_ring.hpp"

#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

namespace tetrakis::detail {

/// The n + 6 points around a triangle whose corner (0,0) is an interior smooth vertex of valence n and whose other
/// corners are regular (Stam 1998), in the order of Net12 with a ring of n: [0] the corner; [1..n] its ring
/// counter-clockwise, [1] = (1,0), [2] = (0,1); then (2,-1) (2,0) (1,1) (0,2) (-1,2).
constexpr int loop_star_size(int valence) { return valence + 6; }

/// One Loop step of a star: n + 12 points. The first n + 6 are the star of the quarter at the extraordinary corner, at
/// half the size; then, in its lattice, (3,-1) (3,0) (2,1) (1,2) (-1,3) (0,3), which complete the nets of the three
/// regular quarters.
constexpr int loop_star_step_size(int valence) { return valence + 12; }

/// @param star  loop_star_size(valence) points
/// @param step  receives loop_star_step_size(valence) points
void loop_star_step(int valence, double beta, const Vec3d* star, Vec3d* step);

/// Net of a regular quarter from a step: quarter 1 is (mid01, corner 1, mid12), 2 is (mid02, mid12, corner 2), 3 the
/// centre (mid12, mid02, mid01).
void loop_star_quarter(int valence, const Vec3d* step, int quarter, Net12& out);
inline Net12 loop_star_quarter(int valence, const Vec3d* step, int quarter) {
    Net12 out;
    loop_star_quarter(valence, step, quarter, out);
    return out;
}

/// Limit position of the extraordinary corner.
Vec3d loop_star_limit(int valence, const Vec3d* star);
/// Limit position of a regular corner, 1 or 2.
Vec3d loop_star_corner(int valence, const Vec3d* star, int corner);

/// Loop::beta() and Loop::limit_mask() of a valence, without their cosines where a table has them.
struct LoopVertexRule {
    double beta = 0;
    RingMask limit;
};
LoopVertexRule loop_vertex_rule(int valence);

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

  private:
    LoopStarChain(RecordPool& pool, int valence) : pool_(&pool), valence_(valence) {}

    mutable std::atomic<LoopStarChain*> next_{nullptr};
    RecordPool* pool_;
    int valence_;
};

/// A cell that is neither regular nor a star, by the rings of its corners.
struct LoopRings {
    std::array<CornerRing, 3> corner;

    /// The four quarters: at corner k (corners in the parent's order), and [3] the centre (mid12, mid02, mid01).
    std::array<LoopRings, 4> children() const;
    /// The 12 points, if the cell is regular or can be made so.
    std::optional<Net12> regular_net() const;
    /// Which corner is smooth and extraordinary while the others are regular, or -1.
    int star_corner() const;
    /// loop_star_size(valence) points, turned so that `corner` comes first.
    std::vector<Vec3d> star_points(int corner) const;
    /// All points; the limit surface over the cell is in their convex hull.
    std::vector<Vec3d> points() const;
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
    const LoopCell& cell() const { return cell_; }
    const LoopNode& child(int quarter) const;
    const LoopRings& rings() const { return *rings_; }  ///< of a generic cell

  private:
    LoopCell cell_;
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
