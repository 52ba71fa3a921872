#include "tetrakis/eval/loop_bounder.hpp"

#include "loop_reference.hpp"

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

/// Largest |S - L| at the points of a lattice.
double sampled_error(const LoopPatches& patches, const CellTriangle& leaf, int n) {
    std::array<Vec3d, 3> corner;
    for (int k = 0; k < 3; ++k) corner[k] = patches.limit(leaf.root, leaf.corner[k], leaf.level);
    const double unit = std::ldexp(1.0, -leaf.level);
    double worst = 0;
    for (int i = 0; i <= n; ++i)
        for (int j = 0; i + j <= n; ++j) {
            const double b0 = double(i) / n, b1 = double(j) / n, b2 = double(n - i - j) / n;
            const auto& c = leaf.corner;
            const Vec3d s = patches
                                .evaluate(leaf.root, (b0 * c[0].x + b1 * c[1].x + b2 * c[2].x) * unit,
                                          (b0 * c[0].y + b1 * c[1].y + b2 * c[2].y) * unit)
                                .position;
            worst = std::max(worst, glm::length(s - (b0 * corner[0] + b1 * corner[1] + b2 * corner[2])));
        }
    return worst;
}

}  // namespace

TEST_SUITE_BEGIN("eval");

TEST_CASE("[inv9] Loop leaf bounds are never below the error sampled, and tight") {
    for (std::uint32_t seed = 0; seed < 24; ++seed) {
        CAPTURE(seed);
        const ControlMesh mesh = test::random_tagged_mesh(seed);
        const LoopPatches patches(mesh);
        LoopBounder bounder(patches);
        const double size = bounding_box(mesh.positions()).diagonal();
        std::mt19937 random(seed);
        for (int i = 0; i < 60; ++i) {
            const HalfedgeId root(3 * static_cast<std::uint32_t>(random() % mesh.face_count()));
            const CellTriangle leaf = random_leaf(random, root, 5);
            CAPTURE(root.value);
            CAPTURE(int(leaf.level));
            const double sampled = sampled_error(patches, leaf, 15);
            const double rounding = 1e-12 * size;
            // decide_at 0 asks for nothing but a lower bound; infinity for any upper one; half and twice the error
            // decide quickly; the error itself asks for a tight bound.
            for (const double decide_at : {0.0, 0.5 * sampled, 2 * sampled, std::numeric_limits<double>::infinity()}) {
                const LeafError error = bounder.parametric_error(leaf, decide_at);
                CHECK(error.upper >= sampled - rounding);
                CHECK(error.lower <= error.upper);
                if (sampled > decide_at + 1e-9 * size && error.upper < std::numeric_limits<double>::infinity())
                    CHECK(error.upper > decide_at);
                if (decide_at > 1.06 * sampled + rounding) CHECK(error.upper <= decide_at);
            }
            // No sample on a finer lattice exceeds what is said to be attained by much; the bound is within a
            // twentieth.
            const LeafError tight = bounder.parametric_error(leaf, 1.02 * sampled + rounding);
            if (tight.lower <= 1.02 * sampled + rounding) CHECK(tight.upper <= 1.09 * sampled + 2 * rounding);
            CHECK(tight.lower <= 1.1 * sampled + rounding);
            CHECK(tight.upper >= sampled - rounding);
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
        const LeafError a = kept.parametric_error(leaf, 0.01), b = fresh.parametric_error(leaf, 0.01);
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
