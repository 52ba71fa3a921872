#include "../../eval/bounds/loop_bounder.hpp"

#include "../kit/loop_reference.hpp"
#include "../kit/sampled_distance.hpp"

#include "../../eval/tessellate/surface_family.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <limits>
#include <random>
#include <vector>

using namespace tetrakis;

namespace {

/// A random red triangle of a root, or one of its green parts.
CellTriangle random_leaf(std::mt19937& random, HalfedgeId root, int deepest) {
    const auto below = [&](std::uint32_t n) { return static_cast<std::uint32_t>(random() % n); };
    const int level = static_cast<int>(below(static_cast<std::uint32_t>(deepest) + 1));
    const std::uint32_t side = 1u << level;
    std::array<LatticePoint, 3> c;
    const std::uint32_t x = below(side), y = below(side - x);
    const bool inverted = x + y + 2 <= side && below(2) == 1;
    if (inverted)
        c = {LatticePoint{x + 1, y + 1}, {x, y + 1}, {x + 1, y}};
    else
        c = {LatticePoint{x, y}, {x + 1, y}, {x, y + 1}};
    const std::uint32_t green = below(4);
    if (green < 2) return {root, static_cast<std::uint8_t>(level), c};
    std::array<LatticePoint, 3> p, m;
    for (int k = 0; k < 3; ++k) p[k] = {2 * c[k].x, 2 * c[k].y};
    for (int k = 0; k < 3; ++k) m[k] = {c[k].x + c[(k + 1) % 3].x, c[k].y + c[(k + 1) % 3].y};
    const std::uint32_t k = below(3), k1 = (k + 1) % 3, k2 = (k + 2) % 3;
    CellTriangle leaf{root, static_cast<std::uint8_t>(level + 1), {}};
    if (green == 2)
        leaf.corner = below(2) ? std::array{p[k], p[k1], m[k1]} : std::array{p[k], m[k1], p[k2]};
    else
        leaf.corner = below(2) ? std::array{p[k], m[k], m[k1]} : std::array{p[k], m[k1], m[k2]};
    const std::uint32_t turn = below(3);
    std::rotate(leaf.corner.begin(), leaf.corner.begin() + turn, leaf.corner.end());
    return leaf;
}

constexpr double k_infinity = std::numeric_limits<double>::infinity();

test::SampledError sampled_distance(const LoopPatches& patches, const CellTriangle& leaf, int n) {
    return test::sampled_distance(n, [&](double b0, double b1, double b2) {
        const SurfaceParameter at = LoopFamily::parameter(patches.mesh(), leaf, b0, b1, b2);
        return patches.evaluate(at.root, at.x, at.y).position;
    });
}

}  // namespace

TEST_SUITE_BEGIN("eval");

TEST_CASE("[inv9] Loop leaf bounds are never below the error sampled, and tight") {
    for (std::uint32_t seed = 0; seed < 24; ++seed) {
        CAPTURE(seed);
        const ControlMesh mesh = test::random_tagged_mesh(seed);
        const LoopPatches patches(mesh);
        LoopLeafBounder bounder(patches);
        const double size = bounding_box(mesh.positions()).diagonal();
        std::mt19937 random(seed);
        for (int i = 0; i < 60; ++i) {
            const HalfedgeId root(3 * static_cast<std::uint32_t>(random() % mesh.face_count()));
            const CellTriangle leaf = random_leaf(random, root, 5);
            CAPTURE(root.value);
            CAPTURE(int(leaf.level));
            const auto [sampled, back] = sampled_distance(patches, leaf, 15);
            const double rounding = 1e-12 * size;
            // decide_at 0 asks for nothing but a lower bound; infinity for any upper one; half and twice the error
            // decide quickly; the error itself asks for a tight bound.
            for (const double decide_at : {0.0, 0.5 * sampled, 2 * sampled, k_infinity}) {
                const LeafError error = bounder.leaf_error(leaf, decide_at);
                CHECK(error.upper >= sampled - rounding);
                CHECK(error.lower <= error.upper);
                if (sampled > decide_at + 1e-9 * size && error.upper < k_infinity) CHECK(error.upper > decide_at);
                if (decide_at > 1.06 * sampled + rounding) CHECK(error.upper <= decide_at);
            }
            // The lattice may miss the largest error by a little.
            const double certified = bounder.certified_error(leaf, 0);
            CHECK(certified >= sampled - rounding);
            CHECK(certified >= back - rounding);
            CHECK(certified <= 1.25 * sampled + rounding);
            CHECK(bounder.leaf_error(leaf, k_infinity).lower <= certified);
            CHECK(bounder.certified_error(leaf, 0.7 * sampled) >= sampled - rounding);
            CHECK(bounder.certified_error(leaf, 3 * sampled) <= 3 * sampled + rounding);
        }
    }
}

TEST_CASE("Loop leaf bounds do not depend on what was asked before") {
    const ControlMesh mesh = test::random_tagged_mesh(7);
    const LoopPatches patches(mesh);
    LoopBounder kept(patches);
    std::mt19937 random(5);
    for (int i = 0; i < 300; ++i) {
        const HalfedgeId root(3 * static_cast<std::uint32_t>(random() % mesh.face_count()));
        const CellTriangle leaf = random_leaf(random, root, 4);
        const LoopPatches fresh_patches(mesh);
        LoopBounder fresh(fresh_patches);
        const LeafError a = kept.leaf_error(leaf, 0.01), b = fresh.leaf_error(leaf, 0.01);
        CHECK(a.lower == b.lower);
        CHECK(a.upper == b.upper);
    }
}

TEST_CASE("Loop leaf samples are points of the surface, with its normals") {
    const ControlMesh mesh = test::random_tagged_mesh(11);
    const LoopPatches patches(mesh);
    LoopBounder bounder(patches);
    std::mt19937 random(5);
    const int n = 3;
    std::vector<Vec3d> positions((n + 1) * (n + 2) / 2), normals(positions.size()), alone(positions.size());
    for (int i = 0; i < 300; ++i) {
        const HalfedgeId root(3 * static_cast<std::uint32_t>(random() % mesh.face_count()));
        const CellTriangle leaf = random_leaf(random, root, 4);
        bounder.sample(leaf, n, positions, normals);
        bounder.sample(leaf, n, alone, {});
        const double unit = std::ldexp(1.0, -leaf.level);
        std::size_t at = 0;
        for (int row = 0; row <= n; ++row)
            for (int j = 0; j <= row; ++j, ++at) {
                const double b0 = double(row - j) / n, b1 = double(j) / n, b2 = double(n - row) / n;
                const auto& c = leaf.corner;
                const SurfacePoint p = patches.evaluate(leaf.root, (b0 * c[0].x + b1 * c[1].x + b2 * c[2].x) * unit,
                                                        (b0 * c[0].y + b1 * c[1].y + b2 * c[2].y) * unit);
                CHECK(glm::length(positions[at] - p.position) < 1e-12);
                CHECK(glm::length(alone[at] - p.position) < 1e-12);
                if (!p.has_second) continue;  // where a corner has several normals, each root has its own
                const double length = glm::length(normals[at]);
                if (length > 1e-9) CHECK(glm::dot(normals[at], p.normal) > length * (1 - 1e-9));
            }
    }
}

TEST_SUITE_END();
