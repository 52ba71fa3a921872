#include "peer_search.hpp"

#include <algorithm>
#include <cmath>

namespace tetrakis::bench {

namespace {

constexpr std::uint64_t k_most_triangles = 5'000'000;
constexpr double k_greatest_factor = 256;
constexpr double k_factor_precision = 1.01;

bool meets(const PeerMesh& mesh, const LimitJudge& judge, double absolute) {
    auto [points, triangles] = in_double(mesh);
    const NearestTriangle nearest(std::move(points), std::move(triangles));
    return judge.limit_to_mesh(nearest, absolute) <= absolute;
}

/// The smallest smooth level at which Bfr's own surface is off by less than a quarter of the tolerance.
BfrLevels levels_for(const ControlMeshData& data, SchemeKind scheme, double tolerance) {
    for (int smooth = 2; smooth < 10; ++smooth)
        if (bfr_own_error(data, scheme, BfrLevels::of(smooth)) < tolerance / 4) return BfrLevels::of(smooth);
    return k_judge_levels;
}

}  // namespace

std::pair<std::vector<Vec3d>, std::vector<std::array<std::uint32_t, 3>>> in_double(const PeerMesh& mesh) {
    std::pair<std::vector<Vec3d>, std::vector<std::array<std::uint32_t, 3>>> result;
    for (const auto& p : mesh.positions) result.first.emplace_back(p[0], p[1], p[2]);
    for (const auto& t : mesh.triangles)
        result.second.push_back(
            {static_cast<std::uint32_t>(t[0]), static_cast<std::uint32_t>(t[1]), static_cast<std::uint32_t>(t[2])});
    return result;
}

PeerWork best_uniform_rate(const ControlMeshData& data, SchemeKind scheme, const LimitJudge& judge, double tolerance) {
    const double absolute = tolerance * judge.diagonal();
    const PeerOptions options{scheme, levels_for(data, scheme, absolute), true};
    for (const int rate : {1, 2, 3, 4, 6, 8, 12, 16, 24, 32}) {
        const PeerMesh mesh = bfr_uniform(data, options, rate);
        if (mesh.triangles.size() > k_most_triangles) break;
        if (meets(mesh, judge, absolute)) return [&data, options, rate] { return bfr_uniform(data, options, rate); };
    }
    return {};
}

PeerWork best_adaptive_rates(const ControlMeshData& data, SchemeKind scheme, const LimitJudge& judge,
                             double tolerance) {
    const double absolute = tolerance * judge.diagonal();
    const PeerOptions options{scheme, levels_for(data, scheme, absolute), true};
    double low = 0, high = 0.25;  // the factor: not met, met
    for (;; low = high, high *= 2) {
        const PeerMesh mesh = bfr_adaptive(data, options, absolute, high);
        if (high > k_greatest_factor || mesh.triangles.size() > k_most_triangles) return {};
        if (meets(mesh, judge, absolute)) break;
    }
    low = std::max(low, high / 4);
    while (high / low > k_factor_precision) {
        const double middle = std::sqrt(low * high);
        (meets(bfr_adaptive(data, options, absolute, middle), judge, absolute) ? high : low) = middle;
    }
    return [&data, options, absolute, high] { return bfr_adaptive(data, options, absolute, high); };
}

}  // namespace tetrakis::bench
