#include "../../eval/lod/view.hpp"
#include "../../eval/lod_surfaces/procedural_surface.hpp"
#include "../../eval/lod_surfaces/subdivision_surface.hpp"
#include "../../eval/lod_terrain/terrain_surface.hpp"
#include "../../eval/lod_terrain/terrain_tiles.hpp"
#include "../../eval/lod_terrain/tiled_terrain.hpp"
#include "../../eval/terrain/height_source.hpp"
#include "../../hier/base/error.hpp"

#include "../kit/input_helpers.hpp"
#include "../kit/judged_terrain.hpp"
#include "../kit/lod_walks.hpp"
#include "../kit/scratch_dir.hpp"
#include "../kit/surface_topology.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <initializer_list>
#include <limits>
#include <map>
#include <random>
#include <set>
#include <stdexcept>
#include <thread>
#include <utility>
#include <vector>

#if defined(__GLIBC__)
#    include <malloc.h>
#endif

using namespace tetrakis;
using namespace tetrakis::test;

namespace {

/// Bytes that malloc() has given to the program; 0 where it does not say.
std::uint64_t heap_bytes() {
#if defined(__GLIBC__)
    const auto heap = mallinfo2();
    return heap.uordblks + heap.hblkhd;
#else
    return 0;
#endif
}

}  // namespace

TEST_CASE("lod: a camera that stands still changes nothing, and one that comes back finds nothing finer than needed") {
    const HeightGrid grid = rough(200, 200, 9);
    const lod::TerrainSurface surface(grid);
    lod::View view(surface, {.max_leaves = 100'000});
    Wanderer wanderer(grid, 1);
    const lod::Camera home = wanderer.next();
    const lod::Update first = view.update(home);
    CHECK(first.splits > 1000);
    CHECK(first.pixel_error == 1);
    const lod::Update again = view.update(home);
    CHECK(again.splits + again.merges == 0);
    CHECK(again.vertices.empty());
    CHECK(again.triangles.empty());
    for (int i = 0; i < 100; ++i) view.update(wanderer.next());
    const lod::Update back = view.update(home);
    CHECK(back.pixel_error == 1);
    // Hysteresis keeps some leaves that the first view did not have.
    CHECK(back.leaves >= first.leaves);
    CHECK(back.leaves < 2.5 * first.leaves);
    // The old view has split all that a new view splits, whatever its history, because errors are nested.
    std::set<std::array<Site, 3>> fine;
    lod::View fresh(surface, {.max_leaves = 100'000});
    fresh.update(home);
    const auto points = [](const lod::View& of) {
        std::set<Site> sites;
        for (const auto& leaf : of.leaves()) sites.insert(leaf.begin(), leaf.end());
        return sites;
    };
    const std::set<Site> old_points = points(view), new_points = points(fresh);
    CHECK(std::includes(old_points.begin(), old_points.end(), new_points.begin(), new_points.end()));
}

TEST_CASE("lod: with a few microseconds a frame the same mesh comes about later") {
    const HeightGrid grid = rough(200, 200, 9);
    const lod::TerrainSurface surface(grid);
    lod::View hasty(surface), patient(surface);
    Wanderer wanderer(grid, 2);
    Copied copied;
    const lod::Camera camera = wanderer.next();
    patient.update(camera);
    lod::Update update;
    int frames = 0;
    do {
        update = hasty.update(camera, {.milliseconds = 0.02});
        copied.take(hasty, update);
        REQUIRE(copied.equals(hasty));
        ++frames;
        REQUIRE(frames < 100'000);
    } while (!update.complete);
    CHECK(frames > 3);
    auto late = hasty.leaves(), soon = patient.leaves();
    std::sort(late.begin(), late.end());
    std::sort(soon.begin(), soon.end());
    CHECK(late == soon);
}

TEST_CASE("lod: with little time a view follows pixels, angles or regions that change every frame") {
    const HeightGrid grid = rough(120, 120, 9);
    const lod::TerrainSurface surface(grid);
    lod::Camera camera{.eye = {60, -200, 30}, .direction = {0, 1, -0.2}};
    const double middle = 60;
    for (const int kind : {0, 1, 2}) {
        CAPTURE(kind);
        lod::View hasty(surface), patient(surface);
        for (lod::View* view : {&hasty, &patient}) view->update(camera, {.pixel_error = 2});
        REQUIRE(patient.leaves().size() > 1'000);
        camera.eye.y += 100;
        std::uint32_t changes = 0;
        lod::Budget budget{.pixel_error = 2, .milliseconds = 0.01};
        for (int frame = 0; frame < 600; ++frame) {
            if (kind == 0) budget.pixel_error = frame % 2 == 0 ? 2 : 2.001;
            if (kind == 1) camera.vertical_fov = frame % 2 == 0 ? 1 : 1.0005;
            if (kind == 2)
                hasty.set_regions({{.center = {middle, -middle, 0}, .radius = 5 + 5e-3 * frame, .boost = 2}});
            const lod::Update update = hasty.update(camera, budget);
            changes += update.splits + update.merges;
        }
        if (kind == 2) patient.set_regions({{.center = {middle, -middle, 0}, .radius = 8, .boost = 2}});
        const lod::Update whole = patient.update(camera, {.pixel_error = 2});
        REQUIRE(whole.splits + whole.merges > 200);
        CHECK(changes > 0.9 * (whole.splits + whole.merges));
        CHECK(hasty.leaves().size() > 0.9 * static_cast<double>(patient.leaves().size()));
        CHECK(hasty.leaves().size() < 1.1 * static_cast<double>(patient.leaves().size()));
        // One update without a time limit, or a few with it, then reach the tolerance.
        const lod::Update last = hasty.update(camera, {.pixel_error = 3});
        CHECK(last.complete);
        CHECK(last.pixel_error == 3);
        int updates = 0;
        while (!hasty.update(camera, {.pixel_error = 4, .milliseconds = 1000}).complete) REQUIRE(++updates < 4);
        camera.vertical_fov = 1;
        camera.eye.y -= 100;
    }
}

TEST_CASE("lod: a view keeps within its bytes, over many roots and long boundaries, too") {
    const HeightGrid grid = rough(200, 200, 6);
    const lod::TerrainSurface terrain(grid);
    lod::View walked(terrain, {.max_leaves = 100'000, .max_bytes = 2'000'000});
    CHECK(walked.max_leaves() > 10'000);
    CHECK(walked.max_leaves() < 20'000);
    Wanderer wanderer(grid, 4);
    for (int i = 0; i < 100; ++i) {
        const lod::Update update = walked.update(wanderer.next(), {.pixel_error = 0.2});
        if (i == 0) CHECK(update.leaves > 0.99 * walked.max_leaves());
        REQUIRE(walked.memory_bytes() < 2'000'000);
    }
    for (const bool apart : {false, true}) {
        CAPTURE(apart);
        // A grid of squares, as one connected mesh or as separate squares.
        ControlMeshData data = test::grid(40);
        if (apart) {
            const std::vector<Vec3d> joined = std::exchange(data.positions, {});
            for (std::uint32_t c = 0; c < data.face_vertices.size(); ++c) {
                const Vec3d own(c / 4 % 40, c / 160, 0);
                data.positions.push_back(joined[data.face_vertices[c]] + 0.1 * own);
                data.face_vertices[c] = c;
            }
        }
        const ControlMesh mesh = ControlMesh::build(std::move(data));
        const lod::SubdivisionSurface surface(mesh, "catmull-clark",
                                              {.level = 3, .displacement = [](const lod::Place& at) {
                                                   return 0.05 * std::sin(1e4 * at.position.x + 3e4 * at.position.y);
                                               }});
        const lod::Camera camera{.eye = {20, 20, 30}, .direction = {0, 0, -1}, .up = {0, 1, 0}};
        for (const std::uint64_t bytes : {3'000'000u, 4'000'000u, 9'000'000u}) {
            CAPTURE(bytes);
            lod::View view(surface, {.max_leaves = 1'000'000, .max_bytes = bytes});
            const lod::Update update = view.update(camera, {.pixel_error = 0.01});
            CHECK(update.leaves > 0.8 * view.max_leaves());
            CHECK(view.memory_bytes() <= bytes);
            CHECK(view.memory_bytes() > 0.7 * static_cast<double>(bytes));
        }
    }
}

TEST_CASE("lod: with fewer triangles the smallest errors go first") {
    const HeightGrid grid = rough(200, 200, 6);
    const lod::TerrainSurface surface(grid);
    Wanderer wanderer(grid, 4);
    const lod::Camera camera = wanderer.next();
    lod::View view(surface);
    const std::uint32_t all = view.update(camera, {.pixel_error = 0.5}).leaves;
    REQUIRE(all > 8000);
    for (const std::uint32_t leaves : {all / 2, all / 8, all / 3, all / 20}) {
        CAPTURE(leaves);
        const lod::Update fewer = view.update(camera, {.pixel_error = 0.5, .leaves = leaves});
        lod::View fresh(surface);
        const lod::Update same = fresh.update(camera, {.pixel_error = 0.5, .leaves = leaves});
        CHECK(fewer.leaves <= leaves);
        CHECK(same.leaves <= leaves);
        CHECK(fewer.leaves > 0.95 * leaves);
        // Errors are sorted into buckets of a quarter of a doubling; a swap must gain two buckets.
        CHECK(fewer.pixel_error < 1.5 * same.pixel_error);
        CHECK(fewer.pixel_error > 0.66 * same.pixel_error);
    }
}

TEST_CASE("lod: where the eye is in the box of what cannot be split vertices are shown at places all the same") {
    const HeightGrid grid = rough(200, 200, 6);
    const lod::TerrainSurface surface(grid);
    lod::Camera camera = Wanderer(grid, 4).next();
    camera.eye = {100, -100, grid.at(100, 100) + 1e-3};
    for (const std::uint32_t leaves : {0u, 20u}) {
        lod::View view(surface);
        const lod::Update update = view.update(camera, {.pixel_error = 1, .leaves = leaves});
        CHECK(update.complete);
        CHECK(update.pixel_error == std::numeric_limits<double>::infinity());
        REQUIRE(update.morph_scale > 0);
        for (const lod::Vertex& vertex : view.vertices()) {
            const Vec3d at = lod::shown_position(vertex, camera.eye - view.origin(), update.morph_scale);
            CHECK(glm::length(at) < 1e6);
        }
    }
}

TEST_CASE("lod: out of sight errors count as much as is said, in sight all of them") {
    const HeightGrid grid = rough(200, 200, 9);
    const lod::TerrainSurface surface(grid);
    lod::Camera camera;
    camera.eye = {100, -100, 12};
    camera.direction = {0, 1, -0.3};
    camera.width = 800;
    camera.height = 600;
    const Sight sight(camera);
    std::set<std::array<double, 3>> coarser;
    for (const double weight : {0.0, 0.25, 1.0}) {
        CAPTURE(weight);
        lod::View view(surface, {.outside_weight = weight});
        REQUIRE(view.update(camera, {.pixel_error = 8}).pixel_error == 8);
        std::set<std::array<double, 3>> points;
        std::size_t seen = 0;
        for (const Vec3d& p : view.mesh().positions) {
            points.insert({p.x, p.y, p.z});
            const bool is_more = weight > 0 && !coarser.contains({p.x, p.y, p.z});
            if (is_more && sight.sees(p)) ++seen;
        }
        CHECK(seen == 0);
        CHECK(std::includes(points.begin(), points.end(), coarser.begin(), coarser.end()));
        CHECK(points.size() > 1.2 * coarser.size());
        coarser = std::move(points);
        CHECK(judged_pixels(view, grid, camera) <= 8 + 1e-3);
        double largest = 0;
        for (const Vec3d& direction : {Vec3d(1, 0, -0.3), {-1, 0, -0.3}, {0, -1, -0.3}}) {
            lod::Camera aside = camera;
            aside.direction = direction;
            largest = std::max(largest, judged_pixels(view, grid, aside));
        }
        if (weight > 0) CHECK(largest <= 8 / weight + 1e-3);
        if (weight < 1) CHECK(largest > (weight > 0 ? 4 / weight : 80));
    }
}

TEST_CASE("lod: triangles keep their slots, but for the last ones where a third is free") {
    const HeightGrid grid = rough(200, 200, 9);
    const lod::TerrainSurface surface(grid);
    lod::View view(surface);
    Wanderer wanderer(grid, 6);
    using Corners = std::array<std::array<float, 3>, 3>;
    std::map<Corners, std::size_t> before;
    std::size_t kept = 0, moved = 0;
    for (int frame = 0; frame < 60; ++frame) {
        const std::size_t slots = view.triangles().size();
        const lod::Update update = view.update(wanderer.next(), {.pixel_error = 20 * std::pow(1.2, frame % 10)});
        std::map<Corners, std::size_t> now;
        for (std::size_t i = 0; i < view.triangles().size(); ++i) {
            const lod::Triangle& t = view.triangles()[i];
            if (t != lod::Triangle{})
                now[{view.vertices()[t[0]].position, view.vertices()[t[1]].position, view.vertices()[t[2]].position}] =
                    i;
        }
        REQUIRE(now.size() == update.leaves);
        for (const auto& [corners, slot] : now) {
            const auto old = before.find(corners);
            if (old == before.end()) continue;
            ++(old->second == slot ? kept : moved);
            if (old->second == slot) continue;
            REQUIRE(old->second >= view.triangles().size());
            REQUIRE(slots + 2 * update.splits >= 1.5 * update.leaves);
        }
        before = std::move(now);
    }
    CHECK(kept > 20'000);
    CHECK(moved > 100);
}

TEST_CASE("lod: regions are finer, and buffers follow their origin") {
    const HeightGrid grid = rough(257, 257, 4);
    const lod::TerrainSurface surface(grid);
    lod::View view(surface);
    lod::Camera camera;
    camera.eye = {128, -128, 400};
    camera.direction = {0, 0, -1};
    const std::uint32_t plain = view.update(camera, {.pixel_error = 4}).leaves;
    view.set_regions({{.center = {60, -60, 0}, .radius = 10, .boost = 20}});
    const std::uint32_t boosted = view.update(camera, {.pixel_error = 4}).leaves;
    CHECK(boosted > plain + 50);
    view.set_regions({});
    CHECK(view.update(camera, {.pixel_error = 4}).leaves < boosted);

    Copied copied;
    view.set_origin({100, -100, 50});
    const lod::Update update = view.update(camera, {.pixel_error = 4});
    CHECK(update.splits + update.merges == 0);
    copied.take(view, update);
    for (const auto& t : used(view))
        for (const std::uint32_t v : t) {
            const Vec3d at = position(view, v);
            const auto column = static_cast<std::uint32_t>(std::lround(at.x)),
                       row = static_cast<std::uint32_t>(std::lround(-at.y));
            if (at.x == column && -at.y == row)
                REQUIRE(at.z == doctest::Approx(double{grid.at(column, row)}).epsilon(1e-5));
        }
}

TEST_CASE("lod: after a surface has thrown, the next updates make up for it") {
    /// Every hundredth call of bounds() throws.
    struct Unreliable final : lod::Surface {
        explicit Unreliable(const lod::Surface& all) : surface(all) {}
        const ControlMesh& roots() const override { return surface.roots(); }
        int max_depth() const override { return surface.max_depth(); }
        void places(std::span<const Site> sites, std::span<lod::Place> places) const override {
            surface.places(sites, places);
        }
        void bounds(std::span<const Site> sites, std::span<lod::DiamondBounds> bounds) const override {
            if (++calls % 100 == 0) throw std::runtime_error("the line is down");
            surface.bounds(sites, bounds);
        }
        const lod::Surface& surface;
        mutable int calls = 0;
    };
    const HeightGrid grid = rough(129, 129, 8);
    const lod::TerrainSurface surface(grid);
    const Unreliable unreliable(surface);
    lod::View view(unreliable), sure(surface);
    int failures = 0;
    for (Wanderer wanderer(grid, 4), same(grid, 4); failures < 100;) {
        const lod::Camera camera = wanderer.next();
        sure.update(same.next());
        for (bool is_done = false; !is_done;) {
            try {
                view.update(camera, {.milliseconds = 1e6});
                is_done = true;
            } catch (const std::runtime_error&) {
                ++failures;
            }
        }
        REQUIRE(judged_pixels(view, grid, camera) <= 1 + 1e-3);
    }
    CHECK(view.leaf_count() < 1.1 * sure.leaf_count());
}

TEST_CASE("lod: views of two threads on one surface are what they are by themselves") {
    const HeightGrid grid = rough(257, 129, 8);
    const lod::TerrainSurface surface(grid, with_thread_count(2));
    const auto walk = [&](unsigned seed) {
        lod::View view(surface, {.max_leaves = 5'000});
        Wanderer wanderer(grid, seed);
        for (int i = 0; i < 400; ++i) view.update(wanderer.next(), {.pixel_error = 2});
        auto leaves = view.leaves();
        std::sort(leaves.begin(), leaves.end());
        return leaves;
    };
    std::array<std::vector<std::array<Site, 3>>, 2> together;
    std::thread other([&] { together[1] = walk(2); });
    together[0] = walk(1);
    other.join();
    CHECK(together[0] == walk(1));
    CHECK(together[1] == walk(2));
}

TEST_CASE("lod: in ten thousand frames memory does not grow, nor where tiles come and go [slow]") {
    const HeightGrid grid = rough(129, 129, 8);
    const ScratchDir dir;
    lod::write_tiles(*make_height_source(grid), dir / "t.tiles", {.side = 16});
    const lod::TerrainSurface in_memory(grid);
    const lod::TiledTerrain in_tiles(dir / "t.tiles", {.cache_bytes = 64 << 10});
    for (const lod::Surface* surface : std::initializer_list<const lod::Surface*>{&in_memory, &in_tiles}) {
        lod::View view(*surface, {.max_leaves = 3'000});
        Wanderer wanderer(grid, 3);
        std::uint64_t early = 0, early_heap = 0, changes = 0;
        for (int i = 0; i < 10'000; ++i) {
            const lod::Camera camera = wanderer.next();
            if (i % 50 == 0) view.set_regions({{.center = camera.eye, .radius = 5, .boost = 2}});
            for (bool is_seen = false; !is_seen;) {
                const std::uint64_t revision = in_tiles.revision();
                const lod::Update update = view.update(camera, {.pixel_error = 2});
                changes += update.splits + update.merges;
                is_seen = i % 10 != 0 || update.waiting == 0;  // now and then all tiles of a place
                if (!is_seen) in_tiles.wait(revision);
            }
            if (i == 1'000) early = view.memory_bytes(), early_heap = heap_bytes();
        }
        CHECK(changes > 500'000);
        CHECK(view.memory_bytes() < 1.05 * static_cast<double>(early));
        CHECK(heap_bytes() < early_heap + 50'000);
    }
    CHECK(in_tiles.statistics().loads > 1'000);
}

TEST_CASE(
    "lod: a globe of the earth's size is closed, and details of centimetres do not jitter where one walks on it") {
    constexpr double k_radius = 6'371'000;
    const lod::ProceduralHeights heights = lod::fractal_heights(0.02, 5, 3);
    const auto globe = lod::ProceduralSurface::ball(k_radius, 0.012, heights);
    lod::View view(globe, {.max_leaves = 100'000});
    const Vec3d out = glm::normalize(Vec3d(0.3, -0.8, 0.52)), ahead = glm::normalize(glm::cross(out, Vec3d(0, 0, 1)));
    std::map<std::array<double, 3>, Vec2d> before;  // errors of single precision in the last picture, by position
    double jitter = 0, lowest = 1, highest = -1;
    std::size_t followed = 0;
    for (int frame = 0; frame < 52; ++frame) {
        // From two radii above the ground down to the eyes of a walking person, who takes steps of three centimetres.
        const double above = frame < 40 ? 2 * k_radius * std::pow(0.68, frame) : 1.8;
        lod::Camera camera;
        camera.eye = out * (k_radius + above) + ahead * (frame < 40 ? 0.0 : 0.03 * (frame - 40));
        camera.direction = frame < 40 ? -out : ahead - 0.2 * out;
        camera.up = frame < 40 ? ahead : out;
        camera.width = 640, camera.height = 480;
        if (frame % 10 == 0) view.set_origin(camera.eye);
        const lod::Update update = view.update(camera, {.pixel_error = 0.5});
        REQUIRE(update.pixel_error == 0.5);
        const auto triangles = used(view);
        const Sight sight(camera);
        if (frame % 6 == 0) {
            const SurfaceTopology whole = topology(triangles);
            REQUIRE(whole.fault.empty());
            REQUIRE(whole.euler == 2);
            for (const auto& [i, j, k] : triangles) {
                const Vec3d a = position(view, i), b = position(view, j), c = position(view, k);
                const Vec3d normal = glm::normalize(glm::cross(b - a, c - a));
                for (const Vec3d& middle : {(a + b + c) / 3.0, (a + b) / 2.0, (b + c) / 2.0, (c + a) / 2.0}) {
                    const Vec3d up = glm::normalize(middle), ground = (k_radius + heights.height(k_radius * up)) * up;
                    if (sight.sees(ground))
                        REQUIRE(std::abs(glm::dot(ground - a, normal)) * sight.pixels /
                                    glm::length(ground - camera.eye) <=
                                0.55);
                }
            }
        }
        if (frame < 40) continue;
        const TriangleMesh mesh = view.mesh();
        std::map<std::array<double, 3>, Vec2d> now;
        const auto in_picture = [&]<class Number>(const glm::vec<3, Number>& p) {
            using Vec = glm::vec<3, Number>;
            return Vec2d(glm::dot(p, Vec(sight.right)), glm::dot(p, Vec(sight.up))) *
                   (sight.pixels / glm::dot(p, Vec(sight.forward)));
        };
        for (std::size_t i = 0; i < 3 * triangles.size(); ++i) {
            // Both are in the order of their slots.
            const auto& [x, y, z] = view.vertices()[triangles[i / 3][i % 3]].position;
            const Vec3d& exact = mesh.positions[mesh.triangles[i / 3][i % 3]];
            const std::array<double, 3> key{exact.x, exact.y, exact.z};
            if (!sight.sees(exact) || now.contains(key)) continue;
            // As a graphics card computes it from the buffer, in floats; and in doubles.
            now[key] =
                in_picture(glm::vec3(x, y, z) - glm::vec3(camera.eye - view.origin())) - in_picture(exact - camera.eye);
            if (const auto old = before.find(key); old != before.end()) {
                ++followed;
                jitter = std::max(jitter, glm::length(now[key] - old->second));
            }
            const double height = glm::length(exact) - k_radius;
            REQUIRE(std::abs(height - heights.height(k_radius * glm::normalize(exact))) < 1e-6);
            if (glm::length(exact - camera.eye) > 10) continue;
            lowest = std::min(lowest, height);
            highest = std::max(highest, height);
        }
        before = std::move(now);
    }
    CHECK(followed > 100'000);
    CHECK(highest - lowest > 0.04);  // within ten metres
    CHECK(jitter < 1e-3);
}

TEST_CASE("lod: short rays through samples meet the ground of a large terrain, wherever it lies") {
    std::mt19937 random(3);
    const auto any = [&](double low, double high) { return std::uniform_real_distribution(low, high)(random); };
    for (const double offset : {0.0, 5e6}) {
        HeightGrid grid;
        grid.columns = 1025, grid.rows = 700, grid.origin = {offset, -offset};
        grid.heights.assign(std::size_t{1025} * 700, 0.0f);
        const lod::TerrainSurface surface(grid);
        for (int i = 0; i < 3000; ++i) {
            const Vec3d sample(offset + std::floor(any(1, 1023)), -offset - std::floor(any(1, 698)), 0);
            const Vec3d way(any(-0.5, 0.5), any(-0.5, 0.5), any(-1, -0.01));
            const double length = std::exp(any(-7, 9));
            const auto hit = surface.hit(sample - length * way, way);
            REQUIRE(hit);
            REQUIRE(hit->t == doctest::Approx(length).epsilon(1e-6));
            REQUIRE(surface.hit(sample - length * way, way, hit->t));
            const auto far = surface.hit(sample - length * way, 5e99 * way);
            REQUIRE(far);
            REQUIRE(5e99 * far->t == doctest::Approx(length).epsilon(1e-6));
        }
    }
}

TEST_CASE("lod: rays straight down meet a flat terrain at each sample, however far from the origin") {
    HeightGrid grid = grid_of(65, 65, [](double, double) { return 0; });
    grid.spacing = {0.3, 0.3};
    grid.origin = {2e7, -2e7};
    const lod::TerrainSurface surface(grid);
    for (int i = 0; i < 65 * 65; ++i) {
        const Vec2d place = grid.origin + grid.spacing * Vec2d(i % 65, -(i / 65));
        REQUIRE(surface.hit({place, 1e4}, {0, 0, -1}));
    }
}

TEST_CASE("lod: bad input [bad-input]") {
    const HeightGrid grid = rough(33, 33, 1);
    CHECK_THROWS_AS(lod::TerrainSurface(HeightGrid{}), Error);
    HeightGrid hole = grid;
    hole.heights[40] = std::numeric_limits<float>::quiet_NaN();
    CHECK_THROWS_WITH_AS(lod::TerrainSurface{hole}, doctest::Contains("column 7, row 1 is missing"), Error);

    const lod::TerrainSurface surface(grid);
    CHECK_THROWS_AS(lod::View(surface, {.outside_weight = 2}), Error);
    CHECK_THROWS_AS(lod::View(surface, {.hysteresis = 1}), Error);
    CHECK_THROWS_AS(lod::View(surface, {.max_ranges = 0}), Error);
    CHECK_THROWS_WITH_AS(lod::View(surface, {.max_bytes = 10}), doctest::Contains("too few"), Error);

    lod::View view(surface);
    const auto with = [](auto change) {
        lod::Camera camera;
        camera.eye = {16, -40, 10};
        change(camera);
        return camera;
    };
    view.update(with([](lod::Camera&) {}));
    const auto before = view.leaves();
    const double nan = std::numeric_limits<double>::quiet_NaN();
    CHECK_THROWS_AS(view.update(with([&](lod::Camera& c) { c.eye.x = nan; })), Error);
    CHECK_THROWS_AS(view.update(with([](lod::Camera& c) { c.direction = {0, 0, 0}; })), Error);
    CHECK_THROWS_AS(view.update(with([](lod::Camera& c) { c.vertical_fov = 4; })), Error);
    CHECK_THROWS_AS(view.update(with([](lod::Camera& c) { c.height = 0; })), Error);
    CHECK_THROWS_AS(view.update(with([](lod::Camera&) {}), {.pixel_error = 0}), Error);
    CHECK_THROWS_AS(view.update(with([](lod::Camera&) {}), {.milliseconds = -1}), Error);
    CHECK_THROWS_AS(view.set_regions({{.boost = 0.5}}), Error);
    CHECK_THROWS_AS(view.set_origin({nan, 0, 0}), Error);
    CHECK_THROWS_AS(view.set_origin({1e300, 0, 0}), Error);
    CHECK_THROWS_AS(view.update(with([&](lod::Camera& c) { c.up.y = nan; })), Error);
    CHECK_THROWS_AS(view.update(with([&](lod::Camera& c) { c.vertical_fov = nan; })), Error);
    CHECK(view.leaves() == before);

    CHECK_THROWS_WITH_AS(view.update(with([](lod::Camera& c) { c.eye.x = 1e100; })), doctest::Contains("farthest"),
                         Error);
    CHECK(view.update(with([](lod::Camera& c) { c.direction = {0, 1e-200, 0}; })).splits == 0);
    // After a camera very far away, and back, the view has at least the leaves of a new view.
    view.update(with([](lod::Camera& c) { c.eye.x = 1e50; }));
    for (int i = 100; i >= 0; --i) view.update(with([&](lod::Camera& c) { c.eye.y -= i; }));
    lod::View fresh(surface);
    fresh.update(with([](lod::Camera&) {}));
    CHECK(view.leaf_count() >= fresh.leaf_count());
    CHECK(fresh.leaf_count() > 200);

    // Extreme but valid cameras: below the ground, looking along the up-axis, with everything behind. Then no budget.
    for (const Vec3d& eye : {Vec3d(16, -16, -500), Vec3d(16, -16, double{grid.at(16, 16)}), Vec3d(1e12, 1e12, 1e12)})
        for (const Vec3d& direction : {Vec3d(0, 0, 1), Vec3d(0, -1, 0)}) {
            const lod::Update update =
                view.update(with([&](lod::Camera& c) { c.eye = eye, c.direction = direction; }), {.leaves = 1000});
            CHECK(update.complete);
            CHECK(update.leaves <= 1000);
        }
    CHECK(view.update(with([](lod::Camera&) {}), {.leaves = 0}).leaves == 4 * surface.roots().face_count());
    lod::ProceduralHeights heights = lod::fractal_heights(5, 60, 3);
    heights.height = [&](const Vec3d& place) { return place.x > 20 ? nan : 0.0; };
    const auto partly = lod::ProceduralSurface::plane(100, 1, heights);
    CHECK_THROWS_WITH_AS(lod::View(partly).update(with([](lod::Camera&) {})), doctest::Contains("height of nan at"),
                         Error);
    CHECK_THROWS_WITH_AS(partly.hit({30, 0, 9}, {0, 0, -1}), doctest::Contains("heights are finite"), Error);
    HeightGrid flat = grid;
    std::fill(flat.heights.begin(), flat.heights.end(), 0.0f);
    const lod::TerrainSurface plane(flat);
    CHECK(lod::View(plane).update(with([](lod::Camera&) {})).splits == 0);
}

TEST_CASE("lod: up vectors and boosts of any size, steps as small as the camera's last digit [bad-input]") {
    const lod::TerrainSurface terrain(rough(129, 129, 2));
    lod::Camera camera{.eye = {0, -64, 3}, .direction = {1, 0, 0}, .vertical_fov = 0.3, .width = 3000, .height = 300};
    const auto leaves = [&](double length) {
        camera.up = {0, 0, length};
        return lod::View(terrain, {.outside_weight = 0}).update(camera).leaves;
    };
    CHECK(leaves(1e-170) == leaves(1));
    CHECK(leaves(1e160) == leaves(1));

    lod::View boosted(terrain, {.outside_weight = 0});
    boosted.set_regions({{.center = {64, -64, 0}, .radius = 20, .boost = 1e306}});
    camera = {.eye = {64, 40, 20}, .direction = {0, 1, 0}};
    boosted.update(camera);
    camera.direction = {0, -1, -0.2};
    CHECK(boosted.update(camera).splits > 500);

    // Far away sums of the camera's motion lose their last digits.
    const double radius = 6.4e6;
    const auto globe = lod::ProceduralSurface::ball(radius, 0.05, lod::fractal_heights(1, 20, 8));
    lod::View view(globe, {.max_leaves = 20'000});
    const lod::Camera near{.eye = {radius + 3, 0, 0}, .direction = {-0.1, 1, 0}, .up = {1, 0, 0}};
    view.update({.eye = {1e14, 0, 0}, .direction = {-1, 0, 0}});
    camera = near;
    view.update(camera);
    std::uint32_t changes = 0;
    for (int i = 0; i < 300; ++i) {
        camera.eye.y += 0.006;
        const lod::Update update = view.update(camera);
        changes += update.splits + update.merges;
    }
    CHECK(changes > 20);
}

TEST_CASE("lod: a procedural plane asks for heights within its square alone") {
    double farthest = 0;
    lod::ProceduralHeights heights = lod::fractal_heights(1, 20, 3);
    const auto inner = heights.height;
    heights.height = [&](const Vec3d& place) {
        farthest = std::max({farthest, std::abs(place.x), std::abs(place.y)});
        return inner(place);
    };
    const auto plane = lod::ProceduralSurface::plane(100, 0.5, heights);
    lod::View(plane).update({.eye = {0, 0, 5}, .direction = {1, 0, -0.3}});
    CHECK(farthest == 50);
}
