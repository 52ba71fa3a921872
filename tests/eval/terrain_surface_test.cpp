#include "../../eval/lod_surfaces/terrain_surface.hpp"
#include "../../eval/distance/triangle_bvh.hpp"
#include "../../eval/lod/view.hpp"
#include "../../hier/forest/bisection_forest.hpp"

#include "../kit/height_grids.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <utility>
#include <vector>

using namespace tetrakis;
using namespace tetrakis::test;

TEST_CASE("terrain surface: heights are those of the finest mesh, and rays meet nothing before it") {
    for (const auto& [columns, rows] : {std::pair{33u, 33u}, {45u, 20u}, {2u, 9u}}) {
        CAPTURE(columns);
        HeightGrid grid = rough(columns, rows, 2);
        grid.spacing = {2, 3};
        grid.origin = {100, 50};
        const lod::TerrainSurface surface(grid);
        lod::View view(surface);
        // Everything, as the eye is everywhere.
        for (int i = 0; i < 2; ++i) view.update({.eye = {120, 20, 0}}, {.pixel_error = 1e-12});
        const TriangleMesh mesh = view.mesh();
        const TriangleBvh bvh(mesh);
        const double width = 2.0 * (columns - 1), height = 3.0 * (rows - 1);
        std::mt19937 random(columns);
        std::uniform_real_distribution<double> one(0, 1);
        const auto place = [&] { return Vec3d(100 + width * one(random), 50 - height * one(random), 0); };
        for (int i = 0; i < 500; ++i) {
            Vec3d p = place();
            const auto ground = surface.at({p.x, p.y});
            REQUIRE(ground);
            p.z = ground->height;
            const ClosestPoint found = bvh.closest(p);
            REQUIRE(found.distance < 1e-9);
            const auto& t = mesh.triangles[found.triangle];
            const Vec3d &a = mesh.positions[t[0]], &b = mesh.positions[t[1]], &c = mesh.positions[t[2]];
            REQUIRE(glm::length(ground->normal - glm::normalize(glm::cross(b - a, c - a))) < 1e-6);
            // From above and below.
            const Vec3d from =
                i % 4 == 0 ? Vec3d(p.x, p.y, i % 8 == 0 ? 500 : -500) : place() + Vec3d(0, 0, i % 2 == 0 ? 80 : -80);
            const auto hit = surface.hit(from, p - from);
            REQUIRE(hit);
            REQUIRE(hit->t <= 1 + 1e-9);
            REQUIRE(!surface.hit(from, p - from, hit->t * 0.999));
            REQUIRE(!surface.hit(from, from - p));
        }
        CHECK(!surface.at({99, 50}));
        CHECK(!surface.at({100, 50.1}));
        CHECK(surface.at({100, 50})->height == double{grid.at(0, 0)});
        CHECK(surface.at({100 + width, 50 - height})->height == double{grid.at(columns - 1, rows - 1)});
    }
}

TEST_CASE("terrain surface: samples are vertices, for any number of threads") {
    const HeightGrid grid = rough(90, 70, 3);
    RunContext one, two;
    one.threads = 1;
    two.threads = 2;
    const lod::TerrainSurface surface(grid, one), same(grid, two);
    BisectionForest forest(surface.roots());
    for (int i = 0; i < surface.max_depth(); ++i) {
        std::vector<LeafId> created;
        forest.refine(forest.ordered_leaves(), created);
    }
    std::vector<char> seen(grid.heights.size(), 0);
    for (std::uint32_t p = 0; p < forest.point_slots(); ++p) {
        const std::array site{forest.point_site(PointId(p))};
        std::array<lod::Place, 1> place, other;
        surface.places(site, place);
        same.places(site, other);
        REQUIRE(place[0].position == other[0].position);
        if (!forest.is_fixed(PointId(p))) {
            std::array<lod::DiamondBounds, 1> bounds, others;
            surface.bounds(site, bounds);
            same.bounds(site, others);
            REQUIRE(bounds[0].error == others[0].error);
        }
        const double x = place[0].position.x, y = -place[0].position.y;
        if (x != std::floor(x) || y != std::floor(y)) continue;
        const auto column = static_cast<std::uint32_t>(x), row = static_cast<std::uint32_t>(y);
        REQUIRE(place[0].position.z == double{grid.at(column, row)});
        seen[row * std::size_t{grid.columns} + column] = 1;
    }
    CHECK(std::count(seen.begin(), seen.end(), 0) == 0);
}
