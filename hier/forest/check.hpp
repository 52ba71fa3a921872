#pragma once

#include "../base/ids.hpp"

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace tetrakis {

/// Verifies any forest through its public interface. Leaves are counted and listed correctly. Neighbours are leaves,
/// link to each other, and differ by at most one level (bisections: depth); across creases levels are equal. If leaves
/// have points, each point has the site of its corner, neighbours share points, and no point is unused. If moreover no
/// point hangs, there is one leaf across each side. Bisection leaves lack a neighbour only where the surface ends.
/// @return  the first violation, or nothing. O(leaves).
template <class Forest>
std::optional<std::string> check_forest(const Forest& forest) {
    constexpr bool k_points = requires(LeafId leaf) { forest.points(leaf); };
    constexpr bool k_hanging = requires(LeafId leaf) { forest.hanging_points(leaf); };
    constexpr bool k_listed = requires(PointId point) { forest.is_point(point); };
    constexpr bool k_fixed = requires(PointId point) { forest.is_fixed(point); };
    constexpr bool k_creases = requires(LeafId leaf) { forest.across_crease(leaf, 0); };
    constexpr int k_sides = Forest::k_sides;
    const auto fault = [](LeafId leaf, int side, const char* what) {
        return "leaf " + std::to_string(leaf.value) + ", side " + std::to_string(side) + ": " + what;
    };
    const std::vector<LeafId> leaves = forest.ordered_leaves();
    std::uint32_t slots = 0;
    for (std::uint32_t i = 0; i < forest.leaf_slots(); ++i) slots += forest.is_leaf(LeafId(i)) ? 1 : 0;
    if (leaves.size() != forest.leaf_count() || slots != forest.leaf_count()) return "the number of leaves is wrong";
    for (const LeafId leaf : leaves)
        if (!forest.is_leaf(leaf)) return fault(leaf, 0, "is in the tree, but no leaf");
    // Whether some side of the leaf `from` leads to `to` and passes the test `accepted`.
    const auto some_side = [&](LeafId from, LeafId to, auto&& accepted) {
        bool found = false;
        for (int side = 0; side < k_sides; ++side)
            for (const LeafId n : forest.neighbours(from, side)) found |= n == to && accepted(side);
        return found;
    };
    for (const LeafId leaf : leaves)
        for (int side = 0; side < k_sides; ++side) {
            const auto across = forest.neighbours(leaf, side);
            if constexpr (requires { forest.ends_at(leaf, side); })
                if (across[0].valid() == forest.ends_at(leaf, side))
                    return fault(leaf, side, "is open inside the surface, or leads beyond its end");
            for (std::size_t k = 0; k < 2; ++k) {
                const LeafId other = across[k];
                if (!other.valid()) continue;
                if (!forest.is_leaf(other)) return fault(leaf, side, "leads to a slot without leaf");
                const int step = forest.level(other) - forest.level(leaf);
                if (step < -1 || step > 1) return fault(leaf, side, "the levels of neighbours differ by two");
                if ((!k_points || k_hanging) && (step == 1) != across[1].valid())
                    return fault(leaf, side, "has one neighbour of two, or the reverse");
                const bool linked = some_side(other, leaf, [&](int there) {
                    if constexpr (k_points) {
                        const auto mine = forest.points(leaf), its = forest.points(other);
                        auto from = mine[static_cast<std::size_t>(side)],
                             to = mine[static_cast<std::size_t>(side + 1) % k_sides];
                        if constexpr (k_hanging) {
                            if (step < 0) return true;  // checked when the coarser leaf's turn comes
                            if (step > 0) (k == 0 ? to : from) = forest.hanging_points(leaf)[side];
                        }
                        return its[static_cast<std::size_t>(there + 1) % k_sides] == from &&
                               its[static_cast<std::size_t>(there)] == to;
                    } else {
                        return there >= 0;
                    }
                });
                if (!linked) return fault(leaf, side, "is not seen in the same way from the other side");
            }
            if constexpr (k_creases) {
                const LeafId other = forest.across_crease(leaf, side);
                if (!other.valid()) continue;
                bool back = forest.is_leaf(other) && forest.level(other) == forest.level(leaf), seen = false;
                for (int t = 0; t < k_sides && back; ++t) seen |= forest.across_crease(other, t) == leaf;
                if (!seen) return fault(leaf, side, "has no leaf of its level on the other side of a crease");
            }
        }
    if constexpr (k_points) {
        std::vector<std::uint8_t> used(forest.point_slots(), 0);
        for (const LeafId leaf : leaves)
            for (int k = 0; k < k_sides; ++k) {
                const auto p = forest.points(leaf)[static_cast<std::size_t>(k)];
                if (forest.point_site(p) != forest.corner_site(leaf, k))
                    return fault(leaf, k, "begins at a point of another site");
                used[p.value] = 1;
            }
        for (std::uint32_t p = 0; k_listed && p < used.size(); ++p) {
            if constexpr (k_fixed)
                if (forest.is_fixed(PointId(p))) continue;
            if constexpr (k_listed)
                if ((used[p] != 0) != forest.is_point(PointId(p)))
                    return "point " + std::to_string(p) + " is in use and no corner of a leaf, or the reverse";
        }
    }
    return std::nullopt;
}

}  // namespace tetrakis
