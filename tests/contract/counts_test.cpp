#include "tests/contract/judge.hpp"

#include "tetrakis/eval/tessellate.hpp"
#include "tetrakis/hier/obj_reader.hpp"

#include <doctest/doctest.h>

#include <array>
#include <cstdint>
#include <cstdlib>
#include <map>
#include <sstream>
#include <string>

using namespace tetrakis;

namespace {

// The share by which a number may differ from what is stored. All that makes a difference on purpose renews the table.
constexpr double k_most_change = 0.03;
constexpr std::array<double, 3> k_tolerances = {1e-2, 1e-3, 3e-4};

struct Row {
    const char *model, *scheme;
    std::array<std::uint64_t, 3> by_measure;
    std::array<std::uint64_t, 3> by_bound;  ///< 0: the scheme has no bound there
};

// Triangles for each tolerance. When one is off, the test prints the whole table anew, to be put here.
constexpr Row k_table[] = {
    // clang-format off
    {"rook", "catmull-clark", {}, {}},
    {"pawn", "catmull-clark", {}, {}},
    {"head", "catmull-clark", {}, {}},
    {"bracket", "catmull-clark", {}, {}},
    {"knot", "catmull-clark", {}, {}},
    {"pipe3", "catmull-clark", {}, {}},
    {"extruded_pentagon", "catmull-clark", {}, {}},
    {"cube", "catmull-clark", {}, {}},
    {"bracket_tri", "loop", {}, {}},
    {"knot_tri", "loop", {}, {}},
    {"tetrahedron", "loop", {}, {}},
    {"rook", "doo-sabin", {}, {}},
    {"knot", "kobbelt", {}, {}},
    {"tetrahedron", "butterfly", {}, {}},
    {"pipe3", "biquartic", {}, {}},
    // clang-format on
};

std::uint64_t count(const ControlMesh& mesh, const char* scheme, EstimatorKind estimator, double tolerance) {
    // By measure the mesh is mended by what is measured; the bound needs no measurement.
    return tessellate(mesh, {.scheme = scheme,
                             .estimator = estimator,
                             .tolerance = tolerance,
                             .measure = estimator == contract::k_by_measure,
                             .measure_samples = 20'000})
        .mesh.triangles.size();
}

}  // namespace

TEST_SUITE_BEGIN("contract");

TEST_CASE("[slow] tessellations have as many triangles as they had, within 3 percent") {
    std::ostringstream found;
    bool same = true;
    for (const Row& row : k_table) {
        const ControlMesh mesh = load_control_mesh(std::string(TETRAKIS_SOURCE_DIR "/data/") + row.model + ".obj");
        found << "    {\"" << row.model << "\", \"" << row.scheme << "\"";
        for (const auto& [estimator, stored] :
             {std::pair{contract::k_by_measure, row.by_measure}, {contract::k_by_bound, row.by_bound}}) {
            const bool known = estimator == contract::k_by_measure || scheme_support(mesh, row.scheme).certified;
            found << ", {";
            for (std::size_t i = 0; i < k_tolerances.size(); ++i) {
                std::uint64_t now = 0;
                try {
                    if (known) now = count(mesh, row.scheme, estimator, k_tolerances[i]);
                } catch (const Error& error) {  // semi-sharp tags that its bound does not know
                    if (error.code() != ErrorCode::unsupported) throw;
                }
                const auto before = static_cast<double>(stored[i]);
                same &= std::abs(static_cast<double>(now) - before) <= k_most_change * before;
                found << (i > 0 ? ", " : "") << now;
            }
            found << "}";
        }
        found << "},\n";
    }
    CHECK_MESSAGE(same, "the table is now:\n" << found.str());
}

TEST_SUITE_END();
