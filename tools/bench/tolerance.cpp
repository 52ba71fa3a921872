// Triangles and time to a tolerance: tetrakis and OpenSubdiv's Bfr on the same models, judged by the same samples of
// the limit surface. Prints Markdown.
//   bench_tolerance [--models a,b] [--tolerances 1e-2,1e-3] [--peers FILE] [--samples N] [--runs N]
#include "../../eval/tessellate/tessellate.hpp"
#include "../../hier/base/version.hpp"
#include "bench_models.hpp"
#include "peer_search.hpp"
#include "stopwatch.hpp"

#include <fmt/chrono.h>
#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <any>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <functional>
#include <thread>

using namespace tetrakis;
using namespace tetrakis::bench;

namespace {

/// One tessellation as the judge sees it; errors relative to the limit's diagonal.
struct Judged {
    std::uint64_t triangles = 0;
    double forward = 0, backward = 0, certified = 0;
    bool valid() const { return triangles > 0; }
    double measured() const { return std::max(forward, backward); }
};

/// What is printed of one model at one tolerance.
struct Row {
    std::string model;
    double tolerance = 0;
    PeerResult rate, adapt;
    Judged equal;                ///< internal tolerance scaled until limit to mesh is the tolerance
    Judged measured, certified;  ///< the tolerance as asked for
    /// Milliseconds by round; empty for a peer that does not meet the tolerance.
    std::vector<double> rate_ms, adapt_ms, certified_ms, measured_ms, certified_two_threads_ms, measured_two_threads_ms;
    std::vector<double> certified_twice_ms;  ///< two runs at once, a thread each: what the machine can give

    /// How many times one thread's work two processors do, with two runs that share nothing.
    double machine() const { return 2 * median_ratio(certified_ms, certified_twice_ms); }
};

class Runner {
  public:
    Runner(const BenchModel& model, std::uint64_t samples, int runs)
        : data_(load_bench_model(model)), scheme_(model.scheme), judge_(data_, scheme_, samples), runs_(runs) {}

    const ControlMeshData& data() const { return data_; }
    SchemeKind scheme() const { return scheme_; }
    const LimitJudge& judge() const { return judge_; }

    Judged judged(EstimatorKind estimator, double tolerance) const {
        const Tessellation result = run(estimator, tolerance, 0);
        Judged j;
        j.triangles = result.mesh.triangles.size();
        j.certified = result.certified_error.value_or(0) / judge_.diagonal();
        j.backward = judge_.mesh_to_limit(result.mesh.positions, result.mesh.triangles) / judge_.diagonal();
        const NearestTriangle nearest(result.mesh.positions, result.mesh.triangles);
        j.forward = judge_.limit_to_mesh(nearest) / judge_.diagonal();
        return j;
    }

    /// The fewest triangles whose judged error is within the tolerance, from limit to mesh and back: the tolerance
    /// asked for is scaled at most `k_tries` times.
    Judged at_equal_error(EstimatorKind estimator, double tolerance, const Judged& first) const {
        constexpr int k_tries = 8;
        constexpr double k_close_enough = 0.98, k_largest_step = 2.5;
        Judged best, tried = first;
        double low = 0, high = 0, asked = tolerance;  // asked for: met, not met
        for (int i = 0;; ++i) {
            const bool met = tried.measured() <= tolerance;
            (met ? low : high) = asked;
            if (met && (!best.valid() || tried.triangles <= best.triangles)) best = tried;
            if (i == k_tries || (met && tried.measured() >= k_close_enough * tolerance)) break;
            const double secant = asked * std::clamp(0.995 * tolerance / std::max(tried.measured(), 1e-300),
                                                     1 / k_largest_step, k_largest_step);
            asked = low > 0 && high > 0 ? std::sqrt(low * high) : secant;
            tried = judged(estimator, asked);
        }
        return best;
    }

    /// Times from control arrays to indexed triangles with normals, the final measurement apart.
    void measure_times(Row& row) const {
        std::vector<std::function<std::any()>> works;
        std::vector<std::vector<double>*> times;
        const auto add = [&](std::vector<double>& of, std::function<std::any()> work) {
            works.push_back(std::move(work));
            times.push_back(&of);
        };
        const auto add_own = [&](std::vector<double>& of, EstimatorKind estimator, int threads) {
            add(of, [this, estimator, threads, &row] { return std::any(run(estimator, row.tolerance, threads)); });
        };
        const auto add_peer = [&](std::vector<double>& of, const PeerResult& peer) {
            if (auto work = peer_work(peer, data_, scheme_, judge_))
                add(of, [work = std::move(work)] { return std::any(work()); });
        };
        add_peer(row.rate_ms, row.rate);
        add_own(row.certified_ms, EstimatorKind::certified, 1);
        add_own(row.certified_two_threads_ms, EstimatorKind::certified, 2);
        add(row.certified_twice_ms, [this, &row] {
            std::jthread other([&] { run(EstimatorKind::certified, row.tolerance, 1); });
            auto result = std::any(run(EstimatorKind::certified, row.tolerance, 1));
            other.join();
            return result;
        });
        add_peer(row.adapt_ms, row.adapt);
        add_own(row.measured_ms, EstimatorKind::measured, 1);
        add_own(row.measured_two_threads_ms, EstimatorKind::measured, 2);
        auto measured = milliseconds_in_turns(runs_, works);
        for (std::size_t i = 0; i < works.size(); ++i) *times[i] = std::move(measured[i]);
    }

  private:
    Tessellation run(EstimatorKind estimator, double tolerance, int threads) const {
        TessellateOptions options;
        options.scheme = scheme_;
        options.estimator = estimator;
        options.tolerance = tolerance * judge_.diagonal();
        options.tolerance_is_absolute = true;
        options.measure = false;
        options.uvs = false;  // the peers make none
        RunContext context;
        context.threads = threads;
        return tessellate(ControlMesh::build(data_, context), options, context);
    }

    ControlMeshData data_;
    SchemeKind scheme_;
    LimitJudge judge_;
    int runs_;
};

double geometric_mean(const std::vector<double>& values) {
    double sum = 0;
    for (const double v : values) sum += std::log(v);
    return values.empty() ? NAN : std::exp(sum / static_cast<double>(values.size()));
}

std::string grouped(std::uint64_t n) {
    std::string text = std::to_string(n);
    for (int i = static_cast<int>(text.size()) - 3; i > 0; i -= 3) text.insert(static_cast<std::size_t>(i), 1, ',');
    return text;
}

std::string ratio_text(double value, bool known) { return known ? fmt::format("{:.2f}", value) : "-"; }

double over(std::uint64_t a, std::uint64_t b) { return static_cast<double>(a) / static_cast<double>(b); }

void print_counts(const std::vector<Row>& rows) {
    fmt::print(
        "Triangles at equal measured error (limit to mesh; ours also from mesh to limit). `-`: not met within 5 "
        "million\n"
        "triangles. The last three columns are `--estimator certified` at the tolerance itself.\n\n"
        "| model | tolerance | Bfr, best rate | Bfr, rates per edge | tetrakis | to best rate | to rates per edge | "
        "mesh to "
        "limit / tolerance | certified: triangles | certified / measured | certified / tolerance |\n"
        "|---|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|\n");
    for (const Row& r : rows)
        fmt::print("| {} | {:g} | {} | {} | {} | {} | {} | {:.2f} | {} | {:.2f} | {:.2f} |\n", r.model, r.tolerance,
                   r.rate.met ? grouped(r.rate.triangles) : "-", r.adapt.met ? grouped(r.adapt.triangles) : "-",
                   r.equal.valid() ? grouped(r.equal.triangles) : "-",
                   ratio_text(over(r.equal.triangles, r.rate.triangles), r.rate.met && r.equal.valid()),
                   ratio_text(over(r.equal.triangles, r.adapt.triangles), r.adapt.met && r.equal.valid()),
                   r.equal.backward / r.tolerance, grouped(r.certified.triangles),
                   r.certified.certified / r.certified.measured(), r.certified.certified / r.tolerance);
}

void print_times(const std::vector<Row>& rows) {
    fmt::print(
        "\nMilliseconds from control arrays to indexed triangles with normals, one thread, the tolerance as asked "
        "for.\n"
        "The peers' times are for a parameter that is known to suffice. All take turns; medians over the rounds.\n"
        "`two runs at once`: how much more work than one thread two do that share nothing: what the machine gives.\n\n"
        "| model | tolerance | Bfr, best rate | Bfr, rates per edge | certified | its triangles | measured | its "
        "triangles | "
        "two threads: certified | measured | two runs at once |\n"
        "|---|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|\n");
    for (const Row& r : rows)
        fmt::print("| {} | {:g} | {} | {} | {:.3g} | {} | {:.3g} | {} | {:.2f}x | {:.2f}x | {:.2f}x |\n", r.model,
                   r.tolerance, r.rate_ms.empty() ? "-" : fmt::format("{:.3g}", median_of(r.rate_ms)),
                   r.adapt_ms.empty() ? "-" : fmt::format("{:.3g}", median_of(r.adapt_ms)), median_of(r.certified_ms),
                   grouped(r.certified.triangles), median_of(r.measured_ms), grouped(r.measured.triangles),
                   median_ratio(r.certified_ms, r.certified_two_threads_ms),
                   median_ratio(r.measured_ms, r.measured_two_threads_ms), r.machine());
}

void print_means(const std::vector<Row>& rows, const std::vector<double>& tolerances) {
    fmt::print(
        "\nMeans over the models (geometric; of certified / measured the median). A peer that does not meet the\n"
        "tolerance is left out of its mean.\n\n"
        "| tolerance | triangles to best rate | to rates per edge | certified / measured | time to best rate: "
        "certified | "
        "measured | two threads: certified | measured | two runs at once |\n"
        "|--:|--:|--:|--:|--:|--:|--:|--:|--:|\n");
    for (const double tolerance : tolerances) {
        std::vector<double> to_rate, to_adapt, certified, time_certified, time_measured, two_certified, two_measured,
            machine;
        for (const Row& r : rows) {
            if (r.tolerance != tolerance) continue;
            if (r.rate.met && r.equal.valid()) to_rate.push_back(over(r.equal.triangles, r.rate.triangles));
            if (!r.rate_ms.empty()) {
                time_certified.push_back(median_ratio(r.certified_ms, r.rate_ms));
                time_measured.push_back(median_ratio(r.measured_ms, r.rate_ms));
            }
            if (r.adapt.met && r.equal.valid()) to_adapt.push_back(over(r.equal.triangles, r.adapt.triangles));
            certified.push_back(r.certified.certified / r.certified.measured());
            two_certified.push_back(median_ratio(r.certified_ms, r.certified_two_threads_ms));
            two_measured.push_back(median_ratio(r.measured_ms, r.measured_two_threads_ms));
            machine.push_back(r.machine());
        }
        fmt::print("| {:g} | {:.2f} ({}) | {:.2f} ({}) | {:.2f} | {:.2f} | {:.2f} | {:.2f}x | {:.2f}x | {:.2f}x |\n",
                   tolerance, geometric_mean(to_rate), to_rate.size(), geometric_mean(to_adapt), to_adapt.size(),
                   median_of(certified), geometric_mean(time_certified), geometric_mean(time_measured),
                   geometric_mean(two_certified), geometric_mean(two_measured), geometric_mean(machine));
    }
}

std::string processor() {
    std::ifstream info("/proc/cpuinfo");
    for (std::string line; std::getline(info, line);)
        if (line.starts_with("model name")) return line.substr(line.find(':') + 2);
    return "unknown processor";
}

}  // namespace

int main(int argc, char** argv) {
    CLI::App app("Triangles and time to a tolerance, tetrakis and OpenSubdiv's Bfr");
    std::vector<std::string> names;
    std::vector<double> tolerances{1e-2, 1e-3, 1e-4};
    std::string peers_file;
    std::uint64_t samples = 200'000;
    int runs = 5;
    app.add_option("--models", names, "Names, separated by commas (all)")->delimiter(',');
    app.add_option("--tolerances", tolerances, "Relative to the limit's diagonal")->delimiter(',');
    app.add_option("--peers", peers_file,
                   "File of the peers' results that are not measured again (bench_peers --keep)");
    app.add_option("--samples", samples, "Grid points on the limit surface");
    app.add_option("--runs", runs, "Rounds: the programs take turns, medians over the rounds count")
        ->check(CLI::PositiveNumber);
    CLI11_PARSE(app, argc, argv);
    if (!shared_folder()) {
        fmt::print("The shared test data are not here (TETRAKIS_SHARED_DIR): nothing to do.\n");
        return 0;
    }
    if (names.empty())
        for (const BenchModel& model : bench_models()) names.emplace_back(model.name);

    PeerResults peers(peers_file);
    std::vector<Row> rows;
    for (const std::string& name : names) {
        const BenchModel* model = find_bench_model(name);
        if (model == nullptr) {
            fmt::print(stderr, "no model named {}\n", name);
            return 2;
        }
        const Runner runner(*model, samples, runs);
        const auto peer = [&](double tolerance, std::string_view method, const auto& search) {
            if (peers.find(name, tolerance, method) == nullptr)
                peers.add(search(name, runner.data(), runner.scheme(), runner.judge(), tolerance));
            return *peers.find(name, tolerance, method);
        };
        for (const double t : tolerances) {
            fmt::print(stderr, "{} {:g}\n", name, t);
            Row row;
            row.model = name;
            row.tolerance = t;
            row.rate = peer(t, "bfr-rate", best_uniform_rate);
            row.adapt = peer(t, "bfr-adapt", best_adaptive_rates);
            row.measured = runner.judged(EstimatorKind::measured, t);
            row.certified = runner.judged(EstimatorKind::certified, t);
            row.equal = runner.at_equal_error(EstimatorKind::measured, t, row.measured);
            runner.measure_times(row);
            rows.push_back(std::move(row));
        }
    }
    fmt::print("tetrakis {}, {}, g++ {}, {:%Y-%m-%d}\n\n", k_version, processor(), __VERSION__,
               fmt::localtime(std::time(nullptr)));
    print_counts(rows);
    print_times(rows);
    print_means(rows, tolerances);
    return 0;
}
