#include "tetrakis/schemes/dense_eigen.hpp"
#include "tetrakis/schemes/spectrum.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <span>
#include <string>
#include <utility>
#include <vector>

using namespace tetrakis;

namespace {

/// What each scheme is looked at with: itself, and its choices.
struct Variant {
    std::string name;
    const SchemeInfo* scheme;
    RuleOptions options{};
};

std::vector<Variant> variants() {
    std::vector<Variant> result;
    for (const SchemeInfo& scheme : scheme_table()) {
        if (scheme.name == "averaging") {
            for (int m = 0; m <= 5; ++m) {
                result.push_back({"averaging " + std::to_string(m), &scheme, {}});
                result.back().options.averaging_steps = m;
            }
            continue;
        }
        result.push_back({std::string(scheme.name), &scheme, {}});
    }
    const auto with = [&](const char* name, const char* what, auto&& change) {
        result.push_back({std::string(name) + ", " + what, find_scheme(name), {}});
        change(result.back().options);
    };
    with("loop", "Warren's weights", [](RuleOptions& o) { o.loop_weights = LoopWeights::warren; });
    for (const char* name : {"loop", "tuned-loop", "catmull-clark"}) {
        with(name, "cosine", [](RuleOptions& o) { o.edge_beside_crease = EdgeBesideCrease::cosine; });
        with(name, "brief", [](RuleOptions& o) { o.edge_beside_crease = EdgeBesideCrease::brief; });
    }
    with("loop", "Hoppe's creases", [](RuleOptions& o) { o.hoppe_crease = true; });
    with("tuned-loop", "half tuned", [](RuleOptions& o) { o.tuning = 0.5; });
    with("modified-butterfly", "reflection", [](RuleOptions& o) { o.reflect_at_boundary = true; });
    with("modified-butterfly", "ten points", [](RuleOptions& o) { o.butterfly_w = 0.01; });
    with("catmull-clark", "other weights", [](RuleOptions& o) {
        o.catmull_clark_beta = 0.3;
        o.catmull_clark_gamma = 0.1;
    });
    return result;
}

double sum(const std::vector<double>& w) { return std::accumulate(w.begin(), w.end(), 0.0); }

double largest(const std::vector<double>& w) {
    double most = 0;
    for (const double x : w) most = std::max(most, std::abs(x));
    return most;
}

/// How far l S is from lambda l, for a largest weight of one.
double residual(const std::vector<double>& l, const LocalMatrix& s, double lambda) {
    std::vector<double> x(l.size(), 0.0);
    for (int i = 0; i < s.size(); ++i)
        for (int j = 0; j < s.size(); ++j) x[j] += l[i] * s.at(i, j);
    for (int j = 0; j < s.size(); ++j) x[j] -= lambda * l[j];
    return largest(x) / largest(l);
}

/// Distance of two vectors scaled to a largest weight of one with the same sign.
double difference(const std::vector<double>& a, const std::vector<double>& b) {
    double dot = 0, most = 0;
    for (std::size_t i = 0; i < a.size(); ++i) dot += a[i] * b[i];
    const double p = 1 / largest(a), q = (dot < 0 ? -1 : 1) / largest(b);
    for (std::size_t i = 0; i < a.size(); ++i) most = std::max(most, std::abs(p * a[i] - q * b[i]));
    return most;
}

/// What is printed for a shape is what the matrix says.
void check_masks(const Variant& v, const FanShape& shape) {
    const SpectralAnalysis a = analyse(*v.scheme, shape, v.options);
    double off = 0;
    for (int i = 0; i < a.matrix.size(); ++i) {
        double row = -1;
        for (int j = 0; j < a.matrix.size(); ++j) row += a.matrix.at(i, j);
        off = std::max(off, std::abs(row));
    }
    CHECK(off < 1e-13);
    const SchemeMasks masks = scheme_masks(*v.scheme, a, v.options);
    // Left eigenvectors of a matrix with nearby eigenvalues are known to the rounding error over the distance.
    constexpr double k_tolerance = 1e-9;
    CHECK(sum(masks.limit) == doctest::Approx(1).epsilon(1e-12));
    CHECK(residual(masks.limit, a.matrix, 1) < k_tolerance);
    CHECK(difference(masks.limit, a.limit) < k_tolerance);
    const ClosedMasks closed = v.scheme->closed_masks(shape, v.options);
    const auto check_tangent = [&](const std::vector<double>& mask, const std::vector<double>& numeric, double lambda,
                                   double formula_lambda, bool is_formula) {
        if (mask.empty()) return;
        CHECK(std::abs(sum(mask)) < 1e-10 * largest(mask));
        CHECK(residual(mask, a.matrix, is_formula ? formula_lambda : lambda) < k_tolerance);
        // Where no tangent plane is (plain rules, many faces), the mode along the boundary is not the dominant one.
        if (!is_formula || !a.proper) return;
        CHECK(formula_lambda == doctest::Approx(lambda).epsilon(1e-7));
        if (!numeric.empty()) CHECK(difference(mask, numeric) < 1e-7);
    };
    check_tangent(masks.tangent1, a.tangent1, a.lambda1, closed.lambda1, masks.tangent1_is_formula);
    check_tangent(masks.tangent2, a.tangent2, a.lambda2, closed.lambda2, masks.tangent2_is_formula);
}

}  // namespace

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
        detail::DenseMatrix<double> m(3);
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

TEST_CASE("[slow] printed limit and tangent masks are eigenvectors of the scheme's own matrix, valence 3 to 64") {
    for (const Variant& v : variants()) {
        CAPTURE(v.name);
        for (int n = 3; n <= 64; ++n) {
            CAPTURE(n);
            check_masks(v, {.faces = n});
        }
    }
}

TEST_CASE("the same at boundaries") {
    for (const Variant& v : variants()) {
        CAPTURE(v.name);
        for (const int K : {1, 2, 3, 4, 5, 6, 7, 8, 12, 16}) {
            if (v.scheme->rings > 2 && K > 6) continue;
            CAPTURE(K);
            check_masks(v, {.faces = K, .boundary = true});
        }
    }
}

TEST_CASE(
    "two edges inside: the masks are eigenvectors, what a half turn or the mirror does to the matrix changes nothing") {
    for (const Variant& v : variants()) {
        CAPTURE(v.name);
        const FanShape shape{.faces = 2};
        if (fan_lattice(*v.scheme, v.options) == FanLattice::dual) {
            CHECK_THROWS_AS(analyse(*v.scheme, shape, v.options), std::invalid_argument);
            continue;
        }
        // The points beyond a regular edge are other ones from either of its sides there.
        if (v.options.butterfly_w != 0) continue;
        const bool weights = v.options.catmull_clark_beta.has_value();
        if (weights) continue;  // refused: no such weights have a tangent plane there
        check_masks(v, shape);
        const SpectralAnalysis a = analyse(*v.scheme, shape, v.options);
        const FanLabels& labels = a.matrix.labels;
        double off = 0;
        for (int i = 0; i < a.matrix.size(); ++i)
            for (int j = 0; j < a.matrix.size(); ++j) {
                const auto turned = [&](int k) {
                    FanLabel label = labels.all()[k];
                    ++label.sector;
                    return labels.find(label);
                };
                const auto mirrored = [&](int k) { return labels.find(labels.mirrored(labels.all()[k])); };
                off = std::max(off, std::abs(a.matrix.at(i, j) - a.matrix.at(turned(i), turned(j))));
                off = std::max(off, std::abs(a.matrix.at(i, j) - a.matrix.at(mirrored(i), mirrored(j))));
            }
        CHECK(off < 1e-15);
        CHECK_FALSE(a.proper);
    }
    // By hand: Loop's edges take 3/8 of the vertex and their end, 2/8 of the other.
    const SpectralAnalysis loop = analyse(*find_scheme("loop"), {.faces = 2}, {});
    CHECK(loop.lambda1 == doctest::Approx(1.0 / 8).epsilon(1e-12));
    CHECK(loop.lambda2 == doctest::Approx(1.0 / 8).epsilon(1e-12));
    CHECK(loop.limit[0] == doctest::Approx(8.0 / 21).epsilon(1e-12));
    const SpectralAnalysis quads = analyse(*find_scheme("catmull-clark"), {.faces = 2}, {});
    CHECK(quads.lambda1 == doctest::Approx(1.0 / 4).epsilon(1e-12));
    CHECK(quads.third == doctest::Approx(1.0 / 4).epsilon(1e-12));
    CHECK(analyse(*find_scheme("midpoint"), {.faces = 2}, {}).third == doctest::Approx(0.5));
}

TEST_CASE("the rows of a local matrix are those of its scheme's step, in all sectors") {
    for (const Variant& v : variants()) {
        if (v.scheme->family == MeshFamily::hexagons) continue;
        CAPTURE(v.name);
        for (const FanShape shape : {FanShape{.faces = 5}, FanShape{.faces = 26}, {.faces = 5, .boundary = true}}) {
            const LocalMatrix matrix = local_matrix(*v.scheme, shape, v.options);
            const FanLattice lattice = fan_lattice(*v.scheme, shape, v.options);
            const SectorFan fan(lattice, shape, fan_rings(*v.scheme, shape, v.options) + 4);
            const RuleStep step = v.scheme->step(fan.mesh, v.options);
            const std::vector<int> rows = find_fan(step.mesh, child_start(fan, step), matrix.labels);
            double off = 0;
            for (int i = 0; i < matrix.size(); ++i) {
                std::vector<double> difference(static_cast<std::size_t>(fan.labels.size()), 0.0);
                for (const auto& [point, weight] : step.stencils.row(rows[i]).terms)
                    difference[static_cast<std::size_t>(point)] = weight;
                for (const auto& [column, weight] : matrix.row(i).terms) {
                    CHECK(matrix.at(i, column) == weight);
                    difference[static_cast<std::size_t>(fan.labels.find(matrix.labels.all()[column]))] -= weight;
                }
                off = std::max(off, largest(difference));
            }
            CHECK(off < 1e-14);
        }
    }
}

TEST_CASE("at a thousand edges masks and eigenvalues are the closed forms") {
    constexpr int n = 1000;
    const double angle = 2 * std::numbers::pi / n, c = std::cos(angle);
    struct Known {
        const char* scheme;
        double lambda, centre, edge, face;  ///< of the limit, each edge's and face's
    };
    const double beta = (0.625 - std::pow(0.375 + 0.25 * c, 2)) / n, omega = 1 / (0.375 / beta + n);
    const double a = (4 - 2 * c) / 9, b = 3 * a / (1 + 3 * a);
    const double two_steps = (2 + 2 * c) / 9;
    const Known known[] = {
        {"loop", 0.375 + 0.25 * c, 1 - n * omega, omega, 0},
        {"sqrt3", two_steps, 1 - b, b / n, 0},
        {"catmull-clark", (5 + c + std::sqrt((c + 9) * (c + 1))) / 16, n / (n + 5.0), 4 / (n * (n + 5.0)),
         1 / (n * (n + 5.0))},
        {"doo-sabin", 0.5, 0, 1.0 / n, 0},
    };
    for (const auto& [name, lambda, centre, edge, face] : known) {
        CAPTURE(name);
        const SpectralAnalysis an = analyse(*find_scheme(name), {.faces = n}, {});
        const FanLabels& labels = an.matrix.labels;
        const bool dual = labels.lattice() == FanLattice::dual;
        CHECK(an.lambda1 == doctest::Approx(lambda).epsilon(1e-12));
        CHECK(sum(an.limit) == doctest::Approx(1).epsilon(1e-12));
        REQUIRE(an.tangent1.size() == an.limit.size());
        if (!dual) CHECK(an.limit[0] == doctest::Approx(centre).epsilon(1e-10));
        const double first = an.tangent1[labels.find(dual ? FanLabel{0, 0, 0} : FanLabel{0, 1, 0})];
        double off = 0;
        for (int s = 0; s < n; ++s) {
            const int e = labels.find(dual ? FanLabel{s, 0, 0} : FanLabel{s, 1, 0});
            off = std::max(
                {off, n * std::abs(an.limit[e] - edge), std::abs(an.tangent1[e] - first * std::cos(s * angle))});
            if (face == 0) continue;
            off = std::max(off, n * std::abs(an.limit[labels.find({s, 1, 1})] - face));
        }
        CHECK(off < 1e-9);
        // A row is the same turned: Doo and Sabin's weights from the far side of the face.
        if (!dual) continue;
        for (const int s : {0, 1, 499, 999}) {
            const double expected = (3 + 2 * std::cos((s - 500) * angle)) / (4.0 * n);
            CHECK(an.matrix.at(labels.find({500, 0, 0}), labels.find({s, 0, 0})) ==
                  doctest::Approx(expected).epsilon(1e-12));
        }
    }
}

TEST_CASE("at boundaries of many edges sine modes and bands give what the whole matrix does") {
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
            detail::DenseMatrix<double> whole(a.matrix.size());
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
    for (const auto& [name, faces] : {std::pair{"loop", 300}, {"catmull-clark", 80}}) {
        CAPTURE(name);
        check_masks({name, find_scheme(name)}, {.faces = faces, .boundary = true});
    }
    // Loop's edges are a second difference: the largest eigenvalue inside is that of half a sine.
    const SpectralAnalysis loop = analyse(*find_scheme("loop"), {.faces = 999, .boundary = true}, {});
    CHECK(loop.lambda1 == doctest::Approx(0.5).epsilon(1e-12));
    CHECK(loop.lambda2 == doctest::Approx(0.375 + 0.25 * std::cos(std::numbers::pi / 999)).epsilon(1e-12));
    CHECK(loop.limit[0] == doctest::Approx(2.0 / 3).epsilon(1e-12));
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

TEST_CASE("honeycomb: the two faces along the boundary map to themselves as their matrix says, in any mesh") {
    RuleMesh::Builder faces;
    faces.face({0, 1, 2, 3, 4});
    faces.face({4, 3, 5});
    faces.face({3, 2, 6, 7, 8, 9, 5});
    RuleMesh mesh(10, std::move(faces));
    const SchemeInfo& scheme = *find_scheme("honeycomb");
    const SpectralAnalysis a = analyse(scheme, {.faces = 2, .boundary = true}, {});
    // Twice the weights of a pentagon's corners among themselves, and the cubic spline along the boundary.
    const double w1 = (3 + 2 * std::cos(2 * std::numbers::pi / 5)) / 20,
                 w2 = (3 + 2 * std::cos(4 * std::numbers::pi / 5)) / 20, mean = (w1 + w2) / 2,
                 root = std::sqrt(mean * mean - w2 * (w1 - w2));
    const double expected[] = {1, 0.5, 0.25, mean + root, mean + root, 0.125, 0.125, mean - root, mean - root};
    REQUIRE(a.eigenvalues.size() == std::size(expected));
    for (std::size_t i = 0; i < std::size(expected); ++i) CHECK(std::abs(a.eigenvalues[i].value - expected[i]) < 1e-12);
    CHECK_FALSE(a.proper);

    std::vector<double> values;
    for (int v = 0; v < mesh.vertex_count(); ++v) values.push_back(std::sin(3.7 * v));
    const auto around = [&](const RuleMesh& of, const std::vector<double>& from, int v) {
        std::vector<double> result;
        const int start = of.first(v);
        for (const int i : find_fan(of, std::span(&start, 1), a.matrix.labels)) result.push_back(from[i]);
        return result;
    };
    std::vector<int> looked_at;
    for (int level = 0; level < 5; ++level) {
        RuleStep step = scheme.step(mesh, {});
        std::vector<double> finer(step.mesh.vertex_count());
        step.stencils.apply<double>(values, finer);
        // After two steps the faces are pentagons, after three they have no edge in common.
        for (const int v : looked_at) {
            const std::vector<double> before = around(mesh, values, v), after = around(step.mesh, finer, v);
            for (int i = 0; i < a.matrix.size(); ++i) {
                double sum = 0;
                for (int j = 0; j < a.matrix.size(); ++j) sum += a.matrix.at(i, j) * before[j];
                CHECK(std::abs(sum - after[i]) < 1e-14);
            }
        }
        mesh = std::move(step.mesh);
        values = std::move(finer);
        if (level == 1)
            for (int v = 0; v < mesh.vertex_count(); ++v)
                if (mesh.on_boundary(v) && mesh.ring(v).faces() > 1) looked_at.push_back(v);
    }
    CHECK(looked_at.size() > 10);
}

TEST_CASE("the same at corners that copies of the boundary or dual faces surround") {
    for (const Variant& v : variants()) {
        CAPTURE(v.name);
        const bool dual = fan_lattice(*v.scheme, v.options) == FanLattice::dual;
        if (v.scheme->family == MeshFamily::hexagons || (!dual && v.scheme->name != "averaging")) continue;
        for (int K = 1; K <= (dual ? 1 : 6); ++K) {
            CAPTURE(K);
            check_masks(v, {.faces = K, .boundary = true, .corner = true});
        }
    }
}

TEST_SUITE_END();
