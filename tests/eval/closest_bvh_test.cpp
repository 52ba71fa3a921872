#include "../../eval/distance/closest_bvh.hpp"

#include "../kit/input_helpers.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <limits>
#include <random>
#include <thread>
#include <vector>

using namespace tetrakis;

TEST_SUITE_BEGIN("eval");

namespace {

double distance_to_box(const Vec3d& p, const Box3d& box) {
    return glm::length(glm::max(glm::max(box.lower - p, p - box.upper), Vec3d(0)));
}

// Boxes of very different sizes around `origin`, `size` being the whole's extent.
std::vector<Box3d> random_boxes(std::mt19937_64& random, std::size_t count, const Vec3d& origin, double size) {
    std::uniform_real_distribution<double> unit(0, 1);
    std::vector<Box3d> boxes(count);
    for (Box3d& box : boxes) {
        const Vec3d lower = origin + size * Vec3d(unit(random), unit(random), unit(random));
        const double side = size * std::pow(10.0, -6 * unit(random)) * 0.3;
        box.add(lower);
        box.add(lower + side * Vec3d(unit(random), unit(random), unit(random)));
    }
    return boxes;
}

ClosestBvh over(const std::vector<Box3d>& boxes, const RunContext& context = {}) {
    return {static_cast<std::uint32_t>(boxes.size()), [&](std::uint32_t i) { return boxes[i]; }, context};
}

}  // namespace

TEST_CASE("the nearest primitive is brute force's, wherever and however large the model is") {
    std::mt19937_64 random(20240117);
    std::uniform_real_distribution<double> unit(-1, 2);
    for (const double size : {1.0, 1e-30, 1e30})
        for (const double offset : {0.0, 1e4}) {
            CAPTURE(size);
            CAPTURE(offset);
            const Vec3d origin = size * offset * Vec3d(1, -1, 0.5);
            std::vector<Box3d> boxes = random_boxes(random, 300, origin, size);
            boxes[7] = boxes[200] = boxes[100];  // equals: the lowest number wins
            boxes[50] = Box3d{};                 // empty: never found
            const ClosestBvh bvh = over(boxes);
            for (int i = 0; i < 400; ++i) {
                const double far = i % 10 == 9 ? 1e25 : i % 10 == 8 ? 1e6 : 1;
                const Vec3d p = i % 7 == 0 ? boxes[100].centre()
                                           : origin + far * size * Vec3d(unit(random), unit(random), unit(random));
                std::uint32_t nearest = ClosestBvh::k_none;
                double best = std::numeric_limits<double>::infinity();
                for (std::uint32_t b = 0; b < boxes.size(); ++b) {
                    if (boxes[b].empty()) continue;
                    const double d = distance_to_box(p, boxes[b]);
                    if (d < best) best = d, nearest = b;
                }
                const auto exact = [&](std::uint32_t b, double) {
                    CHECK(b != 50);
                    return distance_to_box(p, boxes[b]);
                };
                const auto hit = bvh.query(p, std::numeric_limits<double>::infinity(), exact);
                REQUIRE(hit.primitive == nearest);
                REQUIRE(hit.distance == best);
                REQUIRE(bvh.query(p, best, exact).primitive == nearest);  // the bound is inclusive
                if (best > 0) REQUIRE_FALSE(bvh.query(p, best * (1 - 1e-12), exact).found());
            }
        }
}

TEST_CASE("building boxes reports to the calling thread alone and can be cancelled at every report") {
    std::mt19937_64 random(9);
    const auto boxes = random_boxes(random, 50000, Vec3d(0), 1);
    const auto caller = std::this_thread::get_id();
    int reports = 0, last = std::numeric_limits<int>::max();
    bool elsewhere = false;
    RunContext context;
    context.threads = 2;
    context.progress = [&](std::string_view stage, double fraction) {
        elsewhere |= std::this_thread::get_id() != caller;
        CHECK(stage == "build");
        CHECK(fraction >= 0);
        CHECK(fraction <= 1);
        return ++reports < last;
    };
    over(boxes, context);
    CHECK(!elsewhere);
    const int all = reports;
    CHECK(all > 50000 / 4096);
    for (last = 1; last <= 50000 / 4096 + 1; last += 4) {
        reports = 0;
        CHECK(test::error_of([&] { over(boxes, context); }).code() == ErrorCode::cancelled);
    }
}

TEST_SUITE_END();
