#include "../../eval/surface/hidden_detail.hpp"

#include "../kit/meshes.hpp"

#include "../../eval/tessellate/tessellate.hpp"
#include "../../hier/mesh/triangulate.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <random>

using namespace tetrakis;

TEST_SUITE_BEGIN("eval");

namespace {

HeightImage random_image(std::mt19937_64& random, int width, int height) {
    HeightImage image{width, height, {}};
    std::uniform_real_distribution<float> unit(0, 1);
    const float fx = 6 * unit(random), fy = 6 * unit(random), noise = unit(random) < 0.5f ? 0.0f : 0.05f;
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
            image.values.push_back(0.5f + 0.2f * std::sin(fx * static_cast<float>(x) / static_cast<float>(width)) +
                                   0.2f * std::cos(fy * static_cast<float>(y) / static_cast<float>(height)) +
                                   noise * unit(random));
    image.values[random() % image.values.size()] += 0.3f;  // a spike
    return image;
}

/// The largest departure at the centres of pixels, each looked at, of as many copies of the image as there are.
double brute_force(const HeightImage& image, const std::array<Vec2d, 3>& uv, const Vec3d& heights) {
    const Vec2d d1 = uv[1] - uv[0], d2 = uv[2] - uv[0];
    const double area = d1.x * d2.y - d1.y * d2.x;
    double largest = 0;
    for (int j = -2 * image.height; j < 3 * image.height; ++j)
        for (int i = -2 * image.width; i < 3 * image.width; ++i) {
            const Vec2d at((i + 0.5) / image.width, (j + 0.5) / image.height), d = at - uv[0];
            const double b1 = (d.x * d2.y - d.y * d2.x) / area, b2 = (d1.x * d.y - d1.y * d.x) / area;
            if (b1 < 0 || b2 < 0 || b1 + b2 > 1) continue;
            const double plane = (1 - b1 - b2) * heights[0] + b1 * heights[1] + b2 * heights[2];
            largest = std::max(largest, std::abs(image.sample(at) - plane));
        }
    return largest;
}

/// Flat, at height z.
ControlMesh sheet(std::uint32_t n, double z) {
    ControlMeshData data = test::unit_sheet(n);
    for (Vec3d& p : data.positions) p.z = z;
    return ControlMesh::build(std::move(data));
}

}  // namespace

TEST_CASE(
    "the pixel that departs most from a plane is the one that brute force finds, across copies of the image too") {
    constexpr double k_any = std::numeric_limits<double>::infinity();
    int inside = 0;
    for (const std::uint64_t seed : {1, 2, 3, 4, 5, 6, 7, 8}) {
        CAPTURE(seed);
        std::mt19937_64 random(seed);
        const int width = 1 + static_cast<int>(random() % 40), height = 1 + static_cast<int>(random() % 40);
        const HeightImage image = random_image(random, width, height);
        const detail::HeightRanges ranges(image);
        std::uniform_real_distribution<double> unit(0, 1);
        for (int i = 0; i < 20; ++i) {
            const double size = std::pow(10.0, -2 * unit(random));
            const Vec2d from(2 * unit(random) - 1, 2 * unit(random) - 1);
            std::array<Vec2d, 3> uv;
            Vec3d heights(0);
            for (int k = 0; k < 3; ++k) {
                uv[k] = from + size * Vec2d(unit(random), unit(random));
                heights[k] = image.sample(uv[k]);
            }
            const double expected = brute_force(image, uv, heights);
            const auto found = detail::departure(ranges, uv, heights, 0, k_any);
            CHECK(std::abs(found.height) == doctest::Approx(expected).epsilon(1e-9));
            if (expected < 1e-3) continue;
            ++inside;
            CHECK(detail::departure(ranges, uv, heights, 1.001 * expected, k_any).height == 0);
            CHECK(std::abs(detail::departure(ranges, uv, heights, 0.9 * expected, 0.9 * expected).height) >=
                  0.9 * expected);
            const Vec2d at = found.weights[0] * uv[0] + found.weights[1] * uv[1] + found.weights[2] * uv[2];
            const double plane =
                found.weights[0] * heights[0] + found.weights[1] * heights[1] + found.weights[2] * heights[2];
            CHECK(image.sample(at) - plane == doctest::Approx(found.height).epsilon(1e-6));
        }
    }
    CHECK(inside > 40);
}

TEST_CASE("a spike of one pixel in a large height image is caught on a coarse mesh, by leaves, fans and budgets") {
    HeightImage image{1024, 1024, {}};
    image.values.assign(1024 * 1024, 0.25f);
    constexpr int k_column = 700, k_row = 411;
    image.values[k_row * 1024 + k_column] = 1.0f;
    const Vec2d tip((k_column + 0.5) / 1024, 1 - (k_row + 0.5) / 1024);
    TessellateOptions options;
    options.displacement = &image;
    options.amplitude = 0.1;
    options.measure = false;
    struct Case {
        std::uint32_t faces;
        double tolerance;
        std::uint64_t budget;
        SchemeKind scheme;
    };
    constexpr SchemeKind quads = SchemeKind::catmull_clark, loop = SchemeKind::loop;
    for (const auto& [faces, tolerance, budget, scheme] : {Case{3, 1e-3, 0, quads},
                                                           {1, 1e-2, 0, quads},
                                                           {8, 1e-2, 2000, quads},
                                                           {8, 0, 2000, quads},
                                                           {3, 1e-3, 0, loop},
                                                           {8, 0, 2000, loop}}) {
        CAPTURE(faces);
        CAPTURE(budget);
        CAPTURE(name(scheme));
        const ControlMesh squares = sheet(faces, 0.5), triangles = triangulate(squares);
        const ControlMesh& mesh = scheme == loop ? triangles : squares;
        options.scheme = scheme;
        options.tolerance = tolerance > 0 ? std::optional(tolerance) : std::nullopt;
        options.tolerance_is_absolute = true;
        options.max_triangles = budget;
        const Tessellation result = tessellate(mesh, options);
        double highest = 0;
        Vec3d at(0);
        for (const Vec3d& p : result.mesh.positions)
            if (p.z > highest) highest = p.z, at = p;
        CHECK(highest > 0.5 + 0.1 - 1e-2);
        CHECK(glm::length(Vec2d(at) - tip) < 1.0 / 1024);
        CHECK(result.mesh.triangles.size() < 2001);  // around the spike alone
    }
}

TEST_CASE("a slope and a gentle wave of many pixels take no more triangles than their shape needs") {
    HeightImage image{512, 512, {}};
    for (int y = 0; y < 512; ++y)
        for (int x = 0; x < 512; ++x)
            image.values.push_back(0.5f + 0.5f * std::sin(6.2831853f * (static_cast<float>(x) + 0.5f) / 512));
    TessellateOptions options;
    options.measure = true;
    options.displacement = &image;
    options.amplitude = 0.1;
    options.tolerance = 1e-3;
    const Tessellation result = tessellate(sheet(4, 0), options);
    CHECK(result.tolerance_reached);
    CHECK(result.mesh.triangles.size() < 2000);
}

TEST_SUITE_END();
