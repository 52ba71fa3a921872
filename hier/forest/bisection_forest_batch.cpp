#include "bisection_forest.hpp"

#include "../base/memory.hpp"

#include <algorithm>
#include <cassert>
#include <utility>

namespace tetrakis {

namespace {

// Values of BisectionLeaf::mark during refine() and coarsen().
constexpr std::uint8_t k_waits = 1;        // the leaf is to be split (or merged); each split adds one
constexpr std::uint8_t k_split_twice = 3;  // the leaf has been split, and so has its child 0

}  // namespace

// Lists and marks the leaves that refine() splits: the marked ones, then the leaves across bases that have to be split
// with or before them. Returns the numbers of leaves and midpoints that all these splits add.
BisectionForest::SplitCost BisectionForest::mark_closure(std::span<const LeafId> marked, std::vector<LeafId>& list) {
    const auto add = [&](LeafId id) {
        if (std::exchange(leaves_[id.value].mark, k_waits) == 0) list.push_back(id);
    };
    for (const LeafId leaf : marked) {
        require_splittable(leaf);
        add(leaf);
    }
    SplitCost cost;
    for (std::size_t i = 0; i < list.size(); ++i) {
        const LeafId id = list[i], across = leaves_[id.value].neighbour[0];
        if (across.valid()) add(across);
        // A diamond of two leaves of the list is counted once.
        if (across.valid() && depth(across) == depth(id) && across < id) continue;
        cost.leaves += across.valid() ? 2 : 1;
        ++cost.midpoints;
    }
    return cost;
}

void BisectionForest::refine(std::span<const LeafId> marked, std::vector<LeafId>& created) {
    std::size_t split_count = 0;
    SplitCost cost;
    try {
        created.clear();
        detail::reserve_large(created, marked.size());
        cost = mark_closure(marked, created);
        split_count = created.size();
        reserve(leaf_count_ + cost.leaves, midpoint_count_ + cost.midpoints);
        detail::resize_large(created, split_count + cost.leaves);
    } catch (...) {
        for (BisectionLeaf& leaf : leaves_) leaf.mark = 0;
        throw;
    }
    const std::span list = std::span(created).first(split_count);
    // Child 0 has the mark of its parent.
    const auto count_splits = [&](const Diamond& diamond) {
        for (const auto& [child0, child1] : diamond.siblings())
            if (std::uint8_t& mark = leaves_[child0.value].mark; mark != 0) ++mark;
    };
    for (std::size_t i = 0; i < split_count; ++i) {
        if (leaves_[list[i].value].mark == k_waits) split_from_base(list[i], count_splits);
    }
    // Replaces each leaf of the list by its two to four descendants, from the end, so that no leaf is overwritten
    // before it is read. The loop has no branches, because nothing predicts which child was split as well.
    std::size_t end = created.size();
    for (std::size_t i = split_count; i-- > 0;) {
        const LeafId slot = list[i];
        BisectionLeaf& first = leaves_[slot.value];
        const bool twice = first.mark == k_split_twice;
        first.mark = 0;
        // Child 1, or its child 1: the leaf across the edge from the apex to the midpoint.
        const LeafId last = first.neighbour[twice ? 0 : 2];
        created[end - 1] = last;
        created[end - 2] = leaves_[last.value].neighbour[1];
        end -= depth(last) > first.depth - twice ? 2 : 1;
        created[end - 1] = first.neighbour[2];
        end -= twice ? 2 : 1;
        created[end] = slot;
    }
}

std::size_t BisectionForest::coarsen(std::span<const LeafId> marked, std::vector<LeafId>& created) {
    created.clear();
    detail::reserve_large(created, marked.size() / 2);
    for (const LeafId leaf : marked) {
        assert(is_leaf(leaf));
        leaves_[leaf.value].mark = k_waits;
    }
    const std::uint32_t before = midpoint_count_;
    for (std::size_t i = marked.size(); i-- > 0;) {
        BisectionLeaf& leaf = leaves_[marked[i].value];
        if (leaf.mark == 0) continue;
        const Diamond diamond = find_diamond(marked[i]);
        bool all = diamond.pair_count > 0;
        for (const auto& [child0, child1] : diamond.siblings())
            all = all && leaves_[child0.value].mark != 0 && leaves_[child1.value].mark != 0;
        // With this mark cleared, the other leaves of the diamond are not merged, either.
        leaf.mark = 0;
        if (!all) continue;
        fold_diamond(diamond);
        free_folded(diamond);
        for (std::uint32_t p = diamond.pair_count; p-- > 0;) created.push_back(diamond.pairs[p][0]);
    }
    std::reverse(created.begin(), created.end());
    return before - midpoint_count_;
}

}  // namespace tetrakis
