#include "../kit/hierarchy_helpers.hpp"
#include "../kit/point_sets.hpp"
#include "../kit/random_mesh.hpp"
#include "../kit/surface_topology.hpp"

#include "../../hier/base/error.hpp"
#include "../../hier/mesh/obj_reader.hpp"
#include "../../hier/mesh/triangulate.hpp"
#include "../../refine/adaptive/adaptive_sqrt3.hpp"
#include "../../refine/adaptive/sqrt3_points.hpp"
#include "../../refine/uniform/refine.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <set>
#include <string>
#include <tuple>

using namespace tetrakis;

namespace {

using test::random_sqrt3_mesh;
using test::RandomMeshOptions;

std::vector<std::vector<std::uint32_t>> triangles(const PolygonMesh& mesh) {
    std::vector<std::vector<std::uint32_t>> result;
    for (std::uint32_t f = 0; f < mesh.face_count(); ++f)
        result.emplace_back(mesh.face_vertices.begin() + 3 * f, mesh.face_vertices.begin() + 3 * f + 3);
    return result;
}

bool same_mesh(const Sqrt3Mesh& a, const Sqrt3Mesh& b) {
    return a.mesh.face_vertices == b.mesh.face_vertices && a.vertices == b.vertices &&
           a.mesh.positions.size() == b.mesh.positions.size() &&
           std::memcmp(a.mesh.positions.data(), b.mesh.positions.data(), a.mesh.positions.size() * sizeof(Vec3d)) == 0;
}

void refine_randomly(Sqrt3Forest& forest, test::Random& random, double chance, int deepest) {
    for (const Sqrt3Leaf& leaf : forest.leaves())
        if (random.chance(chance) && leaf.level < deepest && (leaf.half || !forest.is_split({leaf.level, leaf.face})))
            if (!leaf.half || !forest.is_there({static_cast<std::uint8_t>(leaf.level + 1), leaf.face}))
                forest.refine(leaf);
}

void coarsen_randomly(Sqrt3Forest& forest, test::Random& random, double chance) {
    std::vector<Sqrt3Face> faces = forest.split_faces();
    random.shuffle(faces);
    for (const Sqrt3Face& face : faces)
        if (random.chance(chance) && forest.can_coarsen(face)) forest.coarsen(face);
}

}  // namespace

TEST_SUITE_BEGIN("refine");

TEST_CASE("[inv1] adaptive sqrt3, split everywhere, is uniform refinement: nets of both steps' levels, and limits") {
    for (const std::uint64_t seed : test::seeds(6)) {
        CAPTURE(seed);
        const ControlMesh mesh = random_sqrt3_mesh(seed);
        Sqrt3Forest forest(mesh);
        const double size = mesh.bounding_box().diagonal();
        for (int level = 1; level <= 4; ++level) {
            for (const Sqrt3Leaf& leaf : forest.leaves()) forest.refine(Sqrt3Face{leaf.level, leaf.face});
            REQUIRE(!forest.check().has_value());
            if (level % 2 != 0) continue;
            const Sqrt3Mesh net = sqrt3_mesh(forest, {.limit = false});
            for (const Sqrt3Leaf& leaf : net.leaves) CHECK((!leaf.half && leaf.level == level));
            const PolygonMesh uniform = refine(mesh, "sqrt3", level / 2);
            REQUIRE(net.mesh.positions.size() == uniform.positions.size());
            REQUIRE(net.mesh.face_count() == uniform.face_count());
            CHECK(test::farthest_from(net.mesh.positions, uniform.positions) < 1e-12 * size);
            CHECK(test::farthest_from(uniform.positions, net.mesh.positions) < 1e-12 * size);
            // Triangles by their centroids.
            const auto centroids = [](const PolygonMesh& m) {
                std::vector<Vec3d> result;
                for (const auto& t : triangles(m))
                    result.push_back((m.positions[t[0]] + m.positions[t[1]] + m.positions[t[2]]) / 3.0);
                return result;
            };
            CHECK(test::farthest_from(centroids(net.mesh), centroids(uniform)) < 1e-12 * size);
            RefineOptions limit;
            limit.limit = limit.normals = true;
            const PolygonMesh on_limit = refine(mesh, "sqrt3", level / 2, limit);
            const Sqrt3Mesh limits = sqrt3_mesh(forest, {.normals = true});
            CHECK(test::farthest_from(limits.mesh.positions, on_limit.positions) < 1e-12 * size);
        }
    }
}

namespace {

/// A closed mesh with all that can be tagged: a crease around, one that crosses it, ends of creases, corners.
ControlMesh tagged_mesh(float sharpness) {
    RandomMeshOptions options;
    options.topology = test::Topology::torus;
    options.columns = options.rows = 6;
    options.triangles_only = true;
    options.hole = options.crease = options.corner = 0;
    options.removed_faces = 0;
    ControlMeshData data = test::random_mesh(5, options).data();
    const auto vertex = [](std::uint32_t x, std::uint32_t y) { return y % 6 * 6 + x % 6; };
    for (std::uint32_t i = 0; i < 6; ++i) data.creases.push_back({vertex(i, 1), vertex(i + 1, 1), sharpness, 0});
    for (std::uint32_t i = 0; i < 4; ++i) data.creases.push_back({vertex(2, i), vertex(2, i + 1), sharpness, 0});
    data.creases.push_back({vertex(5, 3), vertex(5, 4), sharpness, 0});  // both of its ends are darts
    data.corners.push_back({vertex(4, 1), sharpness, 0});                // on a crease
    data.corners.push_back({vertex(0, 4), sharpness, 0});                // on a smooth surface
    return ControlMesh::build(data);
}

}  // namespace

TEST_CASE("[inv1] adaptive sqrt3: creases that close, cross and end, corners inside, whatever their sharpness") {
    for (const float sharpness : {10.0f, 0.4f, 1.0f, 1.7f}) {
        CAPTURE(sharpness);
        const ControlMesh mesh = tagged_mesh(sharpness);
        const double size = mesh.bounding_box().diagonal();
        Sqrt3Forest forest(mesh);
        RefineOptions limit;
        limit.limit = true;
        std::vector<Vec3d> before;
        for (int level = 0; level <= 3; ++level) {
            const Sqrt3Mesh net = sqrt3_mesh(forest, {.limit = false}), limits = sqrt3_mesh(forest);
            const PolygonMesh uniform = refine(mesh, "sqrt3", level), on_limit = refine(mesh, "sqrt3", level, limit);
            REQUIRE(net.mesh.positions.size() == uniform.positions.size());
            CHECK(test::farthest_from(net.mesh.positions, uniform.positions) < 1e-12 * size);
            CHECK(test::farthest_from(limits.mesh.positions, on_limit.positions) < 1e-12 * size);
            // A limit is the same from all levels.
            CHECK(test::farthest_from(before, on_limit.positions) < 1e-12 * size);
            before = on_limit.positions;
            for (int step = 0; step < 2; ++step) forest.refine_where([](const Sqrt3Leaf&) { return true; });
        }
    }
}

TEST_CASE("[inv1] [inv3] adaptive sqrt3: edges that are kept do not move a point, and no leaf lies on both sides") {
    for (const std::uint64_t seed : test::seeds(8)) {
        CAPTURE(seed);
        const ControlMesh mesh = random_sqrt3_mesh(seed);
        const double size = mesh.bounding_box().diagonal();
        const auto kept = [&](EdgeId e) { return e.value % 5 < 2; };
        Sqrt3Forest forest(mesh, kept), plain(mesh);
        const Sqrt3Forest whole = forest;
        for (int level = 1; level <= 3; ++level) {
            for (Sqrt3Forest* of : {&forest, &plain}) of->refine_where([](const Sqrt3Leaf&) { return true; });
            for (const bool limit : {false, true}) {
                const Sqrt3Mesh a = sqrt3_mesh(forest, {.limit = limit}), b = sqrt3_mesh(plain, {.limit = limit});
                REQUIRE(a.mesh.positions.size() == b.mesh.positions.size());
                CHECK(test::farthest_from(a.mesh.positions, b.mesh.positions) < 1e-12 * size);
                CHECK((level != 2 || a.mesh.face_count() == b.mesh.face_count()));
            }
        }
        // Points alone, half-way.
        test::Random random(seed);
        forest = whole;
        for (int round = 0; round < 5; ++round) refine_randomly(forest, random, 0.15, 4);
        CHECK(!forest.check().has_value());
        const Sqrt3Mesh net = sqrt3_mesh(forest, {.limit = false}), limits = sqrt3_mesh(forest);
        CHECK(test::topology(triangles(net.mesh)) == test::surface_topology(mesh));
        Sqrt3Points alone(forest.lattice());
        std::size_t different = 0;
        for (std::size_t f = 0; f < net.leaves.size(); ++f)
            for (std::size_t k = 0; k < 3; ++k) {
                const Sqrt3Leaf& leaf = net.leaves[f];
                const std::uint32_t v = net.mesh.face_vertices[3 * f + k];
                if (leaf.vertex_level[k] == net.levels[v])
                    different += alone.position(leaf.vertex_level[k], leaf.leaving[k]) != net.mesh.positions[v];
                different += alone.limit(leaf.vertex_level[k], leaf.leaving[k]).position != limits.mesh.positions[v];
            }
        CHECK(different == 0);
    }
}

TEST_CASE("[inv1] adaptive sqrt3: holes take part in the rules and are left out, as by uniform refinement") {
    ControlMeshData data = tagged_mesh(10).data();
    data.holes = {3, 4, 20, 33};
    const ControlMesh mesh = ControlMesh::build(data);
    const double size = mesh.bounding_box().diagonal();
    Sqrt3Forest forest(mesh);
    CHECK(forest.leaf_count() == mesh.face_count() - 4);
    CHECK_THROWS_WITH_AS(forest.refine(Sqrt3Face{1, 3 * 20}), doctest::Contains("hole"), Error);
    for (int level = 0; level <= 2; ++level) {
        const PolygonMesh uniform = refine(mesh, "sqrt3", level);
        const Sqrt3Mesh net = sqrt3_mesh(forest, {.limit = false});
        REQUIRE(net.mesh.face_count() == uniform.face_count());
        const auto centroids = [](const PolygonMesh& m) {
            std::vector<Vec3d> result;
            for (const auto& t : triangles(m))
                result.push_back((m.positions[t[0]] + m.positions[t[1]] + m.positions[t[2]]) / 3.0);
            return result;
        };
        CHECK(test::farthest_from(centroids(net.mesh), centroids(uniform)) < 1e-12 * size);
        CHECK(test::farthest_from(centroids(uniform), centroids(net.mesh)) < 1e-12 * size);
        for (int step = 0; step < 2; ++step) forest.refine_where([](const Sqrt3Leaf&) { return true; });
        CHECK(test::topology(triangles(sqrt3_mesh(forest).mesh)) == test::surface_topology(mesh));
        CHECK(!forest.check().has_value());
    }
}

TEST_CASE("[inv5] adaptive sqrt3: both faces of a crease that is cut are split together, and come back together") {
    const ControlMesh mesh = tagged_mesh(10);
    Sqrt3Forest forest(mesh);
    Sqrt3Lattice lattice(mesh);
    std::uint64_t crease = 0;
    while (lattice.beyond(0, crease) == Sqrt3Lattice::none) ++crease;
    const Sqrt3Face here{1, crease}, there{1, lattice.beyond(0, crease)};
    // The two control faces, and what is beyond the crease of the faces over it.
    CHECK(forest.refine(here) == 4);
    CHECK(forest.is_split(there));
    CHECK(lattice.partner(1, here.face) == there.face);
    CHECK(test::topology(triangles(sqrt3_mesh(forest).mesh)) == test::surface_topology(mesh));
    CHECK(forest.can_coarsen(there));
    forest.coarsen(there);
    CHECK(!forest.is_split(here));
    CHECK(forest.split_count() == 2);
    // Not while a face on either side needs it.
    forest.refine(Sqrt3Face{2, 3 * there.face});
    CHECK(!forest.can_coarsen(here));
    CHECK(!forest.check().has_value());
    forest.coarsen(Sqrt3Face{2, 3 * there.face});
}

TEST_CASE("[inv1] [inv3] adaptive sqrt3: conforming, with the control mesh's topology, each vertex as in uniform") {
    std::set<int> levels;
    for (const std::uint64_t seed : test::seeds(16)) {
        CAPTURE(seed);
        const ControlMesh mesh = random_sqrt3_mesh(seed);
        Sqrt3Forest forest(mesh);
        test::Random random(seed);
        for (int round = 0; round < 6; ++round) {
            refine_randomly(forest, random, 0.15, 4);
            const auto fault = forest.check();
            CHECK_MESSAGE(!fault.has_value(), fault.value_or(""));
            const Sqrt3Mesh net = sqrt3_mesh(forest, {.limit = false});
            CHECK(test::topology(triangles(net.mesh)) == test::surface_topology(mesh));
        }
        if (seed > 3) continue;
        const Sqrt3Mesh net = sqrt3_mesh(forest, {.limit = false}), limits = sqrt3_mesh(forest);
        const PolygonMesh uniform[] = {refine(mesh, "sqrt3", 0), refine(mesh, "sqrt3", 1), refine(mesh, "sqrt3", 2)};
        std::vector<Vec3d> even[3];
        for (std::size_t v = 0; v < net.vertices.size(); ++v) {
            levels.insert(net.levels[v]);
            if (net.levels[v] % 2 == 0 && net.levels[v] <= 4) even[net.levels[v] / 2].push_back(net.mesh.positions[v]);
        }
        const double size = mesh.bounding_box().diagonal();
        for (int i = 0; i < 3; ++i) CHECK(test::farthest_from(even[i], uniform[i].positions) < 1e-12 * size);
        RefineOptions limit;
        limit.limit = true;
        std::vector<Vec3d> shallow;  // level 4 has those of all levels up to it
        for (std::size_t v = 0; v < limits.vertices.size(); ++v)
            if (limits.vertices[v].birth <= 4) shallow.push_back(limits.mesh.positions[v]);
        CHECK(test::farthest_from(shallow, refine(mesh, "sqrt3", 2, limit).positions) < 1e-12 * size);
    }
    CHECK(levels.size() >= 4);
}

TEST_CASE("[inv1] adaptive sqrt3: meshes have the points that vertices have alone, bit for bit") {
    for (const std::uint64_t seed : test::seeds(8)) {
        CAPTURE(seed);
        const ControlMesh mesh = random_sqrt3_mesh(seed);
        Sqrt3Forest forest(mesh);
        test::Random random(seed);
        for (int round = 0; round < 5; ++round) {
            Sqrt3Forest one_by_one = forest;
            const auto name = [](const Sqrt3Leaf& leaf) { return std::tuple(leaf.level, leaf.half, leaf.face); };
            std::set<decltype(name(Sqrt3Leaf{}))> chosen;
            std::size_t splits = 0;
            for (const Sqrt3Leaf& leaf : forest.leaves()) {
                if (leaf.level > 5 || !random.chance(0.1)) continue;
                chosen.insert(name(leaf));
                // Another one may have made a face of it.
                const Sqrt3Face across{static_cast<std::uint8_t>(leaf.level + 1), leaf.face};
                if (!leaf.half || !one_by_one.is_there(across)) splits += one_by_one.refine(leaf);
            }
            CHECK(forest.refine_where([&](const Sqrt3Leaf& leaf) { return chosen.count(name(leaf)) != 0; }) == splits);
            CHECK(forest.split_faces() == one_by_one.split_faces());
        }
        const Sqrt3Mesh net = sqrt3_mesh(forest, {.limit = false}), limits = sqrt3_mesh(forest, {.normals = true});
        CHECK(forest.leaf_count() == net.leaves.size());
        Sqrt3Points alone(mesh);
        std::size_t different = 0;
        for (std::size_t f = 0; f < net.leaves.size(); ++f)
            for (std::size_t k = 0; k < 3; ++k) {
                const Sqrt3Leaf& leaf = net.leaves[f];
                const std::uint32_t v = net.mesh.face_vertices[3 * f + k];
                CHECK(alone.lattice().origin(leaf.vertex_level[k], leaf.leaving[k]) == net.vertices[v]);
                if (leaf.vertex_level[k] != net.levels[v]) continue;
                const LimitPoint limit = alone.limit(leaf.vertex_level[k], leaf.leaving[k]);
                different += alone.position(leaf.vertex_level[k], leaf.leaving[k]) != net.mesh.positions[v] ? 1 : 0;
                different += limit.position != limits.mesh.positions[v] ? 1 : 0;
                different += limit.normal != limits.mesh.normals[v] ? 1 : 0;
            }
        CHECK(different == 0);
    }
}

TEST_CASE("[inv2] [inv5] adaptive sqrt3: the way to a set of split faces does not matter, and all can be undone") {
    for (const std::uint64_t seed : test::seeds(6)) {
        CAPTURE(seed);
        const ControlMesh mesh = random_sqrt3_mesh(seed);
        Sqrt3Forest one(mesh), other(mesh), deep(mesh);
        test::Random random(seed);
        for (int i = 0; i < 12; ++i) {
            refine_randomly(one, random, 0.15, 4);
            coarsen_randomly(one, random, 0.5);
            CHECK(!one.check().has_value());
        }
        while (one.split_count() == 0) refine_randomly(one, random, 0.3, 4);
        const std::vector<Sqrt3Face> wanted = one.split_faces();
        std::vector<Sqrt3Face> order = wanted;
        random.shuffle(order);
        for (const Sqrt3Face& face : order) other.refine(face);
        CHECK(other.split_faces() == wanted);
        for (int i = 0; i < 3; ++i)
            for (const Sqrt3Leaf& leaf : deep.leaves()) deep.refine(Sqrt3Face{leaf.level, leaf.face});
        for (const Sqrt3Face& face : wanted) deep.refine(face);
        const std::set<Sqrt3Face> keep(wanted.begin(), wanted.end());
        std::vector<Sqrt3Face> split = deep.split_faces();
        for (auto at = split.rbegin(); at != split.rend(); ++at)
            if (keep.count(*at) == 0 && deep.is_split(*at)) deep.coarsen(*at);
        CHECK(deep.split_faces() == wanted);
        const Sqrt3Mesh expected = sqrt3_mesh(one);
        CHECK(same_mesh(sqrt3_mesh(other), expected));
        CHECK(same_mesh(sqrt3_mesh(deep), expected));
        for (std::size_t n = one.split_count(); n > 0; n = one.split_count()) {
            coarsen_randomly(one, random, 1);
            REQUIRE(one.split_count() < n);
        }
        CHECK(same_mesh(sqrt3_mesh(one), sqrt3_mesh(Sqrt3Forest(mesh))));
    }
}

TEST_CASE("adaptive sqrt3: a zoom of 30 levels at one spot; 64 bytes a leaf; bad input") {
    const ControlMesh mesh =
        triangulate(ControlMesh::build(read_obj(std::filesystem::path(TETRAKIS_SOURCE_DIR) / "data" / "cube.obj")));
    Sqrt3Forest forest(mesh);
    REQUIRE(forest.max_level() >= 30);
    std::uint64_t face = 2;
    for (std::uint8_t level = 0; level < 30; ++level) {
        forest.refine(Sqrt3Face{level, face});
        face = 3 * face + level % 3;
    }
    CHECK(!forest.check().has_value());
    const Sqrt3Mesh out = sqrt3_mesh(forest, {.normals = true});
    CHECK(out.leaves.size() < 30 * 40);
    CHECK(test::topology(triangles(out.mesh)) == test::surface_topology(mesh));
    for (const Vec3d& n : out.mesh.normals) CHECK(glm::length(n) == doctest::Approx(1));
    CHECK(forest.memory_bytes() < 64 * out.leaves.size() + 4096);

    const std::size_t before = forest.split_count();
    CHECK_THROWS_AS(forest.refine(Sqrt3Face{0, 5000}), Error);
    CHECK_THROWS_AS(forest.refine(Sqrt3Face{static_cast<std::uint8_t>(forest.max_level()), 0}), Error);
    CHECK_THROWS_AS(forest.coarsen(Sqrt3Face{0, 2}), Error);
    CHECK(forest.refine(Sqrt3Face{0, 2}) == 0);
    CHECK(forest.split_count() == before);
}

TEST_SUITE_END();
