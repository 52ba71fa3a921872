#include "../base/memory.hpp"
#include "../base/radix_sort.hpp"
#include "../base/spread_bits.hpp"
#include "sqrt3_forest.hpp"

#include <algorithm>
#include <cassert>

// The leaves along a curve through the mesh: by a point inside each, in the finest lattice of its control face.
namespace tetrakis {

namespace {

// 3^20: Sqrt3Lattice::max_level() is 37 at most, whose lattice level is 19, and a mean of corners takes one power more.
// It is less than 2^32, so two coordinates together have 64 bits.
constexpr int k_grid_level = 20;
constexpr std::int64_t k_grid = 3'486'784'401;

/// A point inside a leaf and its control face: the middle; of a leaf that lies on both sides of a control edge, one
/// farther from the corner beyond. No two leaves have the same.
Sqrt3Point point_inside(const Sqrt3Cell& cell) {
    std::int64_t scale = 1;
    for (int l = cell.lattice(); l < k_grid_level; ++l) scale *= 3;
    const Sqrt3Point sum = cell.corner[0] + cell.corner[1] + cell.corner[2];
    for (const Sqrt3Point& p : cell.corner)
        if (std::min({p[0], p[1], p[2]}) < 0) return scale * (4 * sum - 3 * p) / 9;
    return scale * sum / 3;
}

}  // namespace

class Sqrt3Forest::CurveWalk {
  public:
    explicit CurveWalk(const Sqrt3Forest& forest) : forest_(forest) {
        detail::reserve_large(marked_, forest.leaf_count());
    }

    std::vector<LeafId> leaves() {
        for (std::uint32_t root = 0; root < forest_.mesh().face_count(); ++root)
            if (forest_.child_[root] != k_dead) visit(root, Sqrt3Lattice::cell(FaceId(root)));
        std::vector<Marked> spare;
        radix_sort(marked_, spare, [](const Marked& m) { return m.along; });
        radix_sort(marked_, spare, [](const Marked& m) { return std::uint64_t{m.root}; });
        assert(std::adjacent_find(marked_.begin(), marked_.end(), [](const Marked& a, const Marked& b) {
                   return a.root == b.root && a.along == b.along;
               }) == marked_.end());
        std::vector<LeafId> result;
        detail::reserve_large(result, marked_.size());
        for (const Marked& m : marked_) result.push_back(m.leaf);
        return result;
    }

  private:
    struct Marked {
        std::uint64_t along;  // the curve in the control face
        std::uint32_t root;
        LeafId leaf;
    };
    static_assert(sizeof(Marked) == 16);

    void visit(std::uint32_t slot, const Sqrt3Cell& cell) {
        if (!forest_.is_split(slot)) return mark(slot, cell);
        for (std::uint32_t side = 0; side < 3; ++side) {
            const std::uint32_t child = forest_.child_over(3 * slot + side);
            if (forest_.child_[child] == k_half)
                mark(child, forest_.lattice().half(cell, side));
            else
                visit(child, forest_.lattice().child(cell, side));
        }
    }
    void mark(std::uint32_t slot, const Sqrt3Cell& cell) {
        const Sqrt3Point p = point_inside(cell);
        assert(p[0] > 0 && p[1] > 0 && p[2] > 0 && p[0] + p[1] + p[2] == k_grid);
        const std::uint64_t along = detail::spread_bits(static_cast<std::uint64_t>(p[0])) |
                                    detail::spread_bits(static_cast<std::uint64_t>(p[1])) << 1;
        marked_.push_back({along, cell.root.value, LeafId(slot)});
    }

    const Sqrt3Forest& forest_;
    std::vector<Marked> marked_;
};

std::vector<LeafId> Sqrt3Forest::leaves_on_curve() const { return CurveWalk(*this).leaves(); }

}  // namespace tetrakis
