#include "../../hier/trees/triangle_cell.hpp"
#include "../kit/triangle_test_mesh.hpp"

#include <doctest/doctest.h>

#include <set>

using namespace tetrakis;

namespace {

constexpr std::uint64_t k_seeds = 24;

// All addresses of a point at its own level, by crossing every side it lies on until nothing new turns up.
std::set<Site> all_addresses(const ControlMesh& mesh, const Site& site) {
    std::set<Site> found{site};
    std::vector<Site> open{site};
    while (!open.empty()) {
        const Site s = open.back();
        open.pop_back();
        const std::array<bool, 3> is_on = {s.at.y == 0, s.at.x + s.at.y == 1u << s.level, s.at.x == 0};
        for (int side = 0; side < 3; ++side) {
            if (!is_on[side]) continue;
            const auto there = cross_triangle_side(mesh, side, s.level, {s.root, s.at.x, s.at.y});
            if (!there) continue;
            REQUIRE(there->x >= 0);
            REQUIRE(there->y >= 0);
            const Site next{
                there->root, {static_cast<std::uint32_t>(there->x), static_cast<std::uint32_t>(there->y)}, s.level};
            if (found.insert(next).second) open.push_back(next);
        }
    }
    return found;
}

Site reduced(Site s) {
    while (s.level > 0 && s.at.x % 2 == 0 && s.at.y % 2 == 0)
        s = {s.root, {s.at.x / 2, s.at.y / 2}, static_cast<std::uint8_t>(s.level - 1)};
    return s;
}

}  // namespace

TEST_SUITE_BEGIN("hier");

TEST_CASE("all addresses of a point of a triangle mesh have the same canonical site, the smallest of them") {
    for (const std::uint64_t seed : test::seeds(k_seeds)) {
        CAPTURE(seed);
        const ControlMesh mesh = test::random_triangle_mesh(seed);
        const TriangleSites sites(mesh);
        for (std::uint8_t level : {0, 1, 2, 3}) {
            const std::uint32_t n = 1u << level;
            for (std::uint32_t f = 0; f < mesh.face_count(); ++f)
                for (std::uint32_t x = 0; x <= n; ++x)
                    for (std::uint32_t y = 0; x + y <= n; ++y) {
                        const Site site{mesh.face_halfedge(FaceId(f)), {x, y}, level};
                        const std::set<Site> addresses = all_addresses(mesh, reduced(site));
                        REQUIRE(sites.canonical(site) == *addresses.begin());
                        REQUIRE(canonical_triangle_site(mesh, site) == *addresses.begin());
                    }
        }
    }
}

TEST_SUITE_END();
