// Triangles and time for a tolerance: tetrakis and OpenSubdiv's Bfr on the same models, judged by the same samples of
// the limit surface. Benchmarks are called MODEL/TOLERANCE/METHOD. Their time is from control arrays to indexed
// triangles with normals, without the final measurement. Counters: triangles; and, relative to the tolerance, the
// distances limit_to_mesh and mesh_to_limit and the certified error.
//   bench_tolerance [--samples=N] [--benchmark_filter='rook/0.001/.*'] [--benchmark_format=json] ...
#include "../../eval/tessellate/tessellate.hpp"
#include "bench_models.hpp"
#include "limit_judge.hpp"
#include "peers/peer_osd.hpp"

#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include <algorithm>
#include <any>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <string_view>

namespace tetrakis::bench {

namespace {

std::uint64_t judge_samples = 200'000;

constexpr std::uint64_t k_most_triangles = 5'000'000;
constexpr double k_greatest_factor = 256;
constexpr double k_factor_precision = 1.01;

/// Points and triangles of a peer's mesh for the judge.
std::pair<std::vector<Vec3d>, std::vector<std::array<std::uint32_t, 3>>> in_double(const PeerMesh& mesh) {
    std::pair<std::vector<Vec3d>, std::vector<std::array<std::uint32_t, 3>>> result;
    for (const auto& p : mesh.positions) result.first.emplace_back(p[0], p[1], p[2]);
    for (const auto& t : mesh.triangles)
        result.second.push_back(
            {static_cast<std::uint32_t>(t[0]), static_cast<std::uint32_t>(t[1]), static_cast<std::uint32_t>(t[2])});
    return result;
}

bool meets(const PeerMesh& mesh, const LimitJudge& judge, double absolute) {
    auto [points, triangles] = in_double(mesh);
    const NearestTriangle nearest(std::move(points), std::move(triangles));
    return judge.limit_to_mesh(nearest, absolute) <= absolute;
}

/// Levels with the lowest smooth level at which the error of Bfr's own surface is below a quarter of the tolerance.
BfrLevels levels_for(const ControlMeshData& data, SchemeKind scheme, const LimitJudge& judge, double tolerance) {
    for (int smooth = 2; smooth < 10; ++smooth)
        if (judge.own_error(data, scheme, BfrLevels::of(smooth)) < tolerance / 4) return BfrLevels::of(smooth);
    return k_judge_levels;
}

/// Makes a peer's mesh with normals. Refers to the control mesh's data. Empty if the tolerance needs more than 5
/// million triangles.
using PeerWork = std::function<PeerMesh()>;

/// Uses the lowest of the rates 1, 2, 3, 4, 6, 8, 12, 16, 24, 32 that meets the tolerance.
/// @param tolerance  from limit to mesh, relative to the limit's diagonal
PeerWork best_uniform_rate(const ControlMeshData& data, SchemeKind scheme, const LimitJudge& judge, double tolerance) {
    const double absolute = tolerance * judge.diagonal();
    const PeerOptions options{scheme, levels_for(data, scheme, judge, absolute)};
    for (const int rate : {1, 2, 3, 4, 6, 8, 12, 16, 24, 32}) {
        const PeerMesh mesh = bfr_uniform(data, options, rate);
        if (mesh.triangles.size() > k_most_triangles) break;
        if (meets(mesh, judge, absolute)) return [&data, options, rate] { return bfr_uniform(data, options, rate); };
    }
    return {};
}

/// Uses rates for each edge, with the least factor k (to one per cent) that meets the tolerance.
PeerWork best_adaptive_rates(const ControlMeshData& data, SchemeKind scheme, const LimitJudge& judge,
                             double tolerance) {
    const double absolute = tolerance * judge.diagonal();
    const PeerOptions options{scheme, levels_for(data, scheme, judge, absolute)};
    double low = 0, high = 0.25;  // factors that do not meet, and meet, the tolerance
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

/// The judge's measurements of a mesh; errors are relative to the tolerance.
struct Judged {
    std::uint64_t triangles = 0;
    double forward = 0, backward = 0, certified = 0;
    double measured() const { return std::max(forward, backward); }
};

/// The work that is timed, and its judged result. `run` is empty if the tolerance cannot be met.
struct Work {
    std::function<std::any()> run;
    Judged judged;
};

/// A model at one tolerance.
class Task {
  public:
    Task(const BenchModel& model, double tolerance)
        : data_(load_bench_model(model)),
          scheme_(model.scheme),
          tolerance_(tolerance),
          judge_(data_, scheme_, judge_samples) {}

    /// @param share  the requested tolerance, relative to the tolerance of the task
    Work own(EstimatorKind estimator, int threads, double share = 1) const {
        TessellateOptions options;
        options.scheme = scheme_;
        options.estimator = estimator;
        options.tolerance = share * absolute();
        options.tolerance_is_absolute = true;
        options.uvs = false;  // the peers make none
        RunContext context;
        context.threads = threads;
        const auto run = [this, options, context] {
            return tessellate(ControlMesh::build(data_, context), options, context);
        };
        const Tessellation result = run();
        Judged judged = judge(result.mesh.positions, result.mesh.triangles);
        judged.certified = result.certified_error.value_or(0) / absolute();
        return {[run] { return std::any(run()); }, judged};
    }

    /// The result with the fewest triangles whose judged error, in both directions, is within the tolerance. The
    /// requested tolerance is scaled at most `k_tries` times.
    Work at_equal_error(EstimatorKind estimator) const {
        constexpr int k_tries = 8;
        constexpr double k_close_enough = 0.98, k_largest_step = 2.5, k_least_step = 0.95;
        Work best;
        double low = 0, high = 0, asked = 1;  // requested tolerances: met, not met, next
        for (int i = 0; i <= k_tries; ++i) {
            Work tried = own(estimator, 1, asked);
            const double error = tried.judged.measured();
            (error <= 1 ? low : high) = asked;
            if (error <= 1 && (!best.run || tried.judged.triangles <= best.judged.triangles)) best = std::move(tried);
            if (error <= 1 && error >= k_close_enough) break;
            if (low > 0 && high > 0)
                asked = std::sqrt(low * high);
            else if (error > 1)
                asked *= std::clamp(0.995 / error, 1 / k_largest_step, k_least_step);
            else
                asked *= std::min(0.995 / std::max(error, 1e-300), k_largest_step);
        }
        return best;
    }

    template <class Search>
    Work peer(Search search) const {
        const PeerWork work = search(data_, scheme_, judge_, tolerance_);
        if (!work) return {};
        const auto [points, triangles] = in_double(work());
        return {[work] { return std::any(work()); }, judge(points, triangles)};
    }

  private:
    double absolute() const { return tolerance_ * judge_.diagonal(); }
    Judged judge(const std::vector<Vec3d>& points, const std::vector<std::array<std::uint32_t, 3>>& triangles) const {
        return {triangles.size(), judge_.limit_to_mesh(NearestTriangle(points, triangles)) / absolute(),
                judge_.mesh_to_limit(points, triangles, judge_samples) / absolute()};
    }

    ControlMeshData data_;
    SchemeKind scheme_;
    double tolerance_;
    LimitJudge judge_;
};

using Method = Work (*)(const Task&);
constexpr std::pair<const char*, Method> k_methods[] = {
    {"measured", [](const Task& t) { return t.own(EstimatorKind::measured, 1); }},
    {"measured_2t", [](const Task& t) { return t.own(EstimatorKind::measured, 2); }},
    {"measured_equal", [](const Task& t) { return t.at_equal_error(EstimatorKind::measured); }},
    {"certified", [](const Task& t) { return t.own(EstimatorKind::certified, 1); }},
    {"certified_2t", [](const Task& t) { return t.own(EstimatorKind::certified, 2); }},
    {"certified_equal", [](const Task& t) { return t.at_equal_error(EstimatorKind::certified); }},
    {"bfr_rate", [](const Task& t) { return t.peer(best_uniform_rate); }},
    {"bfr_rates_per_edge", [](const Task& t) { return t.peer(best_adaptive_rates); }},
};

void run(benchmark::State& state, const BenchModel& model, double tolerance, const std::string& name, Method method) {
    // Repetitions share the prepared tasks and judged results.
    static std::map<std::pair<std::string_view, double>, Task> tasks;
    static std::map<std::string, Work> works;
    const Task& task = tasks.try_emplace({model.name, tolerance}, model, tolerance).first->second;
    auto found = works.find(name);
    if (found == works.end()) found = works.emplace(name, method(task)).first;
    const Work& work = found->second;
    if (!work.run) {
        state.SkipWithError("the tolerance is not met");
        return;
    }
    for (auto _ : state) {
        std::any result = work.run();
        state.PauseTiming();
        result.reset();
        state.ResumeTiming();
    }
    state.counters["triangles"] = static_cast<double>(work.judged.triangles);
    state.counters["limit_to_mesh"] = work.judged.forward;
    state.counters["mesh_to_limit"] = work.judged.backward;
    state.counters["certified"] = work.judged.certified;
}

}  // namespace

}  // namespace tetrakis::bench

int main(int argc, char** argv) {
    using namespace tetrakis::bench;
    benchmark::Initialize(&argc, argv);
    for (int i = 1; i < argc; ++i)
        if (std::sscanf(argv[i], "--samples=%lu", &judge_samples) != 1) {
            fmt::print(stderr, "{} is no option\n", argv[i]);
            return 2;
        }
    if (!std::filesystem::is_directory(shared_folder())) {
        fmt::print(stderr, "The shared test data are not here (TETRAKIS_SHARED_DIR): nothing to do.\n");
        return 0;
    }
    for (const BenchModel& model : k_models)
        for (const double tolerance : {1e-2, 1e-3, 1e-4})
            for (const auto& [method_name, method] : k_methods) {
                const std::string name = fmt::format("{}/{:g}/{}", model.name, tolerance, method_name);
                benchmark::RegisterBenchmark(name.c_str(),
                                             [&model, tolerance, name, method = method](benchmark::State& state) {
                                                 run(state, model, tolerance, name, method);
                                             })
                    ->Unit(benchmark::kMillisecond)
                    ->UseRealTime();
            }
    benchmark::RunSpecifiedBenchmarks();
    benchmark::Shutdown();
    return 0;
}
