#include "limit_estimator.hpp"

#include "../../hier/base/parallel.hpp"
#include "../surface/site_limits.hpp"

#include <algorithm>

namespace tetrakis {

using detail::k_limit_lattice;
using detail::k_limit_lattice_bits;
using detail::lattice_index;
using detail::LimitSamples;

namespace {

constexpr std::uint32_t k_grain = 64;
constexpr int k_middles = 6;  ///< points of the lattice with two intervals a side

/// Visits the points of the finer lattice that the coarser one does not have.
template <class Visit>
void for_each_finer_point(Visit&& visit) {
    for (int row = 0; row <= k_limit_lattice; ++row)
        for (int i = 0; i <= row; ++i)
            if (row % 2 != 0 || i % 2 != 0) visit(row, i);
}

constexpr int k_finer = detail::k_limit_samples - k_middles;

void say_nothing(double) {}

}  // namespace

template <class Family>
double LimitEstimator<Family>::of_middles(const CellTriangle& triangle, const std::array<Vec3d, 6>& s) const {
    const std::array<Vec3d, 3> corner{s[3], s[5], s[0]};
    const detail::PlaneMeasure plane(corner);
    // Of the edge from corner k to the next.
    const std::array<Vec3d, 3> middle{s[4], s[2], s[1]};
    double error = 0;
    for (std::size_t k = 0; k < 3; ++k) {
        const Vec3d &a = corner[k], &b = corner[(k + 1) % 3];
        const double parametric = glm::length(middle[k] - 0.5 * (a + b));
        if (parametric <= error) continue;
        error = std::max(error, std::min(parametric, plane(middle[k])));
        if (is_hard_edge<Family>(points_.mesh(), triangle, k))
            error = std::max(error, detail::segment_distance(middle[k], a, b));
    }
    return error;
}

template <class Family>
double LimitEstimator<Family>::of_samples(const CellTriangle& triangle, const LimitSamples& s) const {
    const std::array<Vec3d, 3> corner = detail::corners_of(s);
    const detail::PlaneMeasure plane(corner);
    std::array<Vec3d, detail::k_limit_samples> place;
    std::array<double, detail::k_limit_samples> parametric;
    std::array<bool, 3> hard;
    for (std::size_t k = 0; k < 3; ++k) hard[k] = is_hard_edge<Family>(points_.mesh(), triangle, k);
    double error = 0, most = 0;
    for (int row = 0; row <= k_limit_lattice; ++row)
        for (int i = 0; i <= row; ++i) {
            const auto at = static_cast<std::size_t>(lattice_index(row, i));
            const int w[3] = {row - i, i, k_limit_lattice - row};
            place[at] = (static_cast<double>(w[0]) * corner[0] + static_cast<double>(w[1]) * corner[1] +
                         static_cast<double>(w[2]) * corner[2]) /
                        static_cast<double>(k_limit_lattice);
            parametric[at] = glm::length(s[at] - place[at]);
            const double distance = std::min(parametric[at], plane(s[at]));
            most = std::max(most, distance);
            error = std::max(error, distance);
            for (std::size_t k = 0; k < 3; ++k)
                if (hard[k] && w[(k + 2) % 3] == 0)
                    error = std::max(error, detail::segment_distance(s[at], corner[k], corner[(k + 1) % 3]));
        }
    if (tolerance_ > 0 && error > tolerance_) return error;
    // Never above the deviation there, so that refining ends it.
    for (std::size_t i = 0; i < s.size(); ++i)
        if (parametric[i] > std::max(error, tolerance_))
            error = std::max(error, std::min(parametric[i], detail::distance_to_samples(place[i], s, most)));
    return error;
}

template <class Family>
void LimitEstimator<Family>::estimate(std::span<const CellTriangle> triangles, std::span<double> errors) const {
    const ControlMesh& mesh = points_.mesh();
    const auto count = static_cast<std::uint32_t>(triangles.size());
    std::vector<Site> sites(std::size_t{k_middles} * count);
    for_each_index(
        count,
        [&](std::uint32_t t) {
            for (int row = 0, k = 0; row <= 2; ++row)
                for (int i = 0; i <= row; ++i, ++k)
                    sites[k_middles * std::size_t{t} + static_cast<std::size_t>(k)] =
                        detail::lattice_site_of<Family>(mesh, triangles[t], 1, row, i);
        },
        k_grain);
    std::vector<Vec3d> coarse(sites.size());
    detail::limit_positions_once(points_, sites, coarse, say_nothing);

    const auto middles = [&](std::uint32_t t) {
        std::array<Vec3d, k_middles> s;
        std::copy_n(coarse.begin() + static_cast<std::ptrdiff_t>(k_middles * std::size_t{t}), k_middles, s.begin());
        return s;
    };
    for_each_index(
        count, [&](std::uint32_t t) { errors[t] = of_middles(triangles[t], middles(t)); }, k_grain);
    std::vector<std::uint32_t> undecided;
    for (std::uint32_t t = 0; t < count; ++t)
        if (tolerance_ <= 0 || errors[t] <= tolerance_) undecided.push_back(t);

    const auto left = static_cast<std::uint32_t>(undecided.size());
    sites.resize(std::size_t{k_finer} * left);
    for_each_index(
        left,
        [&](std::uint32_t u) {
            std::size_t k = k_finer * std::size_t{u};
            for_each_finer_point([&](int row, int i) {
                sites[k++] =
                    detail::lattice_site_of<Family>(mesh, triangles[undecided[u]], k_limit_lattice_bits, row, i);
            });
        },
        k_grain);
    std::vector<Vec3d> fine(sites.size());
    detail::limit_positions_once(points_, sites, fine, say_nothing);
    for_each_index(
        left,
        [&](std::uint32_t u) {
            const std::array<Vec3d, k_middles> known = middles(undecided[u]);
            LimitSamples s;
            for (int row = 0, k = 0; row <= 2; ++row)
                for (int i = 0; i <= row; ++i, ++k)
                    s[static_cast<std::size_t>(lattice_index(2 * row, 2 * i))] = known[static_cast<std::size_t>(k)];
            std::size_t k = k_finer * std::size_t{u};
            for_each_finer_point(
                [&](int row, int i) { s[static_cast<std::size_t>(lattice_index(row, i))] = fine[k++]; });
            errors[undecided[u]] = of_samples(triangles[undecided[u]], s);
        },
        k_grain);
}

template class LimitEstimator<QuadFamily>;
template class LimitEstimator<LoopFamily>;

}  // namespace tetrakis
