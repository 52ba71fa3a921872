#include "../../eval/tessellate/tessellate.hpp"
#include "../../hier/obj/obj_reader.hpp"

#include <doctest/doctest.h>

#include <array>
#include <cstdint>
#include <cstdlib>
#include <sstream>
#include <string>

using namespace tetrakis;

namespace {

// Largest relative difference from the stored number. An intended change of numbers must update the table.
constexpr double k_most_change = 0.03;
constexpr std::array<double, 3> k_tolerances = {1e-2, 1e-3, 3e-4};

struct Row {
    const char *model, *scheme;
    std::array<std::uint64_t, 3> by_measure;
    std::array<std::uint64_t, 3> by_bound;  ///< 0: left out, or the scheme has no bound for the model
};

// Numbers of triangles for each tolerance; 0: left out because it takes seconds. If a number is wrong, the test prints
// the whole new table, which can be pasted here.
constexpr Row k_table[] = {
    // clang-format off
    {"rook", "catmull-clark", {360, 5760, 26604}, {384, 6876, 32220}},
    {"pawn", "catmull-clark", {488, 4768, 15048}, {552, 5448, 16440}},
    {"head", "catmull-clark", {1040, 4286, 13506}, {1040, 5232, 17560}},
    {"bracket", "catmull-clark", {224, 6632, 18792}, {296, 8416, 23488}},
    {"knot", "catmull-clark", {1024, 5454, 18590}, {1024, 6242, 21470}},
    {"pipe3", "catmull-clark", {240, 2940, 8688}, {240, 3072, 9540}},
    {"extruded_pentagon", "catmull-clark", {230, 2360, 8100}, {230, 2680, 9160}},
    {"cube", "catmull-clark", {192, 2544, 6816}, {192, 2736, 7968}},
    {"tetrahedron", "catmull-clark", {96, 1056, 3408}, {96, 1296, 4104}},
    {"bracket_tri", "loop", {384, 10484, 27338}, {528, 14740, 38840}},
    {"knot_tri", "loop", {1024, 8012, 25184}, {1024, 10122, 30818}},
    {"tetrahedron", "loop", {64, 1024, 3928}, {64, 1024, 4096}},
    {"cube", "doo-sabin", {620, 4508, 0}, {620, 4508, 0}},
    {"knot", "kobbelt", {1024, 7020, 0}, {1024, 6484, 0}},
    {"tetrahedron", "butterfly", {352, 3616, 0}, {256, 3232, 0}},
    {"pipe3", "biquartic", {1010, 4202, 0}, {0, 0, 0}},
    // clang-format on
};

std::uint64_t count(const ControlMesh& mesh, const char* scheme, EstimatorKind estimator, double tolerance) {
    // The measured estimator repairs the mesh by its measurement; the certified one needs no measurement.
    return tessellate(mesh, {.scheme = scheme,
                             .estimator = estimator,
                             .tolerance = tolerance,
                             .measure = estimator == EstimatorKind::measured,
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
             {std::pair{EstimatorKind::measured, row.by_measure}, {EstimatorKind::certified, row.by_bound}}) {
            const bool known = estimator == EstimatorKind::measured || scheme_support(mesh, row.scheme).certified;
            found << ", {";
            for (std::size_t i = 0; i < k_tolerances.size(); ++i) {
                const bool quick = i < 2 || scheme_support(row.scheme).patches;
                const std::uint64_t now = known && quick ? count(mesh, row.scheme, estimator, k_tolerances[i]) : 0;
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
