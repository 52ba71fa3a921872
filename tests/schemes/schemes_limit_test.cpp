#include "../../schemes/rules/ring_limit.hpp"

#include <doctest/doctest.h>
#include <glm/geometric.hpp>

#include <cmath>
#include <string>

using namespace tetrakis;

namespace {

constexpr SchemeKind k_schemes[] = {SchemeKind::catmull_clark, SchemeKind::loop};

struct NamedShape {
    std::string name;
    RingShape shape;
};

/// Every kind of vertex there is, small and large.
std::vector<NamedShape> shapes() {
    std::vector<NamedShape> result;
    const auto name = [](const char* kind, int n) { return std::string(kind) + " " + std::to_string(n); };
    for (const int n : {1, 2, 3, 4, 5, 6, 7, 8, 9, 12, 16, 25, 40}) {
        result.push_back({name("smooth", n), {.faces = n}});
        result.push_back({name("boundary", n), {.faces = n, .boundary = true}});
        result.push_back({name("boundary corner", n), {.faces = n, .boundary = true, .corner = true}});
        result.push_back({name("tagged corner", n), {.faces = n, .corner = true}});
        if (n < 2) continue;
        RingShape dart{.faces = n, .sharp = std::vector<std::uint8_t>(n, 0)};
        dart.sharp[n / 3] = 1;
        result.push_back({name("dart", n), dart});
        for (int k = 1; k < n; k += 2) {
            RingShape crease = dart;
            crease.sharp[(n / 3 + k) % n] = 1;
            result.push_back({name("crease", n) + " with " + std::to_string(k), crease});
        }
        if (n < 3) continue;
        RingShape three{.faces = n, .sharp = std::vector<std::uint8_t>(n, 0)};
        three.sharp[0] = three.sharp[1] = three.sharp[n - 1] = 1;
        result.push_back({name("three creases", n), three});
        RingShape meets{.faces = n, .boundary = true, .sharp = std::vector<std::uint8_t>(n + 1, 0)};
        meets.sharp[1] = 1;
        result.push_back({name("crease meets boundary", n), meets});
    }
    return result;
}

/// A flat ring whose edges point all around (interior) or fan out over `opening` radians; z up.
std::vector<glm::dvec3> flat_ring(SchemeKind scheme, const RingShape& shape, double opening) {
    std::vector<glm::dvec3> ring{{0, 0, 0}};
    const int K = shape.faces;
    const auto at = [&](double i, double r) {
        const double a = opening * i / K;
        return glm::dvec3(r * std::cos(a), r * std::sin(a), 0);
    };
    for (int i = 0; i < shape.edge_count(); ++i) {
        ring.push_back(at(i, 1));
        if (scheme == SchemeKind::catmull_clark && i < K) ring.push_back(at(i + 0.5, 1.4));
    }
    return ring;
}

}  // namespace

TEST_SUITE_BEGIN("schemes");

TEST_CASE("normals of flat rings point outward, also where there is no tangent plane") {
    for (const SchemeKind scheme : k_schemes)
        for (const auto& [label, shape] : shapes()) {
            if (shape.faces < 3) continue;
            INFO(name(scheme), ", ", label);
            for (const double opening : {3.0, 5.0}) {
                const auto ring = flat_ring(scheme, shape, shape.boundary ? opening : 2 * 3.14159265);
                const glm::dvec3 normal = limit_normal(scheme, shape, ring_limit(scheme, shape), ring);
                CHECK(normal.z == doctest::Approx(1).epsilon(1e-9));
            }
        }
}

TEST_SUITE_END();
