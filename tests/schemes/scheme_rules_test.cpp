#include "../../schemes/analysis/spectrum.hpp"
#include "../../schemes/core/sharpness.hpp"
#include "../../schemes/curves/curve.hpp"
#include "../../schemes/rules/catmull_clark.hpp"
#include "../../schemes/rules/modified_butterfly.hpp"

#include <doctest/doctest.h>
#include <glm/geometric.hpp>

#include <cmath>
#include <numbers>
#include <set>
#include <stdexcept>
#include <string>
#include <vector>

using namespace tetrakis;

namespace {

// Before main(), in whatever order the files are initialised.
const std::size_t k_length_of_notes = [] {
    std::size_t length = 0;
    for (const SchemeInfo& scheme : scheme_table()) length += scheme.notes.size();
    return length;
}();
const SchemeInfo* const k_last_at_start = find_scheme("honeycomb");

/// A ring of columns x rows vertices, closed along the rows, with faces between the first columns alone.
RuleMesh tube(bool triangles, int columns, int rows, int faces_to) {
    RuleMesh::Builder faces;
    const auto vertex = [&](int i, int j) { return (i % columns) * rows + j % rows; };
    for (int i = 0; i < faces_to; ++i)
        for (int j = 0; j < rows; ++j) {
            const int a = vertex(i, j), b = vertex(i + 1, j), c = vertex(i + 1, j + 1), d = vertex(i, j + 1);
            if (triangles) {
                faces.face({a, b, c});
                faces.face({a, c, d});
            } else {
                faces.face({a, b, c, d});
            }
        }
    return RuleMesh(faces_to < columns ? (faces_to + 1) * rows : columns * rows, std::move(faces));
}

using Row = std::vector<std::pair<int, long long>>;

/// Weights to twelve digits, so that rows compare.
Row row_of(const StencilTable& table, int r) {
    Row row;
    for (std::size_t i = 0; i < table.points(r).size(); ++i) {
        const long long w = std::llround(table.weights(r)[i] * 1e12);
        if (w != 0) row.emplace_back(table.points(r)[i], w);
    }
    return row;
}

int euler(const RuleMesh& m) { return m.vertex_count() - m.edge_count() + m.face_count(); }

int boundary_edges(const RuleMesh& m) {
    int count = 0;
    for (int h = 0; h < m.halfedge_count(); ++h) count += m.twin(h) == RuleMesh::none ? 1 : 0;
    return count;
}

}  // namespace

TEST_SUITE_BEGIN("schemes");

TEST_CASE("the table is whole before the program starts, and its entries stay where they are") {
    std::size_t length = 0;
    std::set<std::string_view> names;
    for (const SchemeInfo& scheme : scheme_table()) {
        CAPTURE(scheme.name);
        length += scheme.notes.size();
        CHECK(names.insert(scheme.name).second);
        CHECK(find_scheme(scheme.name) == &scheme);
        CHECK(nearest_scheme_name(scheme.name) == scheme.name);
        CHECK(bool(scheme.step));
        CHECK(bool(scheme.closed_masks));
    }
    CHECK(names.size() == scheme_table().size());
    CHECK(length == k_length_of_notes);
    REQUIRE(k_last_at_start != nullptr);
    CHECK(k_last_at_start == find_scheme("honeycomb"));
    CHECK(find_scheme("loops") == nullptr);
}

TEST_CASE("beside a nearly smooth edge a Chaikin crease that ends has more than its whole weight, once") {
    CHECK(edge_crease_weight(1.25f, 0, 0.5f) == 1.25);
    CHECK(edge_crease_weight(0.9f, 0.1f, 0.2f) == 1);  // a sharp neighbour keeps both halves sharp
}

TEST_CASE("corners of any angle have the two edges as tangents, concave ones too") {
    for (const char* name : {"loop", "catmull-clark"})
        for (int K = 2; K <= 9; ++K)
            for (const double angle : {0.4, 1.5, 2.8, 3.6, 4.4, 5.5}) {
                CAPTURE(name);
                CAPTURE(K);
                CAPTURE(angle);
                RuleOptions options{.edge_beside_crease = EdgeBesideCrease::cosine};
                options.corner_angle = angle;
                const FanShape shape{.faces = K, .boundary = true, .corner = true};
                const SpectralAnalysis a = analyse(*find_scheme(name), shape, options);
                CHECK(a.lambda1 == doctest::Approx(0.5));
                CHECK(a.lambda2 == doctest::Approx(0.5));
                CHECK(a.third < 0.5 - 1e-3);
                // The same where the corner has the angle of its own, whatever the number for all.
                FanShape own = shape;
                own.angle = angle;
                const SchemeInfo& scheme = *find_scheme(name);
                RuleOptions other = options;
                for (const double for_all : {0.0, 1.0}) {
                    other.corner_angle = for_all;
                    CHECK(analyse(scheme, own, other).matrix.rows == a.matrix.rows);
                    CHECK(scheme.closed_masks(own, other).tangent2 == scheme.closed_masks(shape, options).tangent2);
                }
                other.corner_angle = 0;
                // Without an angle two triangles have a tangent plane, too.
                CHECK(scheme.closed_masks(shape, other).tangent2.empty() !=
                      (K == 2 && std::string_view(name) == "loop"));
                CHECK(analyse(scheme, shape, other).matrix.rows != a.matrix.rows);
                if (angle > std::numbers::pi) CHECK(a.third < 0.25 + 1e-9);
                // p_0 - c and p_K - c are left eigenvectors.
                for (const int ray : {0, K}) {
                    const int c = a.matrix.labels.find({}), p = a.matrix.labels.find({ray, 1, 0});
                    for (int j = 0; j < a.matrix.size(); ++j)
                        CHECK(std::abs(a.matrix.at(p, j) - a.matrix.at(c, j) - 0.5 * ((j == p) - (j == c))) < 1e-13);
                }
            }
    CHECK_THROWS_AS(find_scheme("loop")->step(tube(true, 5, 4, 5), {.corner_angle = 7}), std::invalid_argument);
}

TEST_CASE("other Catmull-Clark weights are refused exactly where the spectrum fails") {
    const SchemeInfo& scheme = *find_scheme("catmull-clark");
    for (const int n : {3, 5, 9}) {
        const auto corners = catmull_clark_weight_range(n);
        const double middle[] = {(corners[0][0] + corners[1][0] + corners[2][0]) / 3,
                                 (corners[0][1] + corners[1][1] + corners[2][1]) / 3};
        for (int side = 0; side < 3; ++side) {
            const auto& p = corners[side];
            const auto& q = corners[(side + 1) % 3];
            for (const double out : {0.98, 1.02}) {
                RuleOptions options;
                options.catmull_clark_beta = middle[0] + out * ((p[0] + q[0]) / 2 - middle[0]);
                options.catmull_clark_gamma = middle[1] + out * ((p[1] + q[1]) / 2 - middle[1]);
                CAPTURE(n);
                CAPTURE(side);
                if (out < 1)
                    CHECK(analyse(scheme, {.faces = n}, options).third <
                          analyse(scheme, {.faces = n}, options).lambda1);
                else
                    CHECK_THROWS_WITH_AS(analyse(scheme, {.faces = n}, options),
                                         doctest::Contains("inside the triangle"), std::invalid_argument);
            }
        }
    }
}

TEST_CASE("averaging without copies of the boundary uses up the outer ring") {
    for (const int m : {1, 2, 3, 4}) {
        CAPTURE(m);
        RuleOptions options;
        options.averaging_steps = m;
        options.averaging_boundary = AveragingBoundary::recede;
        const RuleMesh mesh = tube(false, 9, 6, 6);
        const RuleStep step = find_scheme("averaging")->step(mesh, options);
        CHECK(euler(step.mesh) == 0);
        CHECK(boundary_edges(step.mesh) == 24);
        // Rows agree with those of the replicated boundary wherever that does not matter.
        options.averaging_boundary = AveragingBoundary::replicate;
        const RuleStep whole = find_scheme("averaging")->step(mesh, options);
        std::set<Row> rows;
        for (int r = 0; r < whole.stencils.row_count(); ++r) rows.insert(row_of(whole.stencils, r));
        int missing = 0;
        for (int r = 0; r < step.stencils.row_count(); ++r) missing += rows.contains(row_of(step.stencils, r)) ? 0 : 1;
        CHECK(missing == 0);
        CHECK(step.stencils.row_count() < whole.stencils.row_count());
    }
    RuleOptions options;
    options.averaging_boundary = AveragingBoundary::recede;
    CHECK_THROWS_AS(find_scheme("biquartic")->step(tube(false, 9, 6, 1), options), std::invalid_argument);
}

TEST_CASE("[bad-input] what a scheme or a rule mesh cannot take is refused with the reason") {
    CHECK_THROWS_WITH_AS(find_scheme("loop")->step(tube(false, 5, 4, 5), {}), doctest::Contains("has 4 corners"),
                         std::invalid_argument);
    CHECK_THROWS_WITH_AS(analyse(*find_scheme("loop"), {.faces = 1}, {}), doctest::Contains("at least two edges"),
                         std::invalid_argument);
    CHECK_THROWS_AS(analyse(*find_scheme("honeycomb"), {.faces = 6, .corner = true}, {}), std::invalid_argument);
    CHECK(find_scheme("nothing") == nullptr);
    CHECK(nearest_scheme_name("catmul-clarck") == "catmull-clark");
    CHECK(nearest_scheme_name("doosabin") == "doo-sabin");
    CHECK(nearest_scheme_name("cattmull") == "catmull-clark");
    CHECK(nearest_scheme_name("Biquartics") == "biquartic");
    CHECK(nearest_scheme_name("lop") == "loop");
    const auto mesh = [](int vertices, std::vector<std::vector<int>> polygons) {
        RuleMesh::Builder faces;
        for (const auto& polygon : polygons) {
            for (const int v : polygon) faces.corner(v);
            faces.end_face();
        }
        return RuleMesh(vertices, std::move(faces));
    };
    CHECK_THROWS_AS(mesh(3, {{0, 1}}), std::invalid_argument);
    CHECK_THROWS_AS(mesh(3, {{0, 1, 3}}), std::invalid_argument);
    CHECK_THROWS_AS(mesh(4, {{0, 1, 2}, {0, 1, 3}}), std::invalid_argument);
    CHECK_THROWS_AS(mesh(5, {{0, 1, 2}, {1, 0, 3}, {0, 1, 4}}), std::invalid_argument);
    CHECK_THROWS_AS(mesh(5, {{0, 1, 2}, {0, 3, 4}}), std::invalid_argument);
}

TEST_SUITE_END();
