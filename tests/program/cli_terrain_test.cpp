#include "../../eval/io/mesh_reader.hpp"

#include "../kit/cli.hpp"
#include "../kit/judged_terrain.hpp"

#include <doctest/doctest.h>

#include <array>
#include <set>
#include <string>
#include <vector>

using namespace tetrakis;
using namespace tetrakis::test;

TEST_SUITE_BEGIN("cli");

namespace {

/// The grid as a raw file, and the options that read it.
std::vector<std::string> terrain_line(const ScratchDir& scratch, const HeightGrid& grid) {
    const auto* const bytes = reinterpret_cast<const char*>(grid.heights.data());
    spill(scratch / "heights.r32", std::string(bytes, grid.heights.size() * sizeof(float)));
    return {"terrain",  (scratch / "heights.r32").string(), "--columns", std::to_string(grid.columns),
            "--rows",   std::to_string(grid.rows),          "--spacing", "30.3",
            "--normals"};
}

/// Positions and normals of the vertices on one side of a mesh's box.
std::set<std::array<double, 6>> side(const TriangleMesh& mesh, int axis, bool upper) {
    const Box3d box = bounding_box(mesh.positions);
    std::set<std::array<double, 6>> found;
    for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
        const Vec3d &p = mesh.positions[v], &n = mesh.normals.at(v);
        if (p[axis] == (upper ? box.upper : box.lower)[axis]) found.insert({p.x, p.y, p.z, n.x, n.y, n.z});
    }
    return found;
}

}  // namespace

TEST_CASE("terrain --tiles: neighbours have the same vertices and normals, and every sample is within the tolerance") {
    constexpr int k_across = 9, k_down = 4;
    constexpr double k_max_error = 0.7;
    HeightGrid grid = rough(130, 61, 8);
    grid.spacing = {30.3, 30.3};
    const ScratchDir scratch;
    for (const std::string extension : {".obj", ".ply", ".glb"}) {
        CAPTURE(extension);
        const nlohmann::json report = cli::run_report(cli::join(
            terrain_line(scratch, grid),
            {"--max-error", std::to_string(k_max_error), "--tiles",
             std::to_string(k_across) + "x" + std::to_string(k_down), "-o", (scratch / ("t" + extension)).string()}));
        REQUIRE(report["tiles"].size() == k_across * k_down);
        std::vector<TriangleMesh> tiles;
        TriangleMesh all;
        for (int t = 0; t < k_across * k_down; ++t) {
            const std::string name =
                "t_" + std::to_string(t / k_across) + "_" + std::to_string(t % k_across) + extension;
            CHECK(report["tiles"][t]["file"] == (scratch / name).string());
            tiles.push_back(read_triangle_mesh(scratch / name));
            const TriangleMesh& tile = tiles.back();
            CHECK((tile.triangle_normals.empty() || tile.triangle_normals == tile.triangles));
            CHECK(report["tiles"][t]["triangles"] == tile.triangles.size());
            const auto first = static_cast<std::uint32_t>(all.positions.size());
            all.positions.insert(all.positions.end(), tile.positions.begin(), tile.positions.end());
            for (const auto& [a, b, c] : tile.triangles) all.triangles.push_back({first + a, first + b, first + c});
        }
        CHECK(report["triangles"] == all.triangles.size());
        for (int t = 0; t < k_across * k_down; ++t) {
            CAPTURE(t);
            if (t % k_across > 0) CHECK(side(tiles[t], 0, false) == side(tiles[t - 1], 0, true));
            if (t / k_across > 0) CHECK(side(tiles[t], 1, true) == side(tiles[t - k_across], 1, false));
        }
        if (extension == ".glb") continue;  // its floats are beside the samples
        const Judged judged = judge(all, grid);
        CHECK(judged.largest_error <= k_max_error * (1 + 1e-9));
        CHECK(judged.turned == 0);
        CHECK(judged.area == doctest::Approx((grid.columns - 1.0) * (grid.rows - 1.0)).epsilon(1e-12));
    }
}

TEST_CASE("[bad-input] terrain --tiles: what are no tiles") {
    const ScratchDir scratch;
    const std::vector<std::string> start = terrain_line(scratch, rough(9, 7, 1));
    const auto refused = [&](const std::string& tiles, int code, const std::string& words) {
        const cli::Words more = {"--max-error", "1", "--tiles", tiles, "-o", (scratch / "t.obj").string()};
        cli::check_refused(cli::join(start, more), code, words);
        CHECK(scratch.file_count() == 1);
    };
    for (const char* const tiles : {"0x1", "2x0", "3", "2x2x2", "ax2", "2x-1", "1.5x2", "x", "5000x1"})
        refused(tiles, 2, std::string(tiles) + " is no pair of counts such as 4x3");
    refused("9x1", 3, "9 x 1 tiles; a grid of 9 x 7 samples can have 1 x 1 to 8 x 6");
    refused("1x7", 3, "can have 1 x 1 to 8 x 6");
}

TEST_SUITE_END();
