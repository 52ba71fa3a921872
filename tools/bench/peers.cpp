// The peers alone: the fewest triangles with which Bfr meets a tolerance, by its best uniform rate and by rates that
// are estimated per edge. Checks the judge and the peers against known figures, and fills the file that bench_tolerance
// reads.
//   bench_peers [--models a,b] [--tolerances 1e-2,1e-3] [--keep FILE] [--samples N]
#include "bench_models.hpp"
#include "peer_search.hpp"

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <cstdio>

using namespace tetrakis;
using namespace tetrakis::bench;

int main(int argc, char** argv) {
    CLI::App app("Bfr's triangles and times to a tolerance");
    std::vector<std::string> names;
    std::vector<double> tolerances{1e-2, 1e-3, 1e-4};
    std::string keep;
    std::uint64_t samples = 200'000;
    app.add_option("--models", names, "Names, separated by commas (all)")->delimiter(',');
    app.add_option("--tolerances", tolerances, "Relative to the limit's diagonal")->delimiter(',');
    app.add_option("--keep", keep, "File of results that are not measured again");
    app.add_option("--samples", samples, "Grid points on the limit surface");
    CLI11_PARSE(app, argc, argv);
    if (!shared_folder()) {
        fmt::print("The shared test data are not here (TETRAKIS_SHARED_DIR): nothing to do.\n");
        return 0;
    }
    if (names.empty())
        for (const BenchModel& model : bench_models()) names.emplace_back(model.name);

    PeerResults results(keep);
    fmt::print("| model | tolerance | method | triangles | ms | with normals | error | mesh to limit | parameter |\n");
    fmt::print("|---|---|---|---|---|---|---|---|---|\n");
    for (const std::string& name : names) {
        const BenchModel* model = find_bench_model(name);
        if (model == nullptr) {
            fmt::print(stderr, "no model named {}\n", name);
            return 2;
        }
        const ControlMeshData data = load_bench_model(*model);
        std::unique_ptr<LimitJudge> judge;
        for (const double tolerance : tolerances)
            for (const auto& [method, search] :
                 {std::pair{"bfr-rate", &best_uniform_rate}, std::pair{"bfr-adapt", &best_adaptive_rates}}) {
                const PeerResult* known = results.find(name, tolerance, method);
                if (known == nullptr) {
                    if (!judge) judge = std::make_unique<LimitJudge>(data, model->scheme, samples);
                    results.add(search(name, data, model->scheme, *judge, tolerance));
                    known = results.find(name, tolerance, method);
                }
                fmt::print("| {} | {:g} | {} | {} | {:.3g} | {:.3g} | {:.3e} | {:.3e} | {}{} |\n", name, tolerance,
                           method, known->triangles, known->ms, known->ms_normals, known->error, known->backward,
                           known->parameter, known->met ? "" : ", not met");
                std::fflush(stdout);
            }
    }
    return 0;
}
