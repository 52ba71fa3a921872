#pragma once

#include "../../hier/base/memory.hpp"
#include "bicubic.hpp"
#include "quad_rings.hpp"
#include "quad_star.hpp"

#include <array>
#include <atomic>
#include <memory>

namespace tetrakis {

namespace detail {

struct QuadQuarters;

/// One cell of a patch tree. Regular cells are leaves: one bicubic patch (or a single-crease patch); the others grow
/// four children on demand.
struct QuadNode {
    enum class Kind : std::uint8_t { regular, star, generic };
    Kind kind = Kind::regular;
    std::uint8_t turn = 0;  ///< star: the corner of the cell that is (0, 0) of the star
    std::uint8_t depth = 0;
    SideCrease crease;
    std::atomic<QuadQuarters*> quarters{nullptr};
    std::atomic<std::uint64_t>* bytes = nullptr;  ///< of the tree and its siblings: grows with them
    Net16 net;                       ///< irregular: the limit positions of the corners alone, at (0, 0) to (1, 1)
    const QuadStar* star = nullptr;  ///< its own, or one of its parent's quarters
    std::unique_ptr<QuadStar> own_star;
    std::unique_ptr<QuadRings> rings;  ///< generic

    QuadNode() = default;
    QuadNode(const QuadNode&) = delete;
    QuadNode& operator=(const QuadNode&) = delete;
    ~QuadNode();
    /// The four quarters, index 2 * qy + qx, grown at the first call; every thread would build the same bits.
    const QuadNode* grown() const;
    /// Limit position of corner k: (0, 0), (1, 0), (1, 1), (0, 1).
    Vec3d corner(int k) const;
    /// Forgets what has grown, however deep; nobody else may be reading it.
    void drop_quarters();
    /// Becomes a star cell; the star has its limit and outlives the cell.
    void become(const QuadStar& of, int corner);
    /// The same of a star of its own.
    void adopt(std::unique_ptr<QuadStar> from, int corner);
    /// Becomes a cell with tags.
    void adopt(std::unique_ptr<QuadRings> from);
    /// Bytes of what is its own beside the node, without its quarters.
    std::uint64_t own_bytes() const;
    /// Bytes of what has grown below, too.
    std::uint64_t grown_bytes() const;
};

/// The cell of a whole root.
struct QuadRoot : QuadNode, PoolNew {};

/// What a node grows, in one block; below 4032 bytes, from where oneTBB's allocator gives 5376.
struct QuadQuarters : PoolNew {
    std::array<QuadNode, 4> cell;
    QuadStar star;  ///< of the one quarter that is a star, where the parent is one
};

/// Corner k of a cell.
constexpr int k_corner_x[4] = {0, 1, 1, 0};
constexpr int k_corner_y[4] = {0, 0, 1, 1};

/// Where (x, y), as seen from corner k with x along the side that leaves it counter-clockwise, lies in the cell.
inline std::array<int, 2> from_corner(int k, int x, int y) {
    switch (k) {
        case 0:
            return {x, y};
        case 1:
            return {1 - y, x};
        case 2:
            return {1 - x, 1 - y};
        default:
            return {y, 1 - x};
    }
}

/// Corner k of a cell as a number of its nine points, and the middle of the side from corner k to k + 1.
constexpr int k_corner_point[4] = {0, 2, 8, 6};
constexpr int k_side_point[4] = {1, 5, 7, 3};
constexpr int k_centre_point = 4;

}  // namespace detail

}  // namespace tetrakis
