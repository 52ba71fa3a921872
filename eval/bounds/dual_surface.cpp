#include "dual_surface.hpp"

#include "../../hier/base/parallel.hpp"
#include "dual_leaf_error.hpp"

#include <algorithm>

namespace tetrakis::detail {

namespace {

constexpr std::size_t k_cells_at_once = 1u << 11;  // 16 limit points each; evaluated between two reports

unsigned outer_sides(const VertexRoots& roots, std::uint32_t root) {
    unsigned outer = roots.crease[root];
    for (std::uint32_t s = 0; s < 4; ++s)
        if (roots.link[4 * std::size_t{root} + s] == VertexRoots::outside) outer |= 1u << s;
    return outer;
}

/// The cell at a corner of a root, or the one that is `x`, `y` cells away from it.
VertexCell cell_at(std::uint32_t root, int corner, int level, std::uint32_t x, std::uint32_t y) {
    const std::uint32_t last = (1u << level) - 1;
    return {root,
            {corner == 1 || corner == 2 ? last - x : x, corner >= 2 ? last - y : y},
            static_cast<std::uint8_t>(level)};
}

}  // namespace

DualSurface::DualSurface(const PartialLevels& points, const VertexRoots& roots, DualPieces pieces)
    : points_(points), pieces_(pieces), corners_(roots), chain_of_(4 * std::size_t{roots.count()}, DualCorners::none) {
    axes_.reserve(roots.count());
    for (std::uint32_t r = 0; r < roots.count(); ++r) axes_.emplace_back(outer_sides(roots, r));
    std::uint32_t count = 0;
    for (const DualCorners::Point& p : corners_.points())
        for (const DualCorners::Member& m : p.around) chain_of_[chain_at(m.root, m.corner)] = count++;
    chains_.resize(count);
    hulls_.resize(corners_.points().size());
}

void DualSurface::find_patches(std::span<const VertexCell> cells, std::span<DualPatch* const> patches,
                               const std::function<void(double)>& report) const {
    std::vector<VertexCell> below;
    std::vector<Vec3d> limits;
    for (std::size_t begin = 0; begin < cells.size(); begin += k_cells_at_once) {
        report(static_cast<double>(begin) / static_cast<double>(cells.size()));
        const auto some = cells.subspan(begin, std::min(k_cells_at_once, cells.size() - begin));
        below.clear();
        for (const VertexCell& cell : some) add_cells_below(cell, DualPatch::k_bits, below);
        limits.resize(below.size());
        points_.positions(below, limits);
        for_each_index(static_cast<std::uint32_t>(some.size()), [&](std::uint32_t i) {
            *patches[begin + i] = DualPatch(pieces_, frame(some[i].root), axes_[some[i].root], some[i],
                                            std::span(limits).subspan(i * DualPatch::k_points, DualPatch::k_points));
        });
    }
}

void DualSurface::find(const VertexForest& forest, std::span<const LeafId> leaves,
                       const std::function<void(double)>& report) {
    known_.resize(forest.leaf_slots(), 0);
    patches_.resize(forest.leaf_slots());
    std::vector<VertexCell> cells;
    std::vector<DualPatch*> patches;
    for (const LeafId leaf : leaves) {
        const VertexCell cell = forest.cell(leaf);
        if (known_[leaf.value] != 0 || cell.level > k_deepest_leaf || corners_.corner_of(cell) >= 0) continue;
        known_[leaf.value] = 1;
        cells.push_back(cell);
        patches.push_back(&patches_[leaf.value]);
    }
    find_patches(cells, patches, report);
}

void DualSurface::find(std::span<const Need> needs, const std::function<void(double)>& report) {
    std::vector<VertexCell> cells, around;
    std::vector<DualPatch*> patches;
    for (const Need& need : needs) {
        for (const DualCorners::Member& m : corners_.points()[need.point].around) {
            Chain& chain = chains_[chain_of_[chain_at(m.root, m.corner)]];
            int have = chain.first + static_cast<int>(chain.levels.size());
            if (need.from < chain.first || need.from >= have) {
                chain.levels.clear();
                have = chain.first = need.from;
            }
            chain.levels.erase(chain.levels.begin(), chain.levels.begin() + (need.from - chain.first));
            chain.first = need.from;
            chain.levels.resize(static_cast<std::size_t>(need.to + 1 - need.from));
            for (int level = have; level <= need.to; ++level) {
                auto& cut_off = chain.levels[static_cast<std::size_t>(level - chain.first)];
                const VertexCell parent = cell_at(m.root, m.corner, level - 1, 0, 0);
                for (int k = 0; k < 4; ++k) {
                    const VertexCell child = child_of(parent, k);
                    if (corners_.corner_of(child) >= 0) continue;
                    cells.push_back(child);
                    patches.push_back(&cut_off[static_cast<std::size_t>(k)]);
                }
            }
            for (const auto& [x, y] : {std::pair{0u, 0u}, {1u, 0u}, {0u, 1u}, {1u, 1u}})
                around.push_back(cell_at(m.root, m.corner, need.to, x, y));
        }
    }
    find_patches(cells, patches, report);
    std::vector<Vec3d> control(around.size());
    if (!around.empty()) points_.control_positions(around, control);
    auto next = control.begin();
    for (const Need& need : needs) {
        const auto count = static_cast<std::ptrdiff_t>(4 * corners_.points()[need.point].around.size());
        hulls_[need.point].assign(next, next + count);
        next += count;
    }
}

void DualSurface::forget_from(std::uint32_t slot) {
    if (known_.size() > slot)
        std::fill(known_.begin() + static_cast<std::ptrdiff_t>(slot), known_.end(), std::uint8_t{0});
}

}  // namespace tetrakis::detail
