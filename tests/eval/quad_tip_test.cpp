#include "../../eval/surface/quad_tip.hpp"

#include "../kit/random_mesh.hpp"

#include <doctest/doctest.h>

#include <utility>

using namespace tetrakis;
using namespace tetrakis::detail;

namespace {

QuadStar random_star(int valence, test::Random& random) {
    QuadStar star;
    star.valence = valence;
    star.points.resize(QuadStar::point_count(valence));
    for (std::size_t i = 0; i < star.points.size(); ++i)
        star.points[i] = {random.uniform(), random.uniform(), random.uniform()};
    star.find_limit();
    return star;
}

}  // namespace

TEST_SUITE_BEGIN("eval");

TEST_CASE("[inv9] the first-order part of a star is within its bound of the surface, on its rays and in its reach") {
    for (int valence = 3; valence <= 12; ++valence) {
        CAPTURE(valence);
        test::Random random(static_cast<std::uint64_t>(valence));
        QuadStar star = random_star(valence, random);
        // The map's own surface goes along with it: its points are (a, b, 0).
        const QuadCharacteristic* map = QuadCharacteristic::of(valence);
        REQUIRE(map);
        QuadStar flat = random_star(valence, random);
        for (std::size_t i = 0; i < flat.points.size(); ++i) flat.points[i] = {map->at[i].x, map->at[i].y, 0};
        flat.find_limit();
        QuadTip tip = QuadTip::of(star);
        const double first_rest = tip.rest;
        for (int level = 0; level < 6; ++level) {
            QuadStar next, flat_next;
            std::array<Net16, 3> nets, flat_nets;
            subdivide(star, next, nets);
            subdivide(flat, flat_next, flat_nets);
            const double scale = std::pow(map->lambda, -level);
            for (std::size_t k = 0; k < 3; ++k)
                for (int i = 0; i <= 4; ++i)
                    for (int j = 0; j <= 4; ++j) {
                        const Vec3d s = regular_position(nets[k], {}, 0.25 * i, 0.25 * j);
                        const Vec3d at = scale * regular_position(flat_nets[k], {}, 0.25 * i, 0.25 * j);
                        CHECK(at.x >= -1e-9);
                        CHECK(at.y >= -1e-9);
                        CHECK(std::max(at.x, at.y) <= map->reach + 1e-9);
                        if (k == 0 && j == 0) CHECK(std::abs(at.y) < 1e-9);         // the side x
                        if (k == 2 && i == 0) CHECK(std::abs(at.x) < 1e-9);         // the side y
                        if (k == 1 && i == j) CHECK(std::abs(at.x - at.y) < 1e-9);  // the diagonal
                        const Vec3d linear = star.limit + at.x * tip.d0 + at.y * tip.d1;
                        CHECK(glm::length(s - linear) <= tip.rest + 1e-9);
                    }
            tip = tip.child(next);
            star = std::move(next);
            flat = std::move(flat_next);
        }
        // What is left over shrinks faster than the first-order part.
        CHECK(tip.rest < 0.7 * std::pow(map->lambda, 6) * first_rest);
    }
    CHECK(QuadCharacteristic::of(2) == nullptr);
}

TEST_CASE("strips beside a crease are the cell") {
    test::Random random(7);
    for (const float sharpness : {0.3f, 1.0f, 2.5f, 5.0f, 7.9f})
        for (std::int8_t side = 0; side < 4; ++side) {
            CAPTURE(sharpness);
            CAPTURE(int(side));
            Net16 net;
            for (auto& row : net.c)
                for (double& c : row) c = random.uniform();
            const SideCrease crease{side, sharpness};
            std::array<CreaseStrip, 3> strips;
            const int count = crease_strips(net, crease, strips);
            REQUIRE(count >= 1);
            double reached = 0;
            for (int s = 0; s < count; ++s) {
                const CreaseStrip& strip = strips[static_cast<std::size_t>(s)];
                CHECK(strip.begin == reached);
                reached = strip.end;
                for (int i = 0; i <= 4; ++i)
                    for (int j = 0; j <= 4; ++j) {
                        const double distance = strip.begin + (strip.end - strip.begin) * i / 4, along = 0.25 * j;
                        const bool across_y = side == 0 || side == 2, far = side == 1 || side == 2;
                        const double t = far ? 1 - distance : distance;
                        const double own = (distance - strip.origin) / strip.span, u = far ? 1 - own : own;
                        const Vec3d expected =
                            regular_position(net, crease, across_y ? along : t, across_y ? t : along);
                        const Vec3d found = regular_position(strip.net, {}, across_y ? along : u, across_y ? u : along);
                        CHECK(glm::length(found - expected) < 1e-12);
                    }
            }
            CHECK(reached == 1.0);
        }
}
