#include "../kit/point_sets.hpp"
#include "../kit/random_mesh.hpp"

#include "../../hier/base/error.hpp"
#include "../../hier/base/parallel.hpp"
#include "../../hier/mesh/obj_reader.hpp"
#include "../../hier/mesh/triangulate.hpp"
#include "../../refine/adaptive/closure.hpp"
#include "../../refine/adaptive/level_walk.hpp"
#include "../../refine/adaptive/partial_levels.hpp"
#include "../../refine/rules/mesh_part.hpp"
#include "../../refine/rules/rule_limit.hpp"
#include "../../refine/rules/rule_refiner.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <string>
#include <tuple>

using namespace tetrakis;

namespace {

ControlMesh mesh_for(const SchemeInfo& scheme, std::uint64_t seed) {
    test::RandomMeshOptions options = test::random_options(seed);
    if (scheme.refinement == Refinement::vertex_split) options.edge_vertices = 0;
    options.triangles_only = scheme.family == MeshFamily::triangles;
    return test::random_mesh(seed, options);
}

ControlMesh cube() {
    return ControlMesh::build(read_obj(std::filesystem::path(TETRAKIS_SOURCE_DIR) / "data" / "cube.obj"));
}

/// The whole mesh at every level, by the scheme's own rules, and the vertices of addresses found on it.
struct Whole {
    std::vector<RuleMesh> mesh;
    std::vector<RuleStep> step;
    std::vector<std::vector<Vec3d>> points;

    Whole(const ControlMesh& control, const SchemeInfo& scheme, const RuleOptions& rules, int levels) {
        mesh.push_back(rule_mesh(control));
        points.emplace_back(control.positions().begin(), control.positions().end());
        for (int i = 0; i < levels; ++i) {
            step.push_back(scheme.step(mesh.back(), rules));
            mesh.push_back(step.back().mesh);
            std::vector<Vec3d> finer(step.back().stencils.row_count());
            step.back().stencils.apply<Vec3d>(points.back(), finer);
            points.push_back(std::move(finer));
        }
    }
};

bool same(const Vec3d& a, const Vec3d& b) { return std::memcmp(&a, &b, sizeof a) == 0; }

/// Corner (dx, dy) of a cell of a quad lattice, from the whole mesh: quadrants by their bits from the top.
int quad_vertex(const Whole& whole, std::uint32_t root, std::uint32_t x, std::uint32_t y, int level, int dx, int dy) {
    detail::CellFrame frame{whole.step[0].child_halfedge[root], 0};
    for (int l = 0; l < level; ++l) {
        const int bit = level - 1 - l, right = x >> bit & 1, up = y >> bit & 1;
        frame = detail::quad_child(whole.mesh[l + 1], whole.step[l + 1], frame, up ? 3 - right : right);
    }
    return whole.mesh[level + 1].origin(detail::face_corner(whole.mesh[level + 1], frame, dy ? 3 - dx : dx, 4));
}

}  // namespace

TEST_SUITE_BEGIN("refine");

TEST_CASE("[inv1] partial levels: quads, any vertices of a level bit for bit") {
    constexpr int k_level = 2;
    for (const char* name : {"catmull-clark", "kobbelt", "bilinear", "4-8", "averaging"})
        for (const std::uint64_t seed : test::seeds(4)) {
            CAPTURE(name);
            CAPTURE(seed);
            const SchemeInfo& scheme = *find_scheme(name);
            RuleOptions rules;
            rules.averaging_steps = 4;
            const ControlMesh mesh = mesh_for(scheme, seed);
            const Whole whole(mesh, scheme, rules, k_level + 1);
            const PartialLevels partial(mesh, scheme, rules);
            test::Random random(seed);
            std::vector<Site> sites;
            std::vector<int> vertices;
            for (std::uint32_t h = 0; h < mesh.halfedge_count(); ++h) {
                if (random.chance(0.7)) continue;
                const std::uint32_t x = random.below(1u << k_level), y = random.below(1u << k_level);
                for (std::uint32_t d = 0; d < 4; ++d) {
                    const std::uint32_t dx = d & 1, dy = d >> 1;
                    sites.push_back({HalfedgeId(h), {x + dx, y + dy}, k_level});
                    vertices.push_back(quad_vertex(whole, h, x, y, k_level, int(dx), int(dy)));
                }
            }
            std::vector<Vec3d> got(sites.size());
            partial.control_positions(sites, got);
            int wrong = 0;
            for (std::size_t i = 0; i < sites.size(); ++i) wrong += !same(got[i], whole.points.back()[vertices[i]]);
            CHECK(wrong == 0);
        }
}

TEST_CASE("[inv1] partial levels: triangles, all vertices of a level bit for bit") {
    for (const char* name : {"loop", "tuned-loop", "butterfly", "modified-butterfly", "midpoint"})
        for (const std::uint64_t seed : test::seeds(3)) {
            CAPTURE(name);
            CAPTURE(seed);
            const SchemeInfo& scheme = *find_scheme(name);
            const ControlMesh mesh = mesh_for(scheme, seed);
            const Whole whole(mesh, scheme, {}, 2);
            const PartialLevels partial(mesh, scheme);
            std::vector<Site> sites;
            for (std::uint32_t h = 0; h < mesh.halfedge_count(); h += 3)
                for (std::uint32_t y = 0; y <= 4; ++y)
                    for (std::uint32_t x = 0; x + y <= 4; ++x) sites.push_back({HalfedgeId(h), {x, y}, 2});
            std::vector<Vec3d> got(sites.size()), expected = whole.points.back();
            partial.control_positions(sites, got);
            // Neighbours agree in the vertices that they share: without repetitions the two are the same set.
            const auto normalised = [](std::vector<Vec3d>& points) {
                const auto key = [](const Vec3d& p) { return std::tuple(p.x, p.y, p.z); };
                std::sort(points.begin(), points.end(), [&](auto& a, auto& b) { return key(a) < key(b); });
                points.erase(std::unique(points.begin(), points.end()), points.end());
            };
            normalised(got);
            normalised(expected);
            REQUIRE(got.size() == expected.size());
            CHECK(std::memcmp(expected.data(), got.data(), got.size() * sizeof(Vec3d)) == 0);
        }
}

TEST_CASE("[inv1] partial levels: the vertices of dual schemes, bit for bit, and their limits") {
    constexpr int k_level = 2;
    int with_limits = 0;
    for (const char* name : {"doo-sabin", "doo-sabin-cc", "midedge", "midedge-simplest", "biquartic", "averaging"})
        for (const std::uint64_t seed : test::seeds(3)) {
            CAPTURE(name);
            CAPTURE(seed);
            const SchemeInfo& scheme = *find_scheme(name);
            RuleOptions rules;
            rules.averaging_steps = 5;
            test::RandomMeshOptions options = test::random_options(seed);
            options.edge_vertices = 0;
            options.crease = options.corner = 0;
            const ControlMesh mesh = test::random_mesh(seed, options);
            const Whole whole(mesh, scheme, rules, k_level + 1);
            const PartialLevels partial(mesh, scheme, rules);
            const VertexRoots roots = partial.vertex_roots();
            REQUIRE(roots.count() == whole.points[1].size());
            // All of them: each vertex of the level is found exactly once, whatever the way through the quadtrees.
            std::vector<VertexCell> cells;
            const std::uint32_t n = 1u << k_level;
            for (std::uint32_t r = 0; r < roots.count(); ++r)
                for (std::uint32_t i = 0; i < n * n; ++i) cells.push_back({r, {i % n, i / n}, k_level});
            std::vector<Vec3d> got(cells.size());
            partial.control_positions(cells, got);
            const auto order = [](const Vec3d& a, const Vec3d& b) {
                return std::tie(a.x, a.y, a.z) < std::tie(b.x, b.y, b.z);
            };
            std::vector<Vec3d> expected = whole.points.back();
            REQUIRE(expected.size() == got.size());
            std::sort(expected.begin(), expected.end(), order);
            std::sort(got.begin(), got.end(), order);
            CHECK(std::memcmp(expected.data(), got.data(), got.size() * sizeof(Vec3d)) == 0);

            // Limits as well, where the scheme has them for all vertices of a level.
            if (scheme.name == "averaging" || seed > 1) continue;
            try {
                RefineOptions of_level{.rules = rules, .limit = true};
                const RuleRefiner refiner(mesh, scheme, 2, of_level);
                expected.resize(refiner.vertex_count());
                refiner.refine(mesh.positions(), expected);
            } catch (const Error&) {
                continue;
            }
            cells.clear();
            for (std::uint32_t r = 0; r < roots.count(); ++r)
                for (std::uint32_t i = 0; i < 4; ++i) cells.push_back({r, {i % 2, i / 2}, 1});
            std::vector<LimitPoint> limits(cells.size());
            partial.limits(cells, limits);
            got.clear();
            for (const LimitPoint& p : limits) got.push_back(p.position);
            REQUIRE(expected.size() == got.size());
            // Those of regular surroundings are summed in another order.
            const double size = mesh.bounding_box().diagonal();
            CHECK(test::farthest_from(expected, got) < 1e-14 * size);
            CHECK(test::farthest_from(got, expected) < 1e-14 * size);
            ++with_limits;
        }
    CHECK(with_limits >= 4);
}

TEST_CASE("[inv1] partial levels: Loop and Catmull-Clark as the closure has them, limits and normals included") {
    for (const std::uint64_t seed : test::seeds(6))
        for (const char* name : {"loop", "catmull-clark"}) {
            CAPTURE(name);
            CAPTURE(seed);
            const SchemeInfo& scheme = *find_scheme(name);
            const bool triangles = scheme.family == MeshFamily::triangles;
            const ControlMesh mesh = mesh_for(scheme, seed);
            const Closure closure(mesh, triangles ? SchemeKind::loop : SchemeKind::catmull_clark);
            const PartialLevels partial(mesh, scheme);
            test::Random random(seed);
            std::vector<Site> sites;
            for (int i = 0; i < 60; ++i) {
                const int level = static_cast<int>(random.below(6));
                const std::uint32_t n = 1u << level;
                Site site{HalfedgeId(random.below(mesh.halfedge_count())), {}, static_cast<std::uint8_t>(level)};
                site.at.x = random.below(n + 1);
                site.at.y = random.below(triangles ? n + 1 - site.at.x : n + 1);
                if (triangles) site.root = HalfedgeId(site.root.value / 3 * 3);
                sites.push_back(site);
            }
            const double size = mesh.bounding_box().diagonal();
            std::vector<Vec3d> got(sites.size()), expected(1);
            partial.control_positions(sites, got);
            double worst = 0;
            for (std::size_t i = 0; i < sites.size(); ++i) {
                closure.control_positions({&sites[i], 1}, sites[i].level, expected);
                worst = std::max(worst, glm::length(got[i] - expected[0]));
            }
            CHECK(worst < 1e-12 * size);
            std::vector<LimitPoint> limits(sites.size()), other(sites.size());
            partial.limits(sites, limits);
            closure.limits(sites, other);
            double limit = 0, normal = 0;
            for (std::size_t i = 0; i < sites.size(); ++i) {
                limit = std::max(limit, glm::length(limits[i].position - other[i].position));
                if (limits[i].has_tangent_plane && other[i].has_tangent_plane)
                    normal = std::max(normal, glm::length(limits[i].normal - other[i].normal));
            }
            CHECK(limit < 1e-12 * size);
            CHECK(normal < 1e-9);
        }
}

namespace {

int wrong_twins(const RuleMesh& mesh) {
    RuleMesh::Builder faces;
    for (int f = 0; f < mesh.face_count(); ++f) {
        for (const int v : mesh.corners(f)) faces.corner(v);
        faces.end_face();
    }
    const RuleMesh matched(mesh.vertex_count(), std::move(faces));
    int wrong = 0;
    for (int h = 0; h < mesh.halfedge_count(); ++h) wrong += mesh.twin(h) != matched.twin(h);
    return wrong;
}

}  // namespace

TEST_CASE("the split of vertices and the parts of a mesh know the twins that their corners give") {
    for (const std::uint64_t seed : test::seeds(8)) {
        CAPTURE(seed);
        test::RandomMeshOptions options = test::random_options(seed);
        options.edge_vertices = 0;
        options.crease = options.corner = 0.2;
        const RuleMesh whole = rule_mesh(test::random_mesh(seed, options));
        const RuleStep step = find_scheme("doo-sabin")->step(whole, {});
        CHECK(wrong_twins(step.mesh) == 0);
        detail::MeshPartFinder parts;
        test::Random random(seed);
        const int seeds[] = {static_cast<int>(random.below(step.mesh.vertex_count())),
                             static_cast<int>(random.below(step.mesh.vertex_count()))};
        for (const int rings : {1, 2, 4}) {
            const detail::MeshPart part = parts.find(step.mesh, seeds, rings);
            CHECK(wrong_twins(part.mesh) == 0);
            CHECK(wrong_twins(find_scheme("doo-sabin")->step(part.mesh, {}).mesh) == 0);
        }
    }
}

TEST_CASE(
    "limits about extraordinary points by masks of their own are those of the next level, and of far deeper nets") {
    const ControlMesh quads = cube(), triangles = triangulate(cube());
    for (const char* name : {"kobbelt", "4-8", "loop", "tuned-loop", "butterfly", "modified-butterfly"}) {
        CAPTURE(name);
        const SchemeInfo& scheme = *find_scheme(name);
        const ControlMesh& mesh = scheme.family == MeshFamily::triangles ? triangles : quads;
        // Level 3 has eight edges between the extraordinary vertices: room for their masks.
        const RefineOptions options{.limit = true, .normals = true};
        const RuleRefiner coarse(mesh, scheme, 3, options), fine(mesh, scheme, 4, options);
        std::vector<Vec3d> points(coarse.vertex_count()), again(fine.vertex_count());
        coarse.refine(mesh.positions(), points);
        fine.refine(mesh.positions(), again);
        double worst = 0, normal = 0;
        for (std::size_t v = 0; v < points.size(); ++v) worst = std::max(worst, glm::length(points[v] - again[v]));
        CHECK(worst < 1e-12);
        if (scheme.name == "butterfly") continue;  // not smooth at valence 3 and beside it
        coarse.normals(mesh.positions(), points);
        fine.normals(mesh.positions(), again);
        for (std::size_t v = 0; v < points.size(); ++v) normal = std::max(normal, glm::length(points[v] - again[v]));
        CHECK(normal < 1e-9);
    }
    for (const char* name : {"doo-sabin", "midedge", "biquartic"}) {
        CAPTURE(name);
        constexpr std::uint8_t k_level = 3, k_deeper = 12;
        const PartialLevels partial(quads, *find_scheme(name));
        std::vector<VertexCell> cells, deep;
        const std::uint32_t n = 1u << k_level, half = 1u << (k_deeper - 1);
        for (std::uint32_t y = 0; y < n; ++y)
            for (std::uint32_t x = 0; x < n; ++x) {
                cells.push_back({5, {x, y}, k_level});
                for (std::uint32_t d = 0; d < 4; ++d)
                    deep.push_back(
                        {5, {(x << k_deeper) + half - (d & 1), (y << k_deeper) + half - (d >> 1)}, k_level + k_deeper});
            }
        std::vector<LimitPoint> limits(cells.size());
        std::vector<Vec3d> net(deep.size());
        partial.limits(cells, limits);
        partial.control_positions(deep, net);
        double worst = 0;
        for (std::size_t i = 0; i < cells.size(); ++i) {
            const Vec3d middle = (net[4 * i] + net[4 * i + 1] + net[4 * i + 2] + net[4 * i + 3]) / 4.0;
            worst = std::max(worst, glm::length(middle - limits[i].position));
        }
        // The net is nearer to its limit by the square of its step, 2^-15.
        CHECK(worst < 1e-8);
    }
}

TEST_CASE("[inv10] partial levels: the batch, its order and the threads do not matter") {
    for (const char* name :
         {"butterfly", "modified-butterfly", "tuned-loop", "kobbelt", "4-8", "doo-sabin", "midedge"}) {
        CAPTURE(name);
        const SchemeInfo& scheme = *find_scheme(name);
        test::RandomMeshOptions options = test::random_options(3);
        options.edge_vertices = options.crease = options.corner = 0;
        options.triangles_only = scheme.family == MeshFamily::triangles;
        const ControlMesh mesh = test::random_mesh(3, options);
        const PartialLevels partial(mesh, scheme);
        test::Random random(7);
        const auto check = [&](auto addresses) {
            std::vector<LimitPoint> all(addresses.size()), one(1);
            partial.limits(addresses, all);
            for (std::size_t i = 0; i < addresses.size(); i += 7) {
                partial.limits({&addresses[i], 1}, one);
                CHECK(std::memcmp(&one[0].position, &all[i].position, sizeof(Vec3d)) == 0);
                CHECK(std::memcmp(&one[0].normal, &all[i].normal, sizeof(Vec3d)) == 0);
            }
            for (const int threads : {1, 2, 7}) {
                RunContext context;
                context.threads = threads;
                std::vector<LimitPoint> again(addresses.size());
                with_threads(context, [&] { partial.limits(addresses, again); });
                int wrong = 0;
                for (std::size_t i = 0; i < all.size(); ++i) wrong += !same(all[i].position, again[i].position);
                CHECK(wrong == 0);
            }
        };
        if (partial.lattice() == FanLattice::dual) {
            std::vector<VertexCell> cells;
            for (std::uint32_t i = 0; i < 40; ++i)
                cells.push_back({random.below(mesh.halfedge_count()), {random.below(4), random.below(4)}, 2});
            check(cells);
        } else {
            std::vector<Site> sites;
            for (std::uint32_t i = 0; i < 40; ++i) {
                const bool triangles = partial.lattice() == FanLattice::triangles;
                const std::uint32_t h = random.below(mesh.halfedge_count()), x = random.below(5);
                sites.push_back({HalfedgeId(triangles ? h / 3 * 3 : h), {x, random.below(5 - (triangles ? x : 0))}, 2});
            }
            check(sites);
        }
    }
}

TEST_CASE("partial levels: twenty-five levels down at one spot, with a few hundred faces on each") {
    for (const SchemeInfo& scheme : scheme_table()) {
        if (scheme.refinement == Refinement::sqrt3 || scheme.refinement == Refinement::honeycomb) continue;
        CAPTURE(scheme.name);
        const ControlMesh mesh = scheme.family == MeshFamily::triangles ? triangulate(cube()) : cube();
        const PartialLevels partial(mesh, scheme);
        constexpr int k_level = 25;
        LevelCost cost;
        Vec3d control(0);
        LimitPoint limit;
        // Two thirds of the way along a side are no vertex of any coarser level.
        const LatticePoint at{(1u << k_level) / 3, (1u << k_level) / 5};
        if (partial.lattice() == FanLattice::dual) {
            const VertexCell cell{5, at, k_level};
            partial.control_positions({&cell, 1}, {&control, 1}, &cost);
            partial.limits({&cell, 1}, {&limit, 1});
        } else {
            const Site site{HalfedgeId(3), at, k_level};
            partial.control_positions({&site, 1}, {&control, 1}, &cost);
            partial.limits({&site, 1}, {&limit, 1});
        }
        CHECK(cost.most_faces < 500);
        // So deep, the net lies on its limit.
        CHECK(glm::length(control - limit.position) < 1e-6);
        if (scheme.smoothness != "C0") CHECK(glm::length(limit.normal) == doctest::Approx(1));
    }
}

TEST_CASE("[bad-input] partial levels name the address that is wrong") {
    const ControlMesh mesh = cube();
    const PartialLevels quads(mesh, *find_scheme("kobbelt")), dual(mesh, *find_scheme("doo-sabin"));
    Vec3d out;
    const auto message = [](auto&& call) -> std::string {
        try {
            call();
        } catch (const Error& e) {
            return e.what();
        }
        return {};
    };
    const Site outside{HalfedgeId(0), {5, 0}, 2}, no_root{HalfedgeId(500), {0, 0}, 0}, fine{HalfedgeId(0), {0, 0}, 0};
    const VertexCell cell{0, {4, 0}, 2};
    CHECK(message([&] { quads.control_positions({&outside, 1}, {&out, 1}); }).find("outside its root") < 999);
    CHECK(message([&] { quads.control_positions({&no_root, 1}, {&out, 1}); }).find("no such root") < 999);
    CHECK(message([&] { dual.control_positions({&cell, 1}, {&out, 1}); }).find("outside its root") < 999);
    CHECK(message([&] { dual.control_positions({&fine, 1}, {&out, 1}); }).find("named by cells") < 999);
    CHECK(message([&] { quads.control_positions({&fine, 1}, std::span<Vec3d>()); }).find("needed") < 999);
    CHECK(message([&] { PartialLevels(mesh, *find_scheme("sqrt3")); }).find("no lattice") < 999);
    CHECK(message([&] { PartialLevels(mesh, *find_scheme("loop")); }).find("triangles") < 999);
    RuleOptions recede;
    recede.averaging_boundary = AveragingBoundary::recede;
    CHECK(message([&] { PartialLevels(mesh, *find_scheme("biquartic"), recede); }).find("recedes") < 999);
}

TEST_SUITE_END();
