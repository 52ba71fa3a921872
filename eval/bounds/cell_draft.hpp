#pragma once

#include "../../schemes/core/scheme_table.hpp"
#include "cell_surroundings.hpp"
#include "ring_rows.hpp"

#include <array>
#include <cmath>
#include <span>
#include <utility>
#include <vector>

namespace tetrakis::detail {

/// Weights and sums of rounding errors alone.
inline constexpr double k_no_weight = 1e-11;

/// A point as a combination of a cell's corners.
using CellAnchor = std::array<double, 4>;

/// What a few levels of the rules make of a cell with certain surroundings: the points of the small cells that it
/// becomes, as combinations of those around it.
struct CellDraft {
    struct Child {
        SurroundingsKey key;
        std::vector<int> vertices;  ///< of `rows`, as the key numbers them
    };

    int points = 0;                  ///< around the cell, its corners first
    std::vector<CellAnchor> anchor;  ///< where the corners would have each of these
    std::vector<double> direct;      ///< size of each one's basis function, less the hats of the corners
    std::vector<int> active;         ///< those that matter
    PointGroups groups;
    std::vector<RingRow> rows;  ///< of the small cells' vertices
    std::vector<Child> children;

    /// The first corner for all.
    std::vector<CellAnchor> constant() const { return std::vector<CellAnchor>(points, {1, 0, 0, 0}); }
    /// Whether a point may be anywhere else than where the corners would have it.
    bool is_free(int i) const {
        for (int k = 0; k < 4; ++k)
            if (anchor[i][k] != (k == i ? 1.0 : 0.0)) return true;
        return false;
    }
    /// Whether a combination of the points is 0 where all are where the corners would have them.
    bool annihilates(const RingRow& functional) const;
    /// Sums of the anchors of each group, which annihilates() needs.
    std::vector<CellAnchor> group_anchor;
    void set_anchor(std::vector<CellAnchor> to);
};

/// Nothing where the surroundings are no mesh or have more than one extraordinary point.
std::optional<CellDraft> draft_cell(const SchemeInfo& scheme, const RuleOptions& options, const SurroundingsKey& key,
                                    int cell_corners, int rings);

}  // namespace tetrakis::detail
