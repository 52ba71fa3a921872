#include "../../schemes/analysis/spectrum.hpp"
#include "../../schemes/parts/dense_eigen.hpp"
#include "../../schemes/parts/sector_fan.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

using namespace tetrakis;

TEST_SUITE_BEGIN("schemes");

TEST_CASE("a defective eigenvalue comes out as often as it counts, and others that are near stay apart") {
    const auto near = [](const std::vector<detail::Complex>& values, double value, double distance) {
        return std::count_if(values.begin(), values.end(),
                             [&](const detail::Complex& z) { return std::abs(z - value) < distance; });
    };
    // In one basis, not orthogonal: Jordan blocks, and three eigenvalues as near as the noise of a block of three,
    // which are known far better than that.
    constexpr double basis[3][3] = {{1, 2, 0.5}, {-1, 1, 3}, {0.3, -2, 1}};
    constexpr double gap = 1e-5;
    const auto in_basis = [&](const double(&diagonal)[3], double coupling) {
        // T with the basis as columns: T B = B J, solved column by column with B's inverse.
        const auto minor = [&](int i, int j) {
            const int a = (i + 1) % 3, b = (i + 2) % 3, c = (j + 1) % 3, d = (j + 2) % 3;
            return basis[a][c] * basis[b][d] - basis[a][d] * basis[b][c];
        };
        const double determinant = basis[0][0] * minor(0, 0) + basis[0][1] * minor(0, 1) + basis[0][2] * minor(0, 2);
        detail::DenseMatrix m(3);
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j)
                for (int k = 0; k < 3; ++k) {
                    m(i, j) += basis[i][k] * diagonal[k] * minor(j, k) / determinant;
                    if (k < 2) m(i, j) += basis[i][k] * coupling * minor(j, k + 1) / determinant;
                }
        return detail::eigenvalues(m);
    };
    CHECK(near(in_basis({0.25, 0.25, 0.25}, 1), 0.25, 1e-12) == 3);
    CHECK(near(in_basis({0.25, 0.25, 0.5}, 0.1), 0.25, 1e-12) == 2);
    for (const double coupling : {0.0, 1e-6, 1e-4})
        for (int i = 0; i < 3; ++i)
            CHECK(near(in_basis({0.25 - gap, 0.25, 0.25 + gap}, coupling), 0.25 + (i - 1) * gap, 1e-9) == 1);
    // Butterfly's mode 0 has 1/4 three times and one eigenvector for them.
    int count = 0;
    for (const Eigenvalue& e : analyse(*find_scheme("butterfly"), {.faces = 5}, {}).eigenvalues)
        if (e.frequency == 0 && std::abs(e.value - 0.25) < 1e-12) ++count;
    CHECK(count == 3);
    // Nine averaging steps have two that are 1e-5 apart.
    RuleOptions nine;
    nine.averaging_steps = 9;
    std::vector<double> close;
    for (const Eigenvalue& e : analyse(*find_scheme("averaging"), {.faces = 5}, nine).eigenvalues)
        if (e.frequency == 2 && std::abs(e.value - 0.02062) < 2e-5) close.push_back(e.value.real());
    REQUIRE(close.size() == 2);
    CHECK(std::abs(close[0] - close[1]) == doctest::Approx(1.0452e-5).epsilon(1e-3));
}

TEST_CASE("the eigenvalues at boundaries of many edges, part by part, are those of the whole matrix") {
    const auto magnitudes = [](std::vector<detail::Complex> values) {
        std::vector<double> result;
        for (const detail::Complex z : values) result.push_back(std::abs(z));
        std::sort(result.begin(), result.end());
        return result;
    };
    for (const char* name : {"loop", "catmull-clark", "midpoint", "bilinear", "sqrt3", "4-8"})
        for (const int faces : {25, 26}) {
            CAPTURE(name);
            CAPTURE(faces);
            const SpectralAnalysis a = analyse(*find_scheme(name), {.faces = faces, .boundary = true}, {});
            detail::DenseMatrix whole(a.matrix.size());
            for (int i = 0; i < a.matrix.size(); ++i)
                for (const auto& [j, weight] : a.matrix.row(i).terms) whole(i, j) = weight;
            std::vector<detail::Complex> values;
            for (const Eigenvalue& e : a.eigenvalues) values.push_back(e.value);
            const std::vector<double> found = magnitudes(values), expected = magnitudes(detail::eigenvalues(whole));
            REQUIRE(found.size() == expected.size());
            double off = 0;
            for (std::size_t i = 0; i < found.size(); ++i) off = std::max(off, std::abs(found[i] - expected[i]));
            CHECK(off < 1e-8);
        }
}

TEST_CASE("honeycomb: a face and its ring of hexagons map to themselves as their matrix says, in any mesh") {
    const SchemeInfo& scheme = *find_scheme("honeycomb");
    for (const int k : {3, 4, 5, 6, 7, 12}) {
        CAPTURE(k);
        const SpectralAnalysis analysis = analyse(scheme, {.faces = k}, {});
        CHECK(analysis.matrix.size() == 4 * k);
        CHECK(analysis.lambda1 == doctest::Approx(0.5));
        CHECK(analysis.lambda2 == doctest::Approx(0.5));
        // The eigenvalue of what is the same all around: hexagons that rise beyond a level face.
        CHECK(analysis.third == doctest::Approx(7.0 / 24).epsilon(1e-9));
        CHECK(analysis.curvature == CurvatureClass::unbounded);
        // A prism: two k-gons and k quads. After two steps there are hexagons around each.
        RuleMesh::Builder faces;
        for (int i = k; i-- > 0;) faces.corner(i);
        faces.end_face();
        for (int i = 0; i < k; ++i) faces.corner(k + i);
        faces.end_face();
        for (int i = 0; i < k; ++i) faces.face({i, (i + 1) % k, k + (i + 1) % k, k + i});
        RuleMesh mesh(2 * k, std::move(faces));
        for (int i = 0; i < 2; ++i) mesh = scheme.step(mesh, {}).mesh;
        const RuleStep step = scheme.step(mesh, {});
        for (const int face : {0, 1, 2}) {
            if (mesh.face_size(face) != k) continue;
            std::vector<int> start, child;
            for (int c = 0; c < k; ++c) {
                start.push_back(mesh.face_begin(face) + c);
                child.push_back(step.child_halfedge[static_cast<std::size_t>(start.back())]);
            }
            const std::vector<int> coarse = find_fan(mesh, start, analysis.matrix.labels),
                                   fine = find_fan(step.mesh, child, analysis.matrix.labels);
            for (int i = 0; i < analysis.matrix.size(); ++i) {
                const StencilRow row = step.stencils.row(fine[static_cast<std::size_t>(i)]);
                double rest = 0;
                for (const auto& [point, weight] : row.terms) rest += std::abs(weight);
                for (int j = 0; j < analysis.matrix.size(); ++j) {
                    double weight = 0;
                    for (const auto& [point, w] : row.terms)
                        if (point == coarse[static_cast<std::size_t>(j)]) weight += w;
                    CHECK(std::abs(weight - analysis.matrix.at(i, j)) < 1e-14);
                    rest -= std::abs(weight);
                }
                CHECK(std::abs(rest) < 1e-14);
            }
        }
    }
}

TEST_CASE("honeycomb: the eigenvalues at the boundary are those of two pentagons and of the curve between them") {
    const SpectralAnalysis a = analyse(*find_scheme("honeycomb"), {.faces = 2, .boundary = true}, {});
    // Twice the weights of a pentagon's corners among themselves, and the cubic spline along the boundary.
    const double w1 = (3 + 2 * std::cos(2 * std::numbers::pi / 5)) / 20,
                 w2 = (3 + 2 * std::cos(4 * std::numbers::pi / 5)) / 20, mean = (w1 + w2) / 2,
                 root = std::sqrt(mean * mean - w2 * (w1 - w2));
    const double expected[] = {1, 0.5, 0.25, mean + root, mean + root, 0.125, 0.125, mean - root, mean - root};
    REQUIRE(a.eigenvalues.size() == std::size(expected));
    for (std::size_t i = 0; i < std::size(expected); ++i) CHECK(std::abs(a.eigenvalues[i].value - expected[i]) < 1e-12);
    CHECK_FALSE(a.proper);
}

TEST_SUITE_END();
