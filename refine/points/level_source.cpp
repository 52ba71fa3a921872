#include "level_source.hpp"

#include <vector>

namespace tetrakis {

void LevelSource::normals(std::span<const Site> sites, std::span<Vec3d> out) const {
    std::vector<LimitPoint> points(sites.size());
    limits(sites, points);
    for (std::size_t i = 0; i < points.size(); ++i) out[i] = points[i].normal;
}

}  // namespace tetrakis
