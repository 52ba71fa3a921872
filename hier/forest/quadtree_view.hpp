#pragma once

#include "../base/pod_array.hpp"
#include "bisection_forest.hpp"
#include "corner_cell.hpp"

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace tetrakis {

/// A leaf cell of the restricted vertex quadtree: the lattice square [x, x + 1] x [y, y + 1] of a corner cell's level.
struct QuadtreeCell {
    HalfedgeId root;
    LatticePoint at;
    std::uint8_t level = 0;
    /// The leaves that cover the cell's two halves, which its diagonal through the even corners divides. A leaf of
    /// depth 2 level + 1 is just that half; one of depth 2 level spans a half of this cell and one of its neighbour.
    std::array<LeafId, 2> half;
};

/// The cells that a bisection forest's leaves make up, seen as a quadtree over each corner cell: a cell has its four
/// children exactly where the forest has its centre as a vertex. Neighbouring cells differ by at most one level. A
/// snapshot: later changes of the forest do not show.
class QuadtreeView {
  public:
    /// O(leaves x levels) at most, and less the more evenly they are spread; parallel. The same cells in the same order
    /// for the same set of leaves.
    explicit QuadtreeView(const BisectionForest& forest);

    /// Leaf cells by root, then along the Z-order curve.
    std::span<const QuadtreeCell> cells() const { return {cells_.data(), cells_.size()}; }

    /// Index of the leaf cell that contains the lattice square `at` of a level; none where the leaf cells are finer, or
    /// the root is a hole's. O(log cells).
    std::optional<std::uint32_t> find(HalfedgeId root, int level, LatticePoint at) const;

    struct Neighbours {
        std::uint32_t count = 0;  ///< 0 on the boundary and towards holes, 2 where the neighbours are finer
        std::array<std::uint32_t, 2> cell{};
        const std::uint32_t* begin() const { return cell.data(); }
        const std::uint32_t* end() const { return cell.data() + count; }
    };
    /// The leaf cells across one side. O(log cells).
    Neighbours neighbours(std::uint32_t cell, CellSide side) const;

  private:
    std::optional<std::uint32_t> find_finest(HalfedgeId root, LatticePoint at) const;

    const ControlMesh* mesh_;
    std::vector<std::uint32_t> first_;  // of the root's cells, and one past them
    detail::PodArray<QuadtreeCell> cells_;
};

}  // namespace tetrakis
