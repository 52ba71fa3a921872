#include "peer_search.hpp"

#include "stopwatch.hpp"

#include <fmt/format.h>

#include <cmath>
#include <cstdio>
#include <fstream>
#include <sstream>

namespace tetrakis::bench {

namespace {

constexpr int k_runs = 5;
constexpr std::uint64_t k_most_triangles = 5'000'000;
constexpr double k_greatest_factor = 256;
constexpr double k_factor_precision = 1.01;

NearestTriangle nearest_on(const PeerMesh& mesh) {
    auto [points, triangles] = in_double(mesh);
    return {std::move(points), std::move(triangles)};
}

/// The smallest smooth level at which Bfr's own surface is off by less than a quarter of the tolerance.
BfrLevels levels_for(const ControlMeshData& data, SchemeKind scheme, double tolerance) {
    for (int smooth = 2; smooth < 10; ++smooth)
        if (bfr_own_error(data, scheme, BfrLevels::of(smooth)) < tolerance / 4) return BfrLevels::of(smooth);
    return k_judge_levels;
}

template <class Make>
void time_both(PeerResult& result, PeerOptions options, const Make& make) {
    options.normals = false;
    result.ms = median_ms(k_runs, [&] { return make(options); });
    options.normals = true;
    result.ms_normals = median_ms(k_runs, [&] { return make(options); });
}

/// Fills in what is known once the mesh is chosen: final errors and times. `make(options)` builds it.
template <class Make>
void finish(PeerResult& result, const LimitJudge& judge, PeerOptions options, const Make& make) {
    auto [points, triangles] = in_double(make(options));
    result.triangles = triangles.size();
    result.backward = judge.mesh_to_limit(points, triangles) / judge.diagonal();
    const NearestTriangle nearest(std::move(points), std::move(triangles));
    result.error = judge.limit_to_mesh(nearest) / judge.diagonal();
    if (result.met) time_both(result, options, make);
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

PeerResult best_uniform_rate(std::string_view model, const ControlMeshData& data, SchemeKind scheme,
                             const LimitJudge& judge, double tolerance) {
    const double absolute = tolerance * judge.diagonal();
    const PeerOptions options{scheme, levels_for(data, scheme, absolute)};
    PeerResult result{std::string(model), tolerance, "bfr-rate"};
    int last = 1;
    for (const int rate : {1, 2, 3, 4, 6, 8, 12, 16, 24, 32}) {
        const PeerMesh mesh = bfr_uniform(data, options, rate);
        if (mesh.triangles.size() > k_most_triangles) break;
        last = rate;
        result.met = judge.limit_to_mesh(nearest_on(mesh), absolute) <= absolute;
        if (result.met) break;
    }
    finish(result, judge, options, [&](const PeerOptions& o) { return bfr_uniform(data, o, last); });
    result.parameter = fmt::format("R={} s={}", last, options.levels.smooth);
    return result;
}

PeerResult best_adaptive_rates(std::string_view model, const ControlMeshData& data, SchemeKind scheme,
                               const LimitJudge& judge, double tolerance) {
    const double absolute = tolerance * judge.diagonal();
    const PeerOptions options{scheme, levels_for(data, scheme, absolute)};
    PeerResult result{std::string(model), tolerance, "bfr-adapt"};
    const auto meets = [&](double k) {
        const PeerMesh mesh = bfr_adaptive(data, options, absolute, k);
        return mesh.triangles.size() <= k_most_triangles && judge.limit_to_mesh(nearest_on(mesh), absolute) <= absolute;
    };
    double low = 0, high = 0.25;
    while (high <= k_greatest_factor && !meets(high)) {
        low = high;
        high *= 2;
        // Past the limit of triangles a larger factor cannot help.
        if (bfr_adaptive(data, options, absolute, low).triangles.size() > k_most_triangles)
            high = 2 * k_greatest_factor;
    }
    result.met = high <= k_greatest_factor;
    if (!result.met) {
        result.parameter = fmt::format("k=none s={}", options.levels.smooth);
        return result;
    }
    low = std::max(low, high / 4);
    while (high / low > k_factor_precision) {
        const double middle = std::sqrt(low * high);
        (meets(middle) ? high : low) = middle;
    }
    finish(result, judge, options, [&](const PeerOptions& o) { return bfr_adaptive(data, o, absolute, high); });
    result.parameter = fmt::format("k={:.6g} s={}", high, options.levels.smooth);
    return result;
}

std::function<PeerMesh()> peer_work(const PeerResult& result, const ControlMeshData& data, SchemeKind scheme,
                                    const LimitJudge& judge) {
    double value = 0;
    int smooth = 0;
    if (!result.met || std::sscanf(result.parameter.c_str(), "%*c=%lf s=%d", &value, &smooth) != 2) return {};
    PeerOptions options{scheme, BfrLevels::of(smooth)};
    options.normals = true;
    const double absolute = result.tolerance * judge.diagonal();
    if (result.method == "bfr-rate")
        return [&data, options, value] { return bfr_uniform(data, options, static_cast<int>(value)); };
    return [&data, options, value, absolute] { return bfr_adaptive(data, options, absolute, value); };
}

PeerResults::PeerResults(std::filesystem::path file) : file_(std::move(file)) {
    std::ifstream in(file_);
    for (std::string line; std::getline(in, line);) {
        std::istringstream words(line);
        PeerResult r;
        if (!(words >> r.model >> r.tolerance >> r.method >> r.triangles >> r.ms >> r.ms_normals >> r.error >>
              r.backward >> r.met))
            continue;
        std::getline(words >> std::ws, r.parameter);
        results_.push_back(r);
    }
}

const PeerResult* PeerResults::find(std::string_view model, double tolerance, std::string_view method) const {
    for (const PeerResult& r : results_)
        if (r.model == model && r.method == method && std::abs(r.tolerance / tolerance - 1) < 1e-9) return &r;
    return nullptr;
}

void PeerResults::add(const PeerResult& r) {
    results_.push_back(r);
    if (file_.empty()) return;
    const bool fresh = !std::filesystem::exists(file_);
    std::ofstream out(file_, std::ios::app);
    if (fresh) out << "# model tolerance method triangles ms ms_with_normals error backward_error met parameter\n";
    out << fmt::format("{} {:g} {} {} {:.4g} {:.4g} {:.4g} {:.4g} {:d} {}\n", r.model, r.tolerance, r.method,
                       r.triangles, r.ms, r.ms_normals, r.error, r.backward, r.met, r.parameter);
}

}  // namespace tetrakis::bench
