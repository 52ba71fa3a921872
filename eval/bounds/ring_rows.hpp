#pragma once

#include "../../schemes/core/rule_mesh.hpp"
#include "../../schemes/core/stencil_table.hpp"

#include <cmath>
#include <span>
#include <utility>
#include <vector>

namespace tetrakis::detail {

/// Points of a mesh with a vertex of many edges, by their places around it: those of one group are the same but for the
/// sector. What comes to a new point over that vertex has mostly the same weight for all of a group.
struct PointGroups {
    std::vector<int> of;                    ///< per point; -1: none, as for all where there is no such vertex
    std::vector<std::vector<int>> members;  ///< of each group

    PointGroups() = default;
    explicit PointGroups(const RuleMesh& mesh);
};

/// A combination of points: a weight for all of a group, and what single points have more.
struct RingRow {
    std::vector<double> level;                 ///< per group
    std::vector<std::pair<int, double>> more;  ///< each point once

    double level_at(const PointGroups& groups, int point) const {
        return groups.of[point] < 0 ? 0 : level[groups.of[point]];
    }
    /// Adds it times a factor to the weights of all points.
    void add_to(const PointGroups& groups, double factor, std::span<double> all) const;
};

/// Sums of rows, with scratch memory.
class RingRowSum {
  public:
    explicit RingRowSum(const PointGroups& groups)
        : groups_(groups), value_(groups.of.size(), 0.0), seen_(groups.of.size(), 0) {
        sum_.level.assign(groups.members.size(), 0.0);
    }
    void add(int point, double weight) {
        if (!std::exchange(seen_[point], 1)) touched_.push_back(point);
        value_[point] += weight;
    }
    void add(const RingRow& row, double factor) {
        for (std::size_t g = 0; g < row.level.size(); ++g) sum_.level[g] += factor * row.level[g];
        for (const auto& [point, weight] : row.more) add(point, factor * weight);
    }
    /// The sum; then there is nothing.
    const RingRow& take();

  private:
    void level_out();

    const PointGroups& groups_;
    std::vector<double> value_, sorted_;
    std::vector<std::size_t> met_;  ///< points of each group
    std::vector<char> seen_;
    std::vector<int> touched_;
    RingRow sum_, taken_;
};

/// The rows of `fine` as combinations of what those of `coarse` are made of.
std::vector<RingRow> compose(const PointGroups& groups, std::span<const RingRow> coarse, const StencilTable& fine,
                             std::span<const int> rows);

}  // namespace tetrakis::detail
