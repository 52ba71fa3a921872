#include "edge_slack.hpp"

#include <algorithm>

namespace tetrakis {

namespace {

/// Tangents of the base angles of tents: at most 15 degrees, at least 5.
constexpr double k_most_tent = 0.2679, k_least_tent = 0.0874;

/// Folds of neighbours whose surface bends evenly are about four tolerances over the height of the triangles. With less
/// assumed fewer leaves are needed, but more of them have to be looked at again.
constexpr double k_folds = 3;

}  // namespace

EdgeSlack assumed_slack(const std::array<Vec3d, 3>& corners, double tolerance, const std::array<bool, 3>& soft,
                        double loose) {
    EdgeSlack slack;
    if (!(soft[0] || soft[1] || soft[2])) return slack;
    const std::array<Vec3d, 3> side{corners[1] - corners[0], corners[2] - corners[1], corners[0] - corners[2]};
    const Vec3d cross = glm::cross(side[0], side[1]);
    const double area = glm::length(cross);
    const std::array<double, 3> length{glm::length(side[0]), glm::length(side[1]), glm::length(side[2])};
    const double fold = k_folds * tolerance * std::max({length[0], length[1], length[2]}) / area;
    if (!(fold <= k_largest_fold * (1 + loose))) return slack;
    std::array<double, 3> half;  // tangent of half the angle at corner k: sin a / (1 + cos a)
    for (std::size_t k = 0; k < 3; ++k) {
        const std::size_t before = (k + 2) % 3;
        half[k] = area / (length[k] * length[before] - glm::dot(side[k], side[before]));
    }
    for (std::size_t k = 0; k < 3; ++k) {
        const double tent = std::min({half[k], half[(k + 1) % 3], k_most_tent});
        if (soft[k] && tent >= k_least_tent * (1 - loose)) slack.fold[k] = fold, slack.tent[k] = tent;
    }
    return slack;
}

}  // namespace tetrakis
