#include "../../eval/tessellate/tessellate.hpp"

#include "../../eval/surface/height_image.hpp"
#include "../../hier/mesh/obj_reader.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <set>
#include <string>
#include <thread>
#include <vector>

using namespace tetrakis;

TEST_SUITE_BEGIN("eval");

namespace {

/// A cube with two boundaries opened and UVs, as quads or as triangles.
ControlMesh open_cube(bool triangles) {
    std::string text =
        "v -1 -1 -1\nv 1 -1 -1\nv -1 1 -1\nv 1 1 -1\nv -1 -1 1\nv 1 -1 1\nv -1 1 1\nv 1 1 1\n"
        "vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n";
    for (const auto& q : {std::array{1, 3, 4, 2}, {5, 6, 8, 7}, {1, 2, 6, 5}, {4, 3, 7, 8}}) {
        const auto corner = [&](std::size_t k) { return std::to_string(q[k]) + "/" + std::to_string(k + 1) + " "; };
        if (triangles)
            text += "f " + corner(0) + corner(1) + corner(2) + "\nf " + corner(0) + corner(2) + corner(3) + "\n";
        else
            text += "f " + corner(0) + corner(1) + corner(2) + corner(3) + "\n";
    }
    return ControlMesh::build(parse_obj(text, "cube.obj"));
}

struct Report {
    std::string stage;
    double fraction;
};

/// What is reported until the caller cancels at report number `last` of a stage (empty: never); checks that it comes
/// from the calling thread.
std::vector<Report> reports_of(const ControlMesh& mesh, const TessellateOptions& options,
                               const std::string& last_stage = {}, std::size_t last = 0) {
    std::vector<Report> reports;
    std::size_t in_stage = 0;
    const auto caller = std::this_thread::get_id();
    RunContext context;
    context.threads = 2;
    context.progress = [&](std::string_view stage, double fraction) {
        CHECK(std::this_thread::get_id() == caller);
        reports.push_back({std::string(stage), fraction});
        in_stage += stage == last_stage;
        return last == 0 || in_stage < last;
    };
    bool cancelled = false;
    try {
        tessellate(mesh, options, context);
    } catch (const Error& error) {
        REQUIRE(error.code() == ErrorCode::cancelled);
        cancelled = true;
    }
    CHECK(cancelled == (last != 0 && in_stage == last));
    return reports;
}

std::set<std::string> stages_of(const std::vector<Report>& reports) {
    std::set<std::string> stages;
    for (const Report& report : reports) stages.insert(report.stage);
    return stages;
}

}  // namespace

TEST_CASE("every phase of a tessellation reports, and can be cancelled at each of its reports") {
    HeightImage image{8, 8, {}};
    for (int i = 0; i < 64; ++i) image.values.push_back(static_cast<float>(i % 5) / 4);
    TessellateOptions loop, quads, certified, budget, displaced;
    loop.scheme = SchemeKind::loop;
    for (TessellateOptions* options : {&loop, &quads, &certified, &displaced}) options->tolerance = 1e-2;
    for (TessellateOptions* options : {&quads, &displaced}) options->measure = true;
    certified.estimator = EstimatorKind::certified;
    budget.max_triangles = 700;
    displaced.displacement = &image;
    displaced.amplitude = 0.05;
    displaced.tolerance = 3e-2;
    for (const TessellateOptions* options : {&loop, &quads, &certified, &budget, &displaced}) {
        const ControlMesh mesh = open_cube(options == &loop);
        const std::vector<Report> all = reports_of(mesh, *options);
        const std::set<std::string> stages = stages_of(all);
        for (const char* stage : {"build", "coarsest", "refine", "export", "measure", "certify", "attributes"}) {
            if (stage == std::string("coarsest") && options == &loop) continue;
            if (stage == std::string("measure") && !options->measure) continue;
            if (stage == std::string("certify") && options == &displaced) continue;
            CAPTURE(stage);
            CHECK(stages.contains(stage));
        }
        for (const Report& report : all) {
            CHECK(report.fraction >= 0);
            CHECK(report.fraction <= 1);
        }
        // Each phase at its first report and in the middle of them. How often Embree reports while it builds is its own
        // affair, so that only the first is sure to come.
        for (const std::string& stage : stages) {
            const std::size_t count = static_cast<std::size_t>(
                std::count_if(all.begin(), all.end(), [&](const Report& report) { return report.stage == stage; }));
            for (const std::size_t moment : std::set<std::size_t>{1, (count + 1) / 2}) {
                const std::vector<Report> some = reports_of(mesh, *options, stage, moment);
                if (moment == 1) CHECK(some.back().stage == stage);
            }
        }
    }
}

TEST_CASE("with a number of triangles the progress is their share of it, and never goes back") {
    const ControlMesh mesh = open_cube(false);
    TessellateOptions options;
    options.max_triangles = 5000;
    options.measure = false;
    double last = 0;
    std::size_t steps = 0;
    for (const Report& report : reports_of(mesh, options)) {
        if (report.stage != "refine") continue;
        CHECK(report.fraction >= last);
        steps += report.fraction > last;
        last = report.fraction;
    }
    CHECK(last > 0.99);
    CHECK(steps > 100);
}

TEST_SUITE_END();
