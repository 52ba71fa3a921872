#include "ring_rows.hpp"

#include <algorithm>
#include <array>
#include <map>

namespace tetrakis::detail {

namespace {

// Vertices of so many edges, groups of so many points and rows of so many terms are worth it.
constexpr int k_many = 24;
// But rounding, of weights near one that are summed.
constexpr double k_rounding = 1e-16;

}  // namespace

PointGroups::PointGroups(const RuleMesh& mesh) : of(mesh.vertex_count(), -1) {
    std::vector<int> edges(mesh.vertex_count(), 0);
    for (int e = 0; e < mesh.edge_count(); ++e) {
        const int h = mesh.edge_halfedge(e);
        ++edges[mesh.origin(h)];
        ++edges[mesh.target(h)];
    }
    const auto middle = std::max_element(edges.begin(), edges.end());
    if (middle == edges.end() || *middle < k_many) return;
    std::vector<int> distance(mesh.vertex_count(), -1), front{static_cast<int>(middle - edges.begin())};
    distance[front[0]] = 0;
    std::map<std::array<int, 4>, std::vector<int>> places;
    for (std::size_t i = 0; i < front.size(); ++i) {
        for (const int w : mesh.ring(front[i]).neighbour) {
            if (distance[w] >= 0) continue;
            distance[w] = distance[front[i]] + 1;
            front.push_back(w);
        }
    }
    for (const int v : front) {
        std::array<int, 4> place{distance[v], 0, 0, 0};
        for (const int w : mesh.ring(v).neighbour) ++place[static_cast<std::size_t>(2 + distance[w] - distance[v])];
        places[place].push_back(v);
    }
    for (auto& [place, points] : places) {
        if (points.size() < k_many) continue;
        for (const int v : points) of[v] = static_cast<int>(members.size());
        members.push_back(std::move(points));
    }
}

void RingRow::add_to(const PointGroups& groups, double factor, std::span<double> all) const {
    for (std::size_t g = 0; g < level.size(); ++g)
        for (const int i : groups.members[g]) all[i] += factor * level[g];
    for (const auto& [point, weight] : more) all[point] += factor * weight;
}

/// What most of a group have more becomes its weight.
void RingRowSum::level_out() {
    met_.assign(groups_.members.size(), 0);
    for (const int i : touched_)
        if (const int g = groups_.of[i]; g >= 0) ++met_[g];
    for (std::size_t g = 0; g < met_.size(); ++g) {
        const std::vector<int>& members = groups_.members[g];
        if (2 * met_[g] <= members.size()) continue;
        sorted_.clear();
        for (const int i : members) sorted_.push_back(value_[i]);
        const auto half = sorted_.begin() + static_cast<std::ptrdiff_t>(sorted_.size() / 2);
        std::nth_element(sorted_.begin(), half, sorted_.end());
        const double most = *half;
        const auto others = [&](double than) {
            return std::count_if(sorted_.begin(), sorted_.end(),
                                 [&](double x) { return std::abs(x - than) > k_rounding; });
        };
        if (2 * others(most) > others(0)) continue;
        sum_.level[g] += most;
        for (const int i : members) add(i, -most);
    }
}

const RingRow& RingRowSum::take() {
    level_out();
    taken_.level = sum_.level;
    std::fill(sum_.level.begin(), sum_.level.end(), 0.0);
    taken_.more.clear();
    for (const int i : touched_) {
        if (std::abs(value_[i]) > k_rounding) taken_.more.emplace_back(i, value_[i]);
        value_[i] = 0;
        seen_[i] = 0;
    }
    touched_.clear();
    return taken_;
}

std::vector<RingRow> compose(const PointGroups& groups, std::span<const RingRow> coarse, const StencilTable& fine,
                             std::span<const int> rows) {
    std::vector<RingRow> result;
    RingRowSum sum(groups);
    for (const int r : rows) {
        for (std::size_t t = 0; t < fine.points(r).size(); ++t)
            sum.add(coarse[static_cast<std::size_t>(fine.points(r)[t])], fine.weights(r)[t]);
        result.push_back(sum.take());
    }
    return result;
}

}  // namespace tetrakis::detail
