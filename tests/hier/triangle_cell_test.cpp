#include "../../hier/forest/triangle_cell.hpp"
#include "../kit/triangle_test_mesh.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <map>
#include <random>
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

TEST_CASE("crossing a side of a triangle root and coming back is the identity, also beyond the side") {
    for (const std::uint64_t seed : test::seeds(k_seeds)) {
        CAPTURE(seed);
        const ControlMesh mesh = test::random_triangle_mesh(seed);
        std::mt19937 random(static_cast<std::uint32_t>(seed));
        for (std::uint32_t h = 0; h < mesh.halfedge_count(); ++h) {
            const HalfedgeId root(h - h % 3), twin = mesh.twin(HalfedgeId(h));
            const int side = static_cast<int>(h % 3), level = static_cast<int>(random() % 31);
            const std::int64_t n = std::int64_t{1} << level;
            const TrianglePoint here{root, static_cast<std::int64_t>(random() % 64) - 32,
                                     static_cast<std::int64_t>(random() % 64) - 32};
            const auto there = cross_triangle_side(mesh, side, level, here);
            REQUIRE(there.has_value() == twin.valid());
            if (!there) continue;
            CHECK(there->root == mesh.face_halfedge(mesh.face(twin)));
            const auto back = cross_triangle_side(mesh, static_cast<int>(twin.value % 3), level, *there);
            REQUIRE(back.has_value());
            CHECK(*back == here);
            // The side's ends are the same control vertices on both sides.
            const std::array<TrianglePoint, 3> corner = {TrianglePoint{root, 0, 0}, {root, n, 0}, {root, 0, n}};
            const TrianglePoint start = *cross_triangle_side(mesh, side, level, corner[side]);
            const std::uint32_t k = start.x != 0 ? 1 : start.y != 0 ? 2 : 0;
            CHECK(mesh.origin(HalfedgeId(start.root.value + k)) == mesh.origin(HalfedgeId(h)));
        }
    }
}

TEST_CASE("walking around an interior control vertex through triangle roots comes home") {
    for (const std::uint64_t seed : test::seeds(k_seeds)) {
        CAPTURE(seed);
        const ControlMesh mesh = test::random_triangle_mesh(seed);
        for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v) {
            if (mesh.is_isolated(VertexId(v)) || mesh.is_boundary(VertexId(v))) continue;
            const int level = 5;
            HalfedgeId h = mesh.vertex_halfedge(VertexId(v));
            const HalfedgeId start(h.value - h.value % 3);
            // In a plane six triangles meet at a vertex: continued around one of valence n, the frame turns by n - 6
            // sixths, so a point comes home after 6 rounds; the vertex itself after one.
            TrianglePoint p{start, 0, 0}, centre{start, 0, 0};
            const std::int64_t n = std::int64_t{1} << level;
            if (h.value % 3 == 1) centre.x = n;
            if (h.value % 3 == 2) centre.y = n;
            p.x = 7, p.y = 5;
            const TrianglePoint p_start = p, centre_start = centre;
            for (int round = 0; round < 6; ++round) {
                for (std::uint32_t i = 0; i < mesh.valence(VertexId(v)); ++i) {
                    const HalfedgeId leaving = mesh.prev(h);
                    p = *cross_triangle_side(mesh, static_cast<int>(leaving.value % 3), level, p);
                    centre = *cross_triangle_side(mesh, static_cast<int>(leaving.value % 3), level, centre);
                    h = mesh.ccw_outgoing(h);
                    REQUIRE(p.root == mesh.face_halfedge(mesh.face(h)));
                    REQUIRE(centre.root == p.root);
                }
                CHECK(centre == centre_start);
            }
            CHECK(p == p_start);
        }
    }
}

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
