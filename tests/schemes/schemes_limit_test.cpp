#include "../../schemes/rules/catmull_clark.hpp"
#include "../../schemes/rules/loop.hpp"
#include "../../schemes/rules/ring_limit.hpp"

#include <doctest/doctest.h>
#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>
#include <string>
#include <thread>

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

double sum(const std::vector<double>& w) { return std::accumulate(w.begin(), w.end(), 0.0); }

std::vector<double> times(const std::vector<double>& row, const std::vector<double>& matrix) {
    std::vector<double> result(row.size(), 0.0);
    for (std::size_t i = 0; i < row.size(); ++i)
        for (std::size_t j = 0; j < row.size(); ++j) result[j] += row[i] * matrix[i * row.size() + j];
    return result;
}

/// Largest |row S - lambda row|, relative to the row.
double eigen_residual(const std::vector<double>& row, const std::vector<double>& matrix, double lambda) {
    const std::vector<double> image = times(row, matrix);
    double worst = 0, scale = 0;
    for (std::size_t i = 0; i < row.size(); ++i) {
        worst = std::max(worst, std::abs(image[i] - lambda * row[i]));
        scale = std::max(scale, std::abs(row[i]));
    }
    return scale == 0 ? 0 : worst / scale;
}

std::vector<double> squared(const std::vector<double>& a, std::size_t n) {
    std::vector<double> result(n * n, 0.0);
    for (std::size_t i = 0; i < n; ++i)
        for (std::size_t k = 0; k < n; ++k)
            for (std::size_t j = 0; j < n; ++j) result[i * n + j] += a[i * n + k] * a[k * n + j];
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

TEST_CASE("[inv7] masks of every valence sum to one") {
    for (int n = 1; n <= 300; ++n) {
        INFO("valence ", n);
        const auto total = [n](const RingMask& m) { return m.vertex + n * (m.edge + m.face); };
        for (const RingMask& m :
             {CatmullClark::vertex_mask(n), CatmullClark::vertex_mask_quads(n), CatmullClark::limit_mask(n),
              Loop::vertex_mask(n), Loop::limit_mask(n), Loop::vertex_mask(n, Loop::beta_warren(n)),
              Loop::limit_mask(n, Loop::beta_warren(n))})
            CHECK(total(m) == doctest::Approx(1).epsilon(1e-14));
        // The quad form is the general one with face points (c + e_i + e_i+1 + f_i) / 4 put in.
        const RingMask a = CatmullClark::vertex_mask(n), q = CatmullClark::vertex_mask_quads(n);
        CHECK(q.vertex == doctest::Approx(a.vertex + n * a.face / 4).epsilon(1e-14));
        CHECK(q.edge == doctest::Approx(a.edge + a.face / 2).epsilon(1e-14));
        CHECK(q.face == doctest::Approx(a.face / 4).epsilon(1e-14));
    }
    CHECK(Loop::beta(3) == doctest::Approx(3.0 / 16).epsilon(1e-15));
    CHECK(Loop::beta(6) == doctest::Approx(1.0 / 16).epsilon(1e-15));
}

TEST_CASE(
    "[inv7] limit weights sum to one, tangent weights to zero, and all are left eigenvectors of the ring matrix") {
    for (const SchemeKind scheme : k_schemes)
        for (const auto& [label, shape] : shapes()) {
            INFO(name(scheme), ", ", label);
            const RingLimit& limit = ring_limit(scheme, shape);
            const std::vector<double> matrix = ring_matrix(scheme, shape);
            REQUIRE(limit.position.size() * limit.position.size() == matrix.size());
            CHECK(sum(limit.position) == doctest::Approx(1).epsilon(1e-13));
            CHECK(eigen_residual(limit.position, matrix, 1) < 1e-13);
            for (const RingLimit::Sector& s : limit.sectors) {
                const double scale = 1 + std::abs(*std::max_element(s.tangent2.begin(), s.tangent2.end()));
                CHECK(std::abs(sum(s.tangent1)) < 1e-12);
                CHECK(std::abs(sum(s.tangent2)) < 1e-12 * scale);
                const bool chosen = shape.corner || label.starts_with("three") || label.starts_with("crease meets");
                if (chosen && !s.has_tangent_plane) continue;  // a choice, no eigenvector
                CHECK(eigen_residual(s.tangent1, matrix, s.lambda1) < 1e-12);
                CHECK(eigen_residual(s.tangent2, matrix, s.lambda2) < 1e-12);
            }
        }
}

TEST_CASE("limit positions are where a thousand refinements of the ring end") {
    for (const SchemeKind scheme : k_schemes)
        for (const auto& [label, shape] : shapes()) {
            if (shape.faces > 16 || shape.faces < 2) continue;  // valence 1 cannot occur, and diverges
            INFO(name(scheme), ", ", label);
            const RingLimit& limit = ring_limit(scheme, shape);
            const std::size_t n = limit.position.size();
            std::vector<double> power = ring_matrix(scheme, shape);
            for (int i = 0; i < 10; ++i) power = squared(power, n);
            for (std::size_t j = 0; j < n; ++j) CHECK(std::abs(power[j] - limit.position[j]) < 1e-11);
        }
}

TEST_CASE("where there is a tangent plane, the refined ring tends to the plane of the two tangents") {
    std::mt19937 random(7);
    std::uniform_real_distribution<double> noise(-0.2, 0.2);
    for (const SchemeKind scheme : k_schemes)
        for (const auto& [label, shape] : shapes()) {
            const RingLimit& limit = ring_limit(scheme, shape);
            if (!limit.has_tangent_plane || shape.faces > 9) continue;
            INFO(name(scheme), ", ", label);
            std::vector<glm::dvec3> ring =
                flat_ring(scheme, shape, shape.boundary ? shape.corner ? 1.5 : 3.1 : 2 * 3.14159);
            for (glm::dvec3& p : ring) p += glm::dvec3(noise(random), noise(random), noise(random));
            const glm::dvec3 normal = limit_normal(scheme, shape, limit, ring);
            CHECK(glm::length(normal) == doctest::Approx(1).epsilon(1e-12));
            CHECK(normal.z > 0.3);
            const std::vector<double> matrix = ring_matrix(scheme, shape);
            // Differences from the limit, rescaled each step so that no digits are lost.
            glm::dvec3 point(0);
            for (std::size_t i = 0; i < ring.size(); ++i) point += limit.position[i] * ring[i];
            for (glm::dvec3& p : ring) p -= point;
            double off = 0;
            for (int step = 0; step < 240; ++step) {
                std::vector<glm::dvec3> finer(ring.size(), glm::dvec3(0));
                double scale = 0;
                for (std::size_t i = 0; i < ring.size(); ++i)
                    for (std::size_t j = 0; j < ring.size(); ++j) finer[i] += matrix[i * ring.size() + j] * ring[j];
                glm::dvec3 drift(0);  // rounding in the kept mode would grow against the shrinking others
                for (std::size_t i = 0; i < ring.size(); ++i) drift += limit.position[i] * finer[i];
                for (glm::dvec3& p : finer) p -= drift;
                for (const glm::dvec3& p : finer) scale = std::max(scale, glm::length(p));
                off = 0;
                for (glm::dvec3& p : finer) {
                    p /= scale;
                    off = std::max(off, std::abs(glm::dot(p, normal)));
                }
                ring = std::move(finer);
            }
            CHECK(off < 1e-3);
        }
}

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

TEST_CASE("threads that ask for the same shapes get the same records") {
    std::vector<std::vector<const RingLimit*>> found(4);
    {
        std::vector<std::jthread> threads;
        for (auto& mine : found)
            threads.emplace_back([&mine] {
                for (int n = 50; n < 90; ++n) {
                    RingShape shape{.faces = n, .sharp = std::vector<std::uint8_t>(n, 0)};
                    shape.sharp[1] = shape.sharp[5] = 1;
                    mine.push_back(&ring_limit(SchemeKind::loop, shape));
                    mine.push_back(&smooth_ring_limit(SchemeKind::catmull_clark, n));
                    mine.push_back(&ring_limit(SchemeKind::catmull_clark, {.faces = n}));
                    mine.push_back(&boundary_ring_limit(SchemeKind::loop, 6 * n));
                }
            });
    }
    for (const auto& other : found) CHECK(other == found[0]);
    CHECK(found[0][1] == found[0][2]);
    CHECK_THROWS_AS(ring_limit(SchemeKind::loop, {.faces = 0}), std::invalid_argument);
}

TEST_SUITE_END();
