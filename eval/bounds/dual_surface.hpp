#pragma once

#include "../../hier/forest/vertex_forest.hpp"
#include "../../refine/adaptive/partial_levels.hpp"
#include "dual_corners.hpp"
#include "dual_patch.hpp"
#include "short_polygon.hpp"

#include <array>
#include <functional>
#include <span>
#include <utility>
#include <vector>

namespace tetrakis::detail {

/// The limit surface of a quadratic dual scheme (Doo-Sabin, midedge): polynomials over each cell around which the net
/// is regular. Those that are not touch a point of DualCorners; they are cut in four, again and again,
/// of which three are regular each time, and what is left at the point lies in the convex hull of the control points
/// around it, because no mask has a negative weight.
///
/// Polynomials are found when first needed, in large batches, from limit points, and kept.
class DualSurface {
  public:
    /// Leaves below this level are too small to be looked at.
    static constexpr int k_deepest_leaf = 28;

    /// Keeps references to points and roots.
    DualSurface(const PartialLevels& points, const VertexRoots& roots, DualPieces pieces);

    const DualCorners& corners() const { return corners_; }
    const DualAxes& axes(std::uint32_t root) const { return axes_[root]; }

    /// What to know around a point: the polynomials of the cells at levels from..to that were cut off there, and of
    /// the last level the control points.
    struct Need {
        std::uint32_t point;
        int from, to;
    };
    /// Of leaves that touch no point.
    void find(const VertexForest& forest, std::span<const LeafId> leaves, const std::function<void(double)>& report);
    /// Each point once.
    void find(std::span<const Need> needs, const std::function<void(double)>& report);
    /// Forgets the leaves of slots from this number on: a forest is taken back to an earlier state.
    void forget_from(std::uint32_t slot);

    /// Of the last need.
    std::span<const Vec3d> hull(std::uint32_t point) const { return hulls_[point]; }
    /// Goes over the polynomials of a leaf's cell within a polygon (or segment) in its root's coordinates.
    /// @param on_part   (part): one polynomial's
    /// @param on_point  (point): the rest touches the point
    template <class OnPart, class OnPoint>
    void visit(LeafId leaf, const VertexCell& cell, const ShortPolygon& shape, OnPart&& on_part,
               OnPoint&& on_point) const {
        if (corners_.corner_of(cell) < 0)
            patches_[leaf.value].for_each_part(axes_[cell.root], cell, shape, on_part);
        else
            visit_parts(cell, shape, on_part, on_point);
    }

  private:
    /// What was cut off at a corner of a root: three cells a level, by the number of the child.
    struct Chain {
        int first = 1;
        std::vector<std::array<DualPatch, 4>> levels;
    };

    DualFrame frame(std::uint32_t root) const {
        return corners_.corner_of({root, {0, 0}, 0}) < 0 ? DualFrame::root : DualFrame::cell;
    }
    std::size_t chain_at(std::uint32_t root, int corner) const {
        return 4 * std::size_t{root} + static_cast<std::size_t>(corner);
    }
    static VertexCell child_of(const VertexCell& cell, int child) {
        return {cell.root,
                {2 * cell.at.x + (child == 1 || child == 2 ? 1u : 0u), 2 * cell.at.y + (child >= 2 ? 1u : 0u)},
                static_cast<std::uint8_t>(cell.level + 1)};
    }
    template <class OnPart, class OnPoint>
    void visit_parts(const VertexCell& cell, const ShortPolygon& shape, OnPart& on_part, OnPoint& on_point) const;
    void find_patches(std::span<const VertexCell> cells, std::span<DualPatch* const> patches,
                      const std::function<void(double)>& report) const;

    const PartialLevels& points_;
    DualPieces pieces_;
    DualCorners corners_;
    std::vector<DualAxes> axes_;           // per root
    std::vector<std::uint8_t> known_;      // per slot
    std::vector<DualPatch> patches_;       // per slot
    std::vector<std::uint32_t> chain_of_;  // per corner of a root
    std::vector<Chain> chains_;
    std::vector<std::vector<Vec3d>> hulls_;  // per point
};

template <class OnPart, class OnPoint>
void DualSurface::visit_parts(const VertexCell& cell, const ShortPolygon& shape, OnPart& on_part,
                              OnPoint& on_point) const {
    const int corner = corners_.corner_of(cell);
    const Chain& chain = chains_[chain_of_[chain_at(cell.root, corner)]];
    const int level = cell.level + 1;
    if (level >= chain.first + static_cast<int>(chain.levels.size()))
        return on_point(corners_.point(cell.root, corner));
    const auto& cut_off = chain.levels[static_cast<std::size_t>(level - chain.first)];
    for (int k = 0; k < 4; ++k) {
        const VertexCell child = child_of(cell, k);
        const DualBox box = box_of(axes_[cell.root], child);
        const ShortPolygon part = shape.within(box.low, box.high);
        if (part.is_nothing_beside(box.high - box.low)) continue;
        if (corners_.corner_of(child) < 0)
            cut_off[static_cast<std::size_t>(k)].for_each_part(axes_[cell.root], child, part, on_part);
        else
            visit_parts(child, part, on_part, on_point);
    }
}

}  // namespace tetrakis::detail
