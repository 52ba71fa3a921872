#include "../../eval/lod_surfaces/terrain_surface.hpp"
#include "../../eval/distance/triangle_bvh.hpp"
#include "../../eval/lod/view.hpp"
#include "../../eval/lod_surfaces/terrain_tiles.hpp"
#include "../../eval/lod_surfaces/tiled_terrain.hpp"
#include "../../hier/forest/bisection_forest.hpp"
#include "../../hier/forest/corner_cell.hpp"

#include "../kit/height_grids.hpp"
#include "../kit/scratch_dir.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <utility>
#include <vector>

using namespace tetrakis;
using namespace tetrakis::test;

namespace {

/// @return  how many samples were looked at
std::size_t check_bounds(const lod::Surface& surface, const HeightGrid& grid) {
    BisectionForest forest(surface.roots());
    std::mt19937 random(grid.columns);
    std::size_t samples = 0;
    for (int round = 0; round + 4 < surface.max_depth(); ++round) {
        std::vector<LeafId> marked, created;
        for (const LeafId leaf : forest.ordered_leaves())
            if (forest.depth(leaf) < surface.max_depth() && random() % 2 == 0) marked.push_back(leaf);
        forest.refine(marked, created);
    }
    for (const LeafId id : forest.ordered_leaves()) {
        const BisectionLeaf& leaf = forest.leaf(id);
        std::array<Site, 3> sites;
        std::array<lod::Place, 3> corners;
        for (std::size_t k = 0; k < 3; ++k) sites[k] = forest.point_site(leaf.vertex[k]);
        surface.places(sites, corners);
        if (leaf.depth >= surface.max_depth()) continue;
        const std::array<Site, 2> diamonds{
            canonical(forest.mesh(), {leaf.cell, leaf.shape().middle(leaf.depth), lattice_level(leaf.depth + 1)}),
            sites[2]};
        std::array<lod::DiamondBounds, 2> bounds;
        const bool has_parent = !forest.is_fixed(leaf.vertex[2]);
        surface.bounds(std::span(diamonds).first(has_parent ? 2 : 1), std::span(bounds).first(has_parent ? 2 : 1));
        const auto& [own, parent] = bounds;
        if (has_parent) {
            REQUIRE(parent.error >= own.error * lod::k_error_ratio * (1 - 1e-6));
            for (int axis = 0; axis < 3; ++axis)
                REQUIRE(std::abs(own.center[axis] - parent.center[axis]) <=
                        parent.half_sides[axis] - own.half_sides[axis] + 1e-9);
        }
        // The midpoint halves the base.
        std::array<lod::Place, 1> middle;
        surface.places(std::span(diamonds).first(1), middle);
        const Vec3d &a = corners[0].position, &b = corners[1].position, &c = corners[2].position;
        const Vec3d foot = middle[0].on_edge - a;
        REQUIRE(glm::length(glm::cross(foot, b - a)) <= 1e-9 * glm::dot(b - a, b - a));
        REQUIRE(glm::dot(foot, b - a) >= 0);
        // All samples under the leaf.
        const auto twice = [](const Vec3d& p, const Vec3d& q, const Vec3d& r) {
            return (q.x - p.x) * (r.y - p.y) - (q.y - p.y) * (r.x - p.x);
        };
        const double area = twice(a, b, c);
        REQUIRE(area > 0);
        for (double y = std::ceil(-std::max({a.y, b.y, c.y}) / 2); - 2 * y >= std::min({a.y, b.y, c.y}); ++y)
            for (double x = std::ceil(std::min({a.x, b.x, c.x}) / 3); 3 * x <= std::max({a.x, b.x, c.x}); ++x) {
                Vec3d at(3 * x, -2 * y, 0);
                const double u = twice(at, b, c) / area, v = twice(a, at, c) / area, w = 1 - u - v;
                if (u < 0 || v < 0 || w < 0) continue;
                at.z = double{grid.at(static_cast<std::uint32_t>(x), static_cast<std::uint32_t>(y))};
                ++samples;
                REQUIRE(std::abs(u * a.z + v * b.z + w * c.z - at.z) <= own.error + 1e-5);
                for (int axis = 0; axis < 3; ++axis)
                    REQUIRE(std::abs(at[axis] - own.center[axis]) <= own.half_sides[axis] + 1e-9);
            }
    }
    return samples;
}

}  // namespace

TEST_CASE("terrain surface: bounds hold all samples, and are nested") {
    for (const auto& [columns, rows] : {std::pair{129u, 129u}, {100u, 37u}, {9u, 200u}, {2u, 2u}, {5u, 3u}}) {
        CAPTURE(columns);
        CAPTURE(rows);
        HeightGrid grid = rough(columns, rows, 11);
        grid.spacing = {3, 2};
        const lod::TerrainSurface surface(grid);
        CHECK(surface.memory_bytes() - 4 * columns * rows < 12 * columns * rows);
        const std::size_t samples = check_bounds(surface, grid);
        if (columns > 5) CHECK(samples > columns * rows / 2);
    }
}

TEST_CASE("terrain surface: bounds of tiles hold all samples, and are nested") {
    const ScratchDir dir;
    for (const auto& [columns, rows] : {std::pair{129u, 129u}, {100u, 37u}, {9u, 200u}, {2u, 2u}, {5u, 3u}}) {
        CAPTURE(columns);
        CAPTURE(rows);
        HeightGrid grid = rough(columns, rows, 11);
        grid.spacing = {3, 2};
        lod::write_tiles(*make_height_source(grid), dir / "t.tiles", {.side = 16});
        const lod::TiledTerrain surface(dir / "t.tiles");
        lod::View everything(surface, {.max_leaves = 200'000});
        while (everything.update({}, {.pixel_error = 1e-12}).waiting > 0) surface.wait(surface.revision());
        const std::size_t samples = check_bounds(surface, grid);
        if (columns > 5) CHECK(samples > columns * rows / 2);
        CHECK(surface.statistics().failures == 0);
        // The same finest triangles.
        const lod::TerrainSurface whole(grid);
        std::mt19937 random(rows);
        std::uniform_real_distribution<double> one(0, 1);
        const auto place = [&] { return Vec3d(3 * (columns - 1) * one(random), -2.0 * (rows - 1) * one(random), 0); };
        for (int i = 0; i < 100; ++i) {
            const Vec3d from = place() + Vec3d(0, 0, 90), direction = place() - from;
            const auto t = surface.hit(from, direction), other = whole.hit(from, direction);
            REQUIRE(t.has_value() == other.has_value());
            if (t) {
                REQUIRE(t->t == doctest::Approx(other->t).epsilon(1e-9));
                REQUIRE(glm::length(t->normal - other->normal) < 1e-9);
            }
            const Vec2d below(1.1 * from.x, from.y);
            const auto ground = surface.at(below), same = whole.at(below);
            REQUIRE(ground.has_value() == same.has_value());
            if (!ground) continue;
            REQUIRE(ground->height == same->height);
            REQUIRE(ground->normal == same->normal);
        }
    }
}

TEST_CASE("terrain surface: heights and rays meet the finest mesh") {
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
        const auto from_mesh = [&](const Vec3d& p) { return bvh.closest(p).distance; };
        const auto normal_at = [&](const Vec3d& p) {
            const auto& t = mesh.triangles[bvh.closest(p).triangle];
            const Vec3d &a = mesh.positions[t[0]], &b = mesh.positions[t[1]], &c = mesh.positions[t[2]];
            return glm::normalize(glm::cross(b - a, c - a));
        };
        int hits = 0;
        for (int i = 0; i < 2000; ++i) {
            Vec3d p = place();
            const auto ground = surface.at({p.x, p.y});
            REQUIRE(ground);
            p.z = ground->height;
            REQUIRE(from_mesh(p) < 1e-9);
            REQUIRE(glm::length(ground->normal - normal_at(p)) < 1e-6);
            // From above and below, straight and aslant.
            const Vec3d aim = p, from = i % 4 == 0 ? Vec3d(p.x, p.y, i % 8 == 0 ? 500 : -500)
                                                   : place() + Vec3d(0, 0, i % 2 == 0 ? 80 : -80);
            const auto hit = surface.hit(from, aim - from);
            REQUIRE(hit);
            const double t = hit->t;
            REQUIRE(t <= 1 + 1e-9);
            const Vec3d met = from + t * (aim - from);
            REQUIRE(from_mesh(met) < 1e-6);
            REQUIRE(glm::length(hit->normal - normal_at(met)) < 1e-6);
            // Nothing is met before.
            for (int k = 1; k < 8; ++k) {
                const Vec3d before = from + t * k / 8.0 * (aim - from);
                const auto under = surface.at({before.x, before.y});
                if (under) REQUIRE((before.z - under->height) * (from.z > 0 ? 1 : -1) > -1e-9);
            }
            REQUIRE(!surface.hit(from, aim - from, t * 0.999));
            REQUIRE(!surface.hit(from, from - aim));
            if (t < 0.999) ++hits;
        }
        if (columns > 2) CHECK(hits > 20);
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
