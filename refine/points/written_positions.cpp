#include "written_positions.hpp"

#include <array>
#include <vector>

namespace tetrakis {

void written_positions(const LevelSource& source, std::span<const Site> sites, std::span<Vec3d> out) {
    std::array<std::vector<std::uint32_t>, k_max_level + 1> by_level;
    for (std::uint32_t i = 0; i < sites.size(); ++i) by_level[sites[i].level].push_back(i);
    std::vector<Site> some;
    std::vector<Vec3d> found;
    for (std::size_t level = 0; level < by_level.size(); ++level) {
        some.clear();
        for (const std::uint32_t i : by_level[level]) some.push_back(sites[i]);
        found.resize(some.size());
        if (!some.empty()) source.positions(some, static_cast<int>(level) + 1, found);
        for (std::size_t k = 0; k < some.size(); ++k) out[by_level[level][k]] = found[k];
    }
}

}  // namespace tetrakis
