#pragma once

#include "quad_patches.hpp"

#include <cstdint>
#include <vector>

namespace tetrakis::detail {

/// A cell of the limit surface at any level, as QuadCellPath reaches it.
struct PathCell {
    const QuadNode* node = nullptr;  ///< irregular node, or regular node of the tree, or null below it
    const Net16* net = nullptr;      ///< regular cells
    SideCrease crease;
    std::uint64_t x = 0, y = 0;

    static PathCell of(const QuadNode& node, std::uint64_t x, std::uint64_t y) {
        const bool regular = node.kind == QuadNode::Kind::regular;
        return {&node, regular ? &node.patch.net : nullptr, regular ? node.patch.crease : SideCrease{}, x, y};
    }
    bool irregular() const { return net == nullptr; }
};

/// Walks down the cells of a root by subdividing nets and keeps the way, so that cells asked for in path order share
/// it. What a cell gives does not depend on the way. One per thread.
class QuadCellPath {
  public:
    explicit QuadCellPath(const QuadPatches& patches);

    /// The cell (x, y) of a level; valid until the next call.
    const PathCell& cell(HalfedgeId root, int level, std::uint64_t x, std::uint64_t y);

  private:
    const QuadPatches& patches_;
    HalfedgeId root_;
    std::uint64_t times_forgotten_ = 0;  ///< as the patches had it when the cells were reached
    std::vector<PathCell> cells_;
    std::vector<Net16> nets_;
    int depth_ = -1;
};

/// Cells below the leaf level that a walk reaches: leaves reach level 30, and cell numbers must fit 64 bits.
constexpr int k_max_refinement = 32;

}  // namespace tetrakis::detail
