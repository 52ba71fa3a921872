#include "../kit/nearest.hpp"
#include "../kit/random_mesh.hpp"
#include "../kit/scheme_meshes.hpp"

#include "../../hier/base/error.hpp"
#include "../../refine/uniform/refine.hpp"
#include "../../schemes/analysis/spectrum.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <numbers>
#include <numeric>
#include <optional>
#include <set>
#include <span>
#include <stdexcept>
#include <string_view>
#include <utility>
#include <vector>

// Weights of the schemes: values of the papers, properties of all schemes, and consequences for the limits.

using namespace tetrakis;

namespace {

double sum(const std::vector<double>& w) { return std::accumulate(w.begin(), w.end(), 0.0); }

double largest(const std::vector<double>& w) {
    double most = 0;
    for (const double x : w) most = std::max(most, std::abs(x));
    return most;
}

/// The product l S of a row and a matrix.
std::vector<double> product(const std::vector<double>& l, const LocalMatrix& s) {
    std::vector<double> x(l.size(), 0.0);
    for (int i = 0; i < s.size(); ++i)
        for (int j = 0; j < s.size(); ++j) x[j] += l[i] * s.at(i, j);
    return x;
}

/// Largest component of l S - lambda l, for l scaled to a largest weight of one.
double residual(const std::vector<double>& l, const LocalMatrix& s, double lambda) {
    std::vector<double> x = product(l, s);
    for (int j = 0; j < s.size(); ++j) x[j] -= lambda * l[j];
    return largest(x) / largest(l);
}

/// The lambda for which l S - lambda l is smallest (least squares).
double eigenvalue(const std::vector<double>& l, const LocalMatrix& s) {
    const std::vector<double> x = product(l, s);
    return std::inner_product(x.begin(), x.end(), l.begin(), 0.0) /
           std::inner_product(l.begin(), l.end(), l.begin(), 0.0);
}

/// Distance of two vectors after scaling both to a largest weight of one and to the same sign.
double difference(const std::vector<double>& a, const std::vector<double>& b) {
    double dot = 0, most = 0;
    for (std::size_t i = 0; i < a.size(); ++i) dot += a[i] * b[i];
    const double p = 1 / largest(a), q = (dot < 0 ? -1 : 1) / largest(b);
    for (std::size_t i = 0; i < a.size(); ++i) most = std::max(most, std::abs(p * a[i] - q * b[i]));
    return most;
}

/// Checks the masks of scheme_masks() for a shape against its subdivision matrix.
void check_masks(const test::SchemeVariant& v, const FanShape& shape) {
    const SpectralAnalysis a = analyse(*v.scheme, shape, v.options);
    double off = 0;
    for (int i = 0; i < a.matrix.size(); ++i) {
        double row = -1;
        for (int j = 0; j < a.matrix.size(); ++j) row += a.matrix.at(i, j);
        off = std::max(off, std::abs(row));
    }
    CHECK(off < 1e-13);
    const SchemeMasks masks = scheme_masks(*v.scheme, a, v.options);
    // The error of a left eigenvector is the rounding error over the distance to the nearest other eigenvalue.
    constexpr double k_tolerance = 1e-9;
    CHECK(sum(masks.limit) == doctest::Approx(1).epsilon(1e-12));
    CHECK(residual(masks.limit, a.matrix, 1) < k_tolerance);
    CHECK(difference(masks.limit, a.limit) < k_tolerance);
    const auto check_tangent = [&](const std::vector<double>& mask, const std::vector<double>& numeric, double lambda,
                                   bool is_formula) {
        if (mask.empty()) return;
        CHECK(std::abs(sum(mask)) < 1e-10 * largest(mask));
        const double own = is_formula ? eigenvalue(mask, a.matrix) : lambda;
        CHECK(residual(mask, a.matrix, own) < k_tolerance);
        // Without a tangent plane (plain rules, many faces) the mode along the boundary is not dominant.
        if (!is_formula || !a.proper) return;
        CHECK(own == doctest::Approx(lambda).epsilon(1e-7));
        if (!numeric.empty()) CHECK(difference(mask, numeric) < 1e-7);
    };
    check_tangent(masks.tangent1, a.tangent1, a.lambda1, masks.tangent1_is_formula);
    check_tangent(masks.tangent2, a.tangent2, a.lambda2, masks.tangent2_is_formula);
}

ControlMesh random_mesh_for(const SchemeInfo& scheme, std::uint64_t seed) {
    test::RandomMeshOptions options = test::random_options(seed);
    options.columns = options.rows = 3;
    options.triangles_only = scheme.family == MeshFamily::triangles;
    return test::random_mesh(seed, options);
}

std::optional<RefinedStencils> stencils(const ControlMesh& mesh, const SchemeInfo& scheme, int level, bool limit) {
    try {
        return refine_stencils(mesh, scheme, level, {.limit = limit});
    } catch (const Error& e) {
        REQUIRE(e.code() == ErrorCode::unsupported);
        return std::nullopt;
    }
}

using Weights = std::vector<double>;

Weights ascending(std::span<const double> weights, double unit) {
    Weights result;
    // In multiples of `unit`, which are integers.
    for (const double w : weights) result.push_back(std::round(w / unit * 1e6) / 1e6);
    std::sort(result.begin(), result.end());
    return result;
}

Weights products(const Weights& a, const Weights& b) {
    Weights result;
    for (const double x : a)
        for (const double y : b) result.push_back(x * y);
    std::sort(result.begin(), result.end());
    return result;
}

}  // namespace

TEST_SUITE_BEGIN("contract");

TEST_CASE("masks: all rows of weights sum to one, with boundaries, holes, creases and corners, in the limit too") {
    for (const SchemeInfo& scheme : scheme_table())
        for (const std::uint64_t seed : test::seeds(6))
            for (const bool limit : {false, true}) {
                CAPTURE(scheme.name);
                CAPTURE(seed);
                CAPTURE(limit);
                const auto refined = stencils(random_mesh_for(scheme, seed), scheme, limit ? 1 : 2, limit);
                if (!refined) continue;
                double off = 0;
                for (int r = 0; r < refined->stencils.row_count(); ++r) {
                    const std::span<const double> w = refined->stencils.weights(r);
                    off = std::max(off, std::abs(std::accumulate(w.begin(), w.end(), -1.0)));
                }
                CHECK(off < 1e-12);
                CHECK(refined->stencils.row_count() == static_cast<int>(refined->mesh.positions.size()));
            }
}

TEST_CASE("masks: interpolating schemes keep the control points bit for bit, the others do not") {
    for (const SchemeInfo& scheme : scheme_table()) {
        CAPTURE(scheme.name);
        const ControlMesh mesh = ControlMesh::build(test::skewed_grid(4));
        const PolygonMesh refined = refine(mesh, scheme, 2), limit = refine(mesh, scheme, 1, {.limit = true});
        for (const PolygonMesh* points : {&refined, &limit}) {
            const PointMatch match(points->positions);
            std::uint32_t kept = 0;
            for (const Vec3d& p : mesh.positions()) kept += points->positions[match.nearest(p)] == p ? 1 : 0;
            CHECK((kept == mesh.vertex_count()) == scheme.interpolating);
        }
    }
}

TEST_CASE("masks: polynomials on regular meshes are reproduced up to the degree in the table, and no further") {
    constexpr std::uint32_t n = 16;
    for (const SchemeInfo& scheme : scheme_table()) {
        if (scheme.family == MeshFamily::hexagons) continue;
        CAPTURE(scheme.name);
        int degree = 0;
        for (bool reproduced = true; reproduced; ++degree)
            for (int power = 0; power <= degree; ++power) {
                const auto height = [&](const Vec3d& p) {
                    return std::pow((p.x - 8) / 4, power) * std::pow((p.y - 8) / 4, degree - power);
                };
                ControlMeshData data = test::grid(n, scheme.family == MeshFamily::triangles);
                for (Vec3d& p : data.positions) p.z = height(p);
                const PolygonMesh refined = refine(ControlMesh::build(std::move(data)), scheme, 1);
                int compared = 0;
                for (const Vec3d& p : refined.positions) {
                    if (std::max(std::abs(p.x - 8), std::abs(p.y - 8)) > 2.1) continue;
                    ++compared;
                    if (std::abs(p.z - height(p)) > 1e-12) reproduced = false;
                }
                CHECK(compared >= 16);
            }
        // The loop ended at the first degree that is not reproduced.
        CHECK(degree - 2 == scheme.reproduction);
    }
}

TEST_CASE("masks: on regular meshes the rows are those of the papers and no others") {
    // Rows of new vertices, edge points and face points, or of all points of dual schemes, in multiples of `unit`.
    struct Known {
        std::string_view scheme;
        double unit;
        std::set<Weights> rows;
        RuleOptions rules{};
    };
    const Weights four_point{-1, -1, 9, 9};
    const Known known[] = {
        {"loop", 1.0 / 16, {{1, 1, 1, 1, 1, 1, 10}, {2, 2, 6, 6}}},
        {"tuned-loop", 1.0 / 16, {{1, 1, 1, 1, 1, 1, 10}, {2, 2, 6, 6}}},
        {"midpoint", 1.0 / 2, {{2}, {1, 1}}},
        {"butterfly", 1.0 / 16, {{16}, {-1, -1, -1, -1, 2, 2, 8, 8}}},
        {"modified-butterfly", 1.0 / 16, {{16}, {-1, -1, -1, -1, 2, 2, 8, 8}}},
        {"butterfly", 1.0 / 64, {{64}, {-5, -5, -5, -5, 1, 1, 10, 10, 31, 31}}, {.butterfly_w = 1.0 / 64}},
        {"modified-butterfly", 1.0 / 64, {{64}, {-5, -5, -5, -5, 1, 1, 10, 10, 31, 31}}, {.butterfly_w = 1.0 / 64}},
        {"catmull-clark", 1.0 / 64, {{1, 1, 1, 1, 6, 6, 6, 6, 36}, {4, 4, 4, 4, 24, 24}, {16, 16, 16, 16}}},
        {"bilinear", 1.0 / 4, {{4}, {2, 2}, {1, 1, 1, 1}}},
        {"kobbelt", 1.0 / 256, {{256}, {-16, -16, 144, 144}, products(four_point, four_point)}},
        {"doo-sabin", 1.0 / 16, {{1, 3, 3, 9}}},
        {"doo-sabin-cc", 1.0 / 16, {{1, 3, 3, 9}}},
        {"midedge", 1.0 / 4, {{1, 1, 2}}},
        {"midedge-simplest", 1.0 / 4, {{1, 1, 2}}},
        {"biquartic", 1.0 / 256, {products({1, 5, 10}, {1, 5, 10})}},
        {"averaging", 1.0 / 256, {products({1, 5, 10}, {1, 5, 10})}},
    };
    for (const auto& [name, unit, rows, rules] : known) {
        CAPTURE(name);
        const SchemeInfo& scheme = scheme_named(name);
        ControlMeshData data = test::grid(8, scheme.family == MeshFamily::triangles, true);
        const RefinedStencils refined =
            refine_stencils(ControlMesh::build(std::move(data)), scheme, 1, {.rules = rules});
        std::set<Weights> found;
        for (int r = 0; r < refined.stencils.row_count(); ++r)
            found.insert(ascending(refined.stencils.weights(r), unit));
        CHECK(found == rows);
    }
}

TEST_CASE("[slow] masks: limits and tangents are eigenvectors of the scheme's matrix, at boundaries and corners too") {
    for (const test::SchemeVariant& v : test::scheme_variants()) {
        CAPTURE(v.name);
        for (const int n : {3, 4, 5, 6, 7, 8, 9, 12, 16, 31}) {
            CAPTURE(n);
            check_masks(v, {.faces = n});
        }
        for (const int K : {1, 2, 3, 4, 5, 6, 7, 8, 12, 16}) {
            if (v.scheme->rings > 2 && K > 6) continue;
            CAPTURE(K);
            check_masks(v, {.faces = K, .boundary = true});
        }
        // Corners surrounded by dual faces or, for averaging, by copies of the boundary.
        const bool dual = fan_lattice(*v.scheme, v.options) == FanLattice::dual;
        if (v.scheme->family == MeshFamily::hexagons || (!dual && v.scheme->name != "averaging")) continue;
        for (int K = 1; K <= (dual ? 1 : 6); ++K) {
            CAPTURE(K);
            check_masks(v, {.faces = K, .boundary = true, .corner = true});
        }
    }
    for (const auto& [name, faces] : {std::pair{"loop", 300}, {"catmull-clark", 80}}) {
        CAPTURE(name);
        check_masks({name, find_scheme(name)}, {.faces = faces, .boundary = true});
    }
    // Loop's edge rules are a second difference along the ring: the largest inner eigenvalue is that of half a sine.
    const SpectralAnalysis loop = analyse(*find_scheme("loop"), {.faces = 999, .boundary = true}, {});
    CHECK(loop.lambda1 == doctest::Approx(0.5).epsilon(1e-12));
    CHECK(loop.lambda2 == doctest::Approx(0.375 + 0.25 * std::cos(std::numbers::pi / 999)).epsilon(1e-12));
    CHECK(loop.limit[0] == doctest::Approx(2.0 / 3).epsilon(1e-12));
}

TEST_CASE(
    "masks: at two edges inside they are eigenvectors, and what a half turn or the mirror does to the matrix changes "
    "nothing") {
    for (const test::SchemeVariant& v : test::scheme_variants()) {
        CAPTURE(v.name);
        const FanShape shape{.faces = 2};
        if (fan_lattice(*v.scheme, v.options) == FanLattice::dual) {
            CHECK_THROWS_AS(analyse(*v.scheme, shape, v.options), std::invalid_argument);
            continue;
        }
        // The ten-point rule uses different points from the two sides of a regular edge here.
        if (v.options.butterfly_w != 0) continue;
        const bool weights = v.options.catmull_clark_beta.has_value();
        if (weights) continue;  // refused: with such weights there is no tangent plane here
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
    // By hand: an edge of Loop takes 3/8 of the vertex, 3/8 of its end, and 2/8 of the other edge's end.
    const SpectralAnalysis loop = analyse(*find_scheme("loop"), {.faces = 2}, {});
    CHECK(loop.lambda1 == doctest::Approx(1.0 / 8).epsilon(1e-12));
    CHECK(loop.lambda2 == doctest::Approx(1.0 / 8).epsilon(1e-12));
    CHECK(loop.limit[0] == doctest::Approx(8.0 / 21).epsilon(1e-12));
    const SpectralAnalysis quads = analyse(*find_scheme("catmull-clark"), {.faces = 2}, {});
    CHECK(quads.lambda1 == doctest::Approx(1.0 / 4).epsilon(1e-12));
    CHECK(quads.third == doctest::Approx(1.0 / 4).epsilon(1e-12));
    CHECK(analyse(*find_scheme("midpoint"), {.faces = 2}, {}).third == doctest::Approx(0.5));
}

TEST_CASE("[slow] masks: around vertices and faces of any number of edges they and eigenvalues are closed forms") {
    for (const int n : {3, 4, 5, 6, 7, 8, 9, 12, 33, 100, 1000}) {
        CAPTURE(n);
        const double angle = 2 * std::numbers::pi / n, c = std::cos(angle);
        // Weights of the middle vertex, of each edge's end and of each quad's opposite corner.
        struct Around {
            double centre, edge, face;
        };
        struct Known {
            const char* scheme;
            double lambda;
            Around limit;
            std::optional<Around> level = std::nullopt;  ///< rule of one level, if the matrix is of one level
            RuleOptions rules{};
        };
        const auto loop = [&](double beta) {
            const double omega = 1 / (0.375 / beta + n);
            return std::pair(Around{1 - n * omega, omega, 0}, Around{1 - n * beta, beta, 0});
        };
        const auto [loop_limit, loop_level] = loop((0.625 - std::pow(0.375 + 0.25 * c, 2)) / n);
        const auto [warren_limit, warren_level] = loop(n == 3 ? 3.0 / 16 : 3.0 / (8 * n));
        const double a = (4 - 2 * c) / 9, b = 3 * a / (1 + 3 * a), m = n;
        const Known known[] = {
            {"loop", 0.375 + 0.25 * c, loop_limit, loop_level},
            {"loop", 0.375 + 0.25 * c, warren_limit, warren_level, {.loop_weights = LoopWeights::warren}},
            {"sqrt3", (2 + 2 * c) / 9, {1 - b, b / n, 0}},
            {"catmull-clark",
             (5 + c + std::sqrt((c + 9) * (c + 1))) / 16,
             {m / (m + 5), 4 / (m * (m + 5)), 1 / (m * (m + 5))},
             Around{1 - 7 / (4 * m), 1.5 / (m * m), 0.25 / (m * m)}},
            {"doo-sabin", 0.5, {0, 1 / m, 0}},
        };
        for (const auto& [name, lambda, limit, level, rules] : known) {
            CAPTURE(name);
            const SpectralAnalysis an = analyse(*find_scheme(name), {.faces = n}, rules);
            const FanLabels& labels = an.matrix.labels;
            const bool dual = labels.lattice() == FanLattice::dual;
            CHECK(an.lambda1 == doctest::Approx(lambda).epsilon(1e-12));
            CHECK(sum(an.limit) == doctest::Approx(1).epsilon(1e-12));
            REQUIRE(an.tangent1.size() == an.limit.size());
            if (!dual) CHECK(an.limit[0] == doctest::Approx(limit.centre).epsilon(1e-10));
            if (level) CHECK(an.matrix.at(0, 0) == doctest::Approx(level->centre).epsilon(1e-12));
            const double first = an.tangent1[labels.find(dual ? FanLabel{0, 0, 0} : FanLabel{0, 1, 0})];
            double off = 0;
            for (int s = 0; s < n; ++s) {
                const int e = labels.find(dual ? FanLabel{s, 0, 0} : FanLabel{s, 1, 0});
                off = std::max({off, n * std::abs(an.limit[e] - limit.edge),
                                std::abs(an.tangent1[e] - first * std::cos(s * angle))});
                if (level) off = std::max(off, n * std::abs(an.matrix.at(0, e) - level->edge));
                if (limit.face == 0) continue;
                const int f = labels.find({s, 1, 1});
                off = std::max(
                    {off, n * std::abs(an.limit[f] - limit.face), n * std::abs(an.matrix.at(0, f) - level->face)});
            }
            CHECK(off < 1e-9);
            // Doo and Sabin's weights, counted from the corner that is nearest to the point.
            if (!dual) continue;
            const int own = n / 2;
            for (const int s : {0, 1, own, n - 1}) {
                const double expected = s == own ? 0.25 + 1.25 / n : (3 + 2 * std::cos((s - own) * angle)) / (4.0 * n);
                CHECK(an.matrix.at(labels.find({own, 0, 0}), labels.find({s, 0, 0})) ==
                      doctest::Approx(expected).epsilon(1e-12));
            }
        }
    }
}

TEST_CASE("masks: the table's degrees are those of the rules, and supports those of the literature") {
    const std::map<std::string_view, double> supports = {{"loop", 2},
                                                         {"tuned-loop", 2},
                                                         {"butterfly", 3},
                                                         {"modified-butterfly", 3},
                                                         {"midpoint", 1},
                                                         {"catmull-clark", 2},
                                                         {"kobbelt", 3},
                                                         {"bilinear", 1},
                                                         {"4-8", 3},
                                                         {"doo-sabin", 1.5},
                                                         {"doo-sabin-cc", 1.5},
                                                         {"midedge", 1.5},
                                                         {"midedge-simplest", 1.5},
                                                         {"biquartic", 2.5},
                                                         {"honeycomb", 3}};
    for (const SchemeInfo& scheme : scheme_table()) {
        CAPTURE(scheme.name);
        CHECK(reproduction_degree(scheme, {}) == scheme.reproduction);
        if (supports.contains(scheme.name))
            CHECK(support_radius(scheme, {}) == doctest::Approx(supports.at(scheme.name)));
    }
}

TEST_CASE("masks: subdominant and third eigenvalues are those of the literature") {
    struct Case {
        const char* scheme;
        int valence;
        double lambda, third;
    };
    // Four digits from an independent program. Closed forms are tested elsewhere.
    const Case cases[] = {
        {"kobbelt", 3, .4263, .25},   {"kobbelt", 5, .5379, .3619}, {"kobbelt", 16, .6046, .5821},
        {"biquartic", 3, .3966, .25}, {"biquartic", 8, .6639, .5},  {"biquartic", 16, .7202, .6639},
        {"4-8", 3, .4083, .25},       {"4-8", 6, .5819, .4083},     {"4-8", 16, .6474, .6142},
        {"doo-sabin", 9, .5, .25},    {"midedge", 9, .5, .25},      {"modified-butterfly", 9, .5, .25},
        {"tuned-loop", 9, .5, .25},   {"tuned-loop", 30, .5, .25}};
    for (const Case& c : cases) {
        CAPTURE(c.scheme);
        CAPTURE(c.valence);
        const SpectralAnalysis a = analyse(*find_scheme(c.scheme), {.faces = c.valence}, {});
        CHECK(a.lambda1 == doctest::Approx(c.lambda).epsilon(2e-4));
        CHECK(a.third == doctest::Approx(c.third).epsilon(2e-4));
        CHECK(a.proper);
    }
    CHECK(analyse(*find_scheme("loop"), {.faces = 6}, {}).curvature == CurvatureClass::bounded);
    CHECK(analyse(*find_scheme("loop"), {.faces = 9}, {}).curvature == CurvatureClass::unbounded);
    CHECK(analyse(*find_scheme("catmull-clark"), {.faces = 5}, {}).curvature == CurvatureClass::unbounded);
    CHECK(analyse(*find_scheme("doo-sabin"), {.faces = 5}, {}).curvature == CurvatureClass::bounded);
    // The original Butterfly is not smooth at valence 3, midpoint at no extraordinary vertex.
    CHECK_FALSE(analyse(*find_scheme("butterfly"), {.faces = 3}, {}).proper);
    CHECK_FALSE(analyse(*find_scheme("midpoint"), {.faces = 5}, {}).proper);
}

TEST_CASE("masks: boundary vertices have a tangent plane wherever the scheme's rules are made for it") {
    struct Case {
        const char* scheme;
        EdgeBesideCrease rule;
        int first, last;          ///< faces at the vertex
        double lambda1, lambda2;  ///< 0: any value
    };
    constexpr auto plain = EdgeBesideCrease::plain, cosine = EdgeBesideCrease::cosine, brief = EdgeBesideCrease::brief;
    const Case cases[] = {{"loop", plain, 2, 5, .5, 0},
                          {"loop", cosine, 2, 16, .5, .5},
                          {"loop", brief, 2, 16, .5, 0},
                          {"catmull-clark", plain, 2, 3, .5, 0},
                          {"catmull-clark", cosine, 2, 16, .5, .5},
                          {"catmull-clark", brief, 2, 16, .5, 0},
                          {"modified-butterfly", plain, 2, 9, .5, .5},
                          {"kobbelt", plain, 2, 9, .5, .5},
                          {"4-8", plain, 2, 3, .5, 0},
                          {"sqrt3", plain, 2, 5, 1.0 / 3, 0},
                          {"tuned-loop", cosine, 2, 16, .5, .5},
                          {"biquartic", plain, 4, 4, .5, .25}};  // splines_test checks its tangents
    for (const Case& c : cases)
        for (int K = c.first; K <= c.last; ++K) {
            CAPTURE(c.scheme);
            CAPTURE(K);
            const SpectralAnalysis a =
                analyse(*find_scheme(c.scheme), {.faces = K, .boundary = true}, {.edge_beside_crease = c.rule});
            CHECK(a.proper);
            CHECK(a.lambda1 == doctest::Approx(c.lambda1));
            if (c.lambda2 > 0) CHECK(a.lambda2 == doctest::Approx(c.lambda2));
        }
    // With one more face, the plain rules have no tangent plane.
    CHECK_FALSE(analyse(*find_scheme("loop"), {.faces = 6, .boundary = true}, {}).proper);
    CHECK_FALSE(analyse(*find_scheme("catmull-clark"), {.faces = 4, .boundary = true}, {}).proper);
    // Two modes across the boundary have equal eigenvalues: midedge's are both 1/4.
    CHECK_FALSE(analyse(*find_scheme("midedge"), {.faces = 4, .boundary = true}, {}).proper);
}

TEST_SUITE_END();
