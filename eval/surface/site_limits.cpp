#include "site_limits.hpp"

#include "../../hier/base/parallel.hpp"

#include <oneapi/tbb/parallel_sort.h>

#include <algorithm>

namespace tetrakis::detail {

DistinctSites::DistinctSites(std::span<const Site> sites) : number_(sites.size()) {
    struct Entry {
        Site site;
        std::uint32_t index;
        auto operator<=>(const Entry&) const = default;
    };
    std::vector<Entry> order(sites.size());
    for (std::size_t i = 0; i < sites.size(); ++i) order[i] = {sites[i], static_cast<std::uint32_t>(i)};
    oneapi::tbb::parallel_sort(order.begin(), order.end());
    for (const Entry& entry : order) {
        if (distinct_.empty() || distinct_.back() != entry.site) distinct_.push_back(entry.site);
        number_[entry.index] = static_cast<std::uint32_t>(distinct_.size() - 1);
    }
}

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
    const DistinctSites once(sites);
    std::vector<Vec3d> positions(once.distinct().size());
    limit_positions(points, once.distinct(), positions, report);
    for_each_index(static_cast<std::uint32_t>(sites.size()),
                   [&](std::uint32_t i) { out[i] = positions[once.number()[i]]; });
}

}  // namespace tetrakis::detail
