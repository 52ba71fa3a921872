#include "site_limits.hpp"

#include <oneapi/tbb/parallel_sort.h>

#include <algorithm>
#include <vector>

namespace tetrakis::detail {

void limit_positions(const Hierarchy& points, std::span<const Site> sites, std::span<Vec3d> out,
                     const std::function<void(double)>& report) {
    constexpr std::size_t k_block = 1u << 16;  // many of the blocks that are evaluated together
    for (std::size_t begin = 0; begin < sites.size(); begin += k_block) {
        report(static_cast<double>(begin) / static_cast<double>(sites.size()));
        const std::size_t size = std::min(k_block, sites.size() - begin);
        points.limit_positions(sites.subspan(begin, size), out.subspan(begin, size));
    }
}

void limit_positions_once(const Hierarchy& points, std::span<const Site> sites, std::span<Vec3d> out,
                          const std::function<void(double)>& report) {
    struct Entry {
        Site site;
        std::uint32_t index;
        auto operator<=>(const Entry&) const = default;
    };
    std::vector<Entry> order(sites.size());
    for (std::size_t i = 0; i < sites.size(); ++i) order[i] = {sites[i], static_cast<std::uint32_t>(i)};
    oneapi::tbb::parallel_sort(order.begin(), order.end());
    std::vector<Site> distinct;
    for (const Entry& entry : order)
        if (distinct.empty() || distinct.back() != entry.site) distinct.push_back(entry.site);
    std::vector<Vec3d> positions(distinct.size());
    limit_positions(points, distinct, positions, report);
    std::size_t number = 0;
    for (const Entry& entry : order) {
        number += distinct[number] != entry.site;
        out[entry.index] = positions[number];
    }
}

}  // namespace tetrakis::detail
