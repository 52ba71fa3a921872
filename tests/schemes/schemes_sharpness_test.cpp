#include "../../schemes/core/sharpness.hpp"

#include <doctest/doctest.h>

#include <limits>
#include <vector>

using namespace tetrakis;

namespace {
constexpr float inf = std::numeric_limits<float>::infinity();
using Floats = std::vector<float>;

VertexBlend uniform_blend(const Floats& edges, float vertex) {
    Floats child;
    for (const float s : edges) child.push_back(child_sharpness(s));
    return vertex_blend(edges, vertex, child, child_sharpness(vertex));
}
}  // namespace

TEST_SUITE_BEGIN("schemes");

TEST_CASE("sharpness falls by one a level, never below zero, and infinity stays") {
    CHECK(child_sharpness(2.5f) == 1.5f);
    CHECK(child_sharpness(1.0f) == 0.0f);
    CHECK(child_sharpness(0.25f) == 0.0f);
    CHECK(child_sharpness(inf) == inf);
}

TEST_CASE("Chaikin creasing mixes a quarter of the other semi-sharp edges at the end vertex") {
    CHECK(child_sharpness_chaikin(3.0f, Floats{3.0f, 1.0f, 0.0f}) == 1.5f);         // (9 + 1) / 4 - 1
    CHECK(child_sharpness_chaikin(3.0f, Floats{3.0f, 1.0f, 2.0f, inf}) == 1.625f);  // (9 + 1.5) / 4 - 1
    CHECK(child_sharpness_chaikin(3.0f, Floats{0.0f, 3.0f, inf}) == 2.0f);          // alone: uniform
    CHECK(child_sharpness_chaikin(0.5f, Floats{0.5f, 0.5f}) == 0.0f);
    CHECK(child_sharpness_chaikin(inf, Floats{inf, 1.0f}) == inf);
    CHECK(child_sharpness_chaikin(0.0f, Floats{0.0f, 1.0f, 1.0f}) == 0.0f);
}

TEST_CASE("the vertex rule follows the number of sharp edges") {
    CHECK(vertex_rule(Floats{0, 0, 0}, 0) == VertexRule::smooth);
    CHECK(vertex_rule(Floats{0, 0.1f, 0}, 0) == VertexRule::dart);
    CHECK(vertex_rule(Floats{inf, 0.1f, 0}, 0) == VertexRule::crease);
    CHECK(vertex_rule(Floats{inf, 0.1f, 3}, 0) == VertexRule::corner);
    CHECK(vertex_rule(Floats{0, 0, 0}, 0.1f) == VertexRule::corner);
}

TEST_CASE("a vertex blends parent and child rule by the mean of what vanishes") {
    const VertexBlend dart = uniform_blend({0.5f, 0, 0}, 0);
    CHECK(dart.smooth == 1);
    const VertexBlend crease = uniform_blend({0, 0.5f, 0, 0.75f}, 0);
    CHECK(crease.crease.weight == 0.625);
    CHECK(crease.smooth == 0.375);
    CHECK(crease.crease.a == 1);
    CHECK(crease.crease.b == 3);
    const VertexBlend stays = uniform_blend({0, 1.5f, 0, inf}, 0);
    CHECK(stays.crease.weight == 1);
    // Corner to crease: of four sharp edges two vanish, and the other two carry the child's crease.
    const VertexBlend four = uniform_blend({0.5f, 3, 0.25f, inf}, 0);
    CHECK(four.corner == 0.375);
    CHECK(four.crease.weight == 0.625);
    CHECK(four.crease.a == 1);
    CHECK(four.crease.b == 3);
    const VertexBlend tagged = uniform_blend({0, 0, 0}, 0.75f);
    CHECK(tagged.corner == 0.75);
    CHECK(tagged.smooth == 0.25);
}

TEST_CASE("an edge is a crease while both halves are sharp, then fades") {
    CHECK(edge_crease_weight(0.0f, 0, 0) == 0);
    CHECK(edge_crease_weight(2.5f, 1.5f, 1.5f) == 1);
    CHECK(edge_crease_weight(0.25f, 0, 0) == 0.25);
    CHECK(edge_crease_weight(1.0f, 0, 0) == 1);
    CHECK(edge_crease_weight(1.25f, 0, 0.5f) == 1.25);  // Chaikin, beside a nearly smooth edge
    CHECK(edge_crease_weight(0.9f, 0.1f, 0.2f) == 1);   // Chaikin: a sharp neighbour keeps both halves sharp
}

TEST_SUITE_END();
