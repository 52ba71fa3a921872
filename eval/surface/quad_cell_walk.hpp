#pragma once

#include "quad_patches.hpp"

#include <cstdint>
#include <vector>

namespace tetrakis::detail {

/// A cell of the limit surface at any level, as QuadCellWalk reaches it.
struct WalkCell {
    const QuadNode* node = nullptr;  ///< irregular node, or regular node of the tree, or null below it
    const Net16* net = nullptr;      ///< regular cells
    SideCrease crease;
    std::uint64_t x = 0, y = 0;

    bool irregular() const { return net == nullptr; }
    bool smooth() const { return net != nullptr && !crease; }
    /// Limit position at (column / 2, row / 2), i = 3 * row + column.
    const Vec3d& point(int i);
    /// A smooth patch that differs from a regular cell by at most `beyond`: itself, or a crease of finite sharpness
    /// taken as a sharp one.
    struct Patch {
        const Net16* net;
        const CellFacts* facts;
        double beyond;
    };
    Patch patch();
    /// Patch::beyond, without the rest.
    double beyond();
    /// The smooth parts of a cell with a crease, each with its third derivatives by its net's own parameters.
    struct Strips {
        int count = 0;
        std::array<CreaseStrip, 3> strip;
        std::array<ThirdBounds, 3> third;
    };
    const Strips& strips();

  private:
    friend class QuadCellWalk;
    void forget() {
        facts_ = nullptr;
        known_ = 0;
        has_points_ = has_sharp_ = false;
        strips_.count = 0;
    }

    const CellFacts* facts_ = nullptr;  ///< of patch(), complete
    CellFacts own_;
    bool has_points_ = false;  ///< own_ has those of a smooth cell: leaves that are split need no more
    Net16 sharp_;              ///< a crease's patch
    double beyond_ = 0;
    bool has_sharp_ = false;
    Strips strips_;
    std::array<Vec3d, 9> point_;  ///< of a crease
    std::uint16_t known_ = 0;     ///< bit i: point_[i] is there
};

/// Walks down the cells of a root by subdividing nets and keeps the way, so that cells asked for in path order share
/// it. What a cell gives does not depend on the way. One per thread.
class QuadCellWalk {
  public:
    explicit QuadCellWalk(const QuadPatches& patches);

    /// The cell (x, y) of a level; valid until the next call.
    WalkCell& cell(HalfedgeId root, int level, std::uint64_t x, std::uint64_t y);

  private:
    struct RootFacts {
        HalfedgeId root;
        CellFacts facts;
    };
    const CellFacts* root_facts(const QuadNode& node, HalfedgeId root);

    const QuadPatches& patches_;
    HalfedgeId root_;
    std::uint64_t times_forgotten_ = 0;  ///< as the patches had it when the cells were reached
    std::vector<RootFacts> root_facts_;  ///< of roots seen lately: they are asked for again and again
    std::vector<WalkCell> cells_;
    std::vector<Net16> nets_;
    int depth_ = -1;
};

/// Cells below the leaf level that a walk reaches: leaves reach level 30, and cell numbers must fit 64 bits.
constexpr int k_max_refinement = 32;

}  // namespace tetrakis::detail
