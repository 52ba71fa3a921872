#include "../../schemes/parts/sector_fan.hpp"
#include "../../schemes/rules/kobbelt.hpp"
#include "../../schemes/rules/linear.hpp"
#include "../../schemes/rules/modified_butterfly.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <limits>
#include <map>
#include <numbers>
#include <random>
#include <set>
#include <utility>
#include <vector>

// The seven kinds of edges of Modified Butterfly, each row by its numbers in the literature, and the polynomials that
// they keep. The two ways to compute a face point of Kobbelt's scheme: from the edge points of the row that goes
// through two opposite edges, or through the other two.

using namespace tetrakis;

namespace {

using std::numbers::pi;
using RowWeights = std::map<int, double>;

RowWeights weights_of(const RuleStep& step, int row) {
    RowWeights result;
    for (std::size_t i = 0; i < step.stencils.points(row).size(); ++i)
        result[step.stencils.points(row)[i]] += step.stencils.weights(row)[i];
    return result;
}

double weights_apart(const RowWeights& a, const RowWeights& b) {
    double most = 0;
    for (const auto& [point, w] : a) most = std::max(most, std::abs(w - (b.contains(point) ? b.at(point) : 0)));
    for (const auto& [point, w] : b) most = std::max(most, a.contains(point) ? 0 : std::abs(w));
    return most;
}

/// The weights of an edge's new point.
RowWeights edge_weights(const RuleMesh& mesh, const RuleStep& step, int u, int v) {
    for (int e = 0; e < mesh.edge_count(); ++e) {
        const int h = mesh.edge_halfedge(e);
        if (std::minmax(mesh.origin(h), mesh.target(h)) == std::minmax(u, v))
            return weights_of(step, mesh.vertex_count() + e);
    }
    FAIL("no such edge");
    return {};
}

void check_weights(const RowWeights& ours, const RowWeights& expected) {
    double sum = 0;
    for (const auto& [point, w] : ours) sum += w;
    CHECK(weights_apart(ours, expected) < 1e-15);
    CHECK(sum == doctest::Approx(1).epsilon(1e-14));
}

/// Steps along the lattice's two directions; the third edge of its triangles is (1, 1).
using GridPlace = std::pair<int, int>;

/// The triangles between columns x rows places, with creases along rows, from the first column to the last.
struct CreaseLine {
    int row, first, last;
};
struct TriangleGrid {
    int columns, rows;
    RuleMesh mesh;

    TriangleGrid(int c, int r, const std::vector<CreaseLine>& creases = {}) : columns(c), rows(r) {
        constexpr float k_sharp = std::numeric_limits<float>::infinity();
        RuleMesh::Builder faces;
        const auto triangle = [&](std::initializer_list<GridPlace> corners) {
            for (auto p = corners.begin(); p != corners.end(); ++p) {
                const GridPlace to = p + 1 == corners.end() ? *corners.begin() : *(p + 1);
                bool sharp = false;
                for (const CreaseLine& crease : creases)
                    sharp = sharp || (p->second == crease.row && to.second == crease.row &&
                                      std::min(p->first, to.first) >= crease.first &&
                                      std::max(p->first, to.first) <= crease.last);
                faces.corner(at(*p), sharp ? k_sharp : 0.0f);
            }
            faces.end_face();
        };
        for (int y = 0; y + 1 < rows; ++y)
            for (int x = 0; x + 1 < columns; ++x) {
                triangle({{x, y}, {x + 1, y}, {x + 1, y + 1}});
                triangle({{x, y}, {x + 1, y + 1}, {x, y + 1}});
            }
        mesh = RuleMesh(columns * rows, std::move(faces));
    }
    int at(GridPlace p) const { return p.second * columns + p.first; }
    GridPlace place(int v) const { return {v % columns, v / columns}; }
    RowWeights weights(std::initializer_list<std::pair<GridPlace, double>> of) const {
        RowWeights result;
        for (const auto& [p, w] : of) result[at(p)] += w;
        return result;
    }
    void check(const RuleStep& step, GridPlace u, GridPlace v,
               std::initializer_list<std::pair<GridPlace, double>> expected) const {
        CAPTURE(u.first);
        CAPTURE(u.second);
        CAPTURE(v.first);
        CAPTURE(v.second);
        check_weights(edge_weights(mesh, step, at(u), at(v)), weights(expected));
    }
};

/// Of an extraordinary vertex inside, for the edge to neighbour i: itself, then the ring.
std::vector<double> inner_rule(int n, int i) {
    std::vector<double> result(n + 1, 0.0);
    result[0] = 3.0 / 4;
    for (int j = 0; j < n; ++j) {
        const int away = ((j - i) % n + n) % n;
        double& s = result[1 + j];
        if (n == 3)
            s = away == 0 ? 5.0 / 12 : -1.0 / 12;
        else if (n == 4)
            s = away == 0 ? 3.0 / 8 : away == 2 ? -1.0 / 8 : 0;
        else
            s = (1.0 / 4 + std::cos(2 * pi * away / n) + std::cos(4 * pi * away / n) / 2) / n;
    }
    return result;
}

/// Of an extraordinary crease vertex with K faces, for the edge to ring point i: itself, then ring points 0 to K.
std::vector<double> crease_rule(int K, int i) {
    const double theta = pi / K, si = std::sin(i * theta), s2 = std::sin(2 * i * theta);
    std::vector<double> result{1 - std::sin(theta) * si / (K * (1 - std::cos(theta)))};
    const double end =
        std::cos(i * theta) / 4 - std::sin(2 * theta) * s2 / (4 * K * (std::cos(theta) - std::cos(2 * theta)));
    for (int j = 0; j <= K; ++j)
        result.push_back(j == 0   ? end
                         : j == K ? -end
                                  : (si * std::sin(j * theta) + s2 * std::sin(2 * j * theta) / 2) / K);
    return result;
}

/// A mesh around a vertex, and a rule of the vertex as weights of its points.
struct TriangleFan : SectorFan {
    TriangleFan(int faces, bool boundary, int rings)
        : SectorFan(FanLattice::triangles, {.faces = faces, .boundary = boundary}, rings) {}
    int point(int sector, int a, int b = 0) const { return labels.find({sector, a, b}); }
    RowWeights weights(const std::vector<double>& rule) const {
        RowWeights result{{point(0, 0), rule[0]}};
        for (std::size_t i = 1; i < rule.size(); ++i) result[point(static_cast<int>(i) - 1, 1)] += rule[i];
        return result;
    }
};

double monomial(int p, int q, double x, double y) { return std::pow(x, p) * std::pow(y, q); }

/// A face point by one of its rows.
struct FacePointRow {
    RowWeights weights;
    int extraordinary = 0;  ///< ends of the row's edges that are so
};

/// The four-point rule over the edge points of half-edge h, of the one opposite it, and of the next ones beyond both;
/// linear beyond a sharp edge.
FacePointRow face_point_row(const RuleMesh& mesh, const RuleStep& step, int h) {
    const auto opposite = [&](int g) { return mesh.next(mesh.next(g)); };
    FacePointRow row;
    const auto add = [&](int g, double weight) {
        for (const auto& [point, w] : weights_of(step, mesh.vertex_count() + mesh.edge(g)))
            row.weights[point] += weight * w;
    };
    const auto count = [&](int g) {
        for (const int v : {mesh.origin(g), mesh.target(g)})
            if (!mesh.on_boundary(v) && mesh.ring(v).edges() != 4 && mesh.sharp_neighbours(v).size() < 2)
                ++row.extraordinary;
    };
    for (const int g : {h, opposite(h)}) {
        add(g, 9.0 / 16);
        count(g);
        if (mesh.sharp(g)) {
            add(g, -2.0 / 16);
            add(opposite(g), 1.0 / 16);
        } else {
            const int beyond = opposite(mesh.twin(g));
            add(beyond, -1.0 / 16);
            count(beyond);
        }
    }
    return row;
}

struct FacePoint {
    FacePointRow rows[2];
    RowWeights ours;
};

FacePoint face_point(const RuleMesh& mesh, const RuleStep& step, int f) {
    const int h = mesh.face_begin(f);
    return {{face_point_row(mesh, step, h), face_point_row(mesh, step, h + 1)},
            weights_of(step, mesh.vertex_count() + mesh.edge_count() + f)};
}

/// Quads around vertices of all small valences, some edges sharp, for odd seeds one polygon is missing.
RuleMesh split_polyhedron(unsigned seed) {
    const std::vector<std::vector<int>> polygons = {{0, 3, 2, 1}, {4, 5, 6, 7}, {0, 1, 5, 4}, {1, 2, 6, 5},
                                                    {2, 3, 7},    {2, 7, 6},    {3, 0, 4, 7}};
    std::mt19937 random(seed);
    RuleMesh::Builder faces;
    const std::size_t missing = seed % 2 == 1 ? random() % polygons.size() : polygons.size();
    for (std::size_t f = 0; f < polygons.size(); ++f) {
        if (f == missing) continue;
        for (const int v : polygons[f])
            faces.corner(v, random() % 8 == 0 ? std::numeric_limits<float>::infinity() : 0.0f);
        faces.end_face();
    }
    return bilinear_step(RuleMesh(8, std::move(faces)), {}).mesh;
}

}  // namespace

TEST_SUITE_BEGIN("schemes");

TEST_CASE("modified butterfly: between regular vertices, one inside and one on the boundary") {
    const TriangleGrid grid(8, 8);
    const RuleStep step = modified_butterfly_step(grid.mesh, {});
    // The corner on the boundary is next to the inner vertex; beyond the other one is the boundary's other neighbour.
    // That it is the same at all such edges is seen by the polynomials below.
    grid.check(step, {3, 0}, {4, 1},
               {{{3, 0}, 3.0 / 8},
                {{4, 1}, 5.0 / 8},
                {{4, 0}, 1.0 / 16},
                {{3, 1}, 3.0 / 16},
                {{2, 0}, -1.0 / 16},
                {{5, 1}, -1.0 / 16},
                {{4, 2}, -1.0 / 8}});
}

TEST_CASE("modified butterfly: between two regular vertices of the boundary, across a corner and across a strip") {
    // The grid's corner at (7, 0) is one triangle.
    const TriangleGrid grid(8, 8);
    const RuleStep step = modified_butterfly_step(grid.mesh, {});
    grid.check(step, {6, 0}, {7, 1},
               {{{6, 0}, 1.0 / 2}, {{7, 1}, 1.0 / 2}, {{6, 1}, 1.0 / 4}, {{5, 0}, -1.0 / 8}, {{7, 2}, -1.0 / 8}});
    const TriangleGrid strip(7, 2);
    const RuleStep narrow = modified_butterfly_step(strip.mesh, {});
    for (int x = 1; x < 6; ++x) {
        if (x > 1) strip.check(narrow, {x, 0}, {x, 1}, {{{x, 0}, 1.0 / 2}, {{x, 1}, 1.0 / 2}});
        if (x < 5) strip.check(narrow, {x, 0}, {x + 1, 1}, {{{x, 0}, 1.0 / 2}, {{x + 1, 1}, 1.0 / 2}});
    }
}

TEST_CASE("modified butterfly: the four-point rule along boundaries and creases, linear beyond the end of a crease") {
    const TriangleGrid grid(8, 8);
    const RuleStep step = modified_butterfly_step(grid.mesh, {});
    const double end = 9.0 / 16, far = -1.0 / 16;
    grid.check(step, {3, 0}, {4, 0}, {{{2, 0}, far}, {{3, 0}, end}, {{4, 0}, end}, {{5, 0}, far}});
    // Round a corner that is not tagged.
    grid.check(step, {6, 0}, {7, 0}, {{{5, 0}, far}, {{6, 0}, end}, {{7, 0}, end}, {{7, 1}, far}});
    const TriangleGrid dart(9, 9, {{.row = 4, .first = 3, .last = 6}});
    const RuleStep ended = modified_butterfly_step(dart.mesh, {});
    dart.check(ended, {4, 4}, {5, 4}, {{{3, 4}, far}, {{4, 4}, end}, {{5, 4}, end}, {{6, 4}, far}});
    dart.check(ended, {3, 4}, {4, 4}, {{{3, 4}, 7.0 / 16}, {{4, 4}, 10.0 / 16}, {{5, 4}, far}});
    dart.check(ended, {5, 4}, {6, 4}, {{{4, 4}, far}, {{5, 4}, 10.0 / 16}, {{6, 4}, 7.0 / 16}});
}

TEST_CASE("modified butterfly: an extraordinary crease vertex gives its rule to its edges, two give the mean") {
    for (const int K : {2, 4, 5, 6, 9}) {
        CAPTURE(K);
        const TriangleFan fan(K, true, 4);
        const RuleStep step = modified_butterfly_step(fan.mesh, {});
        for (int i = 1; i < K; ++i) {
            CAPTURE(i);
            check_weights(edge_weights(fan.mesh, step, 0, fan.point(i, 1)), fan.weights(crease_rule(K, i)));
        }
    }
    // One vertex of five neighbours, 0, one of the boundary with four faces, 1, with an edge between them.
    RuleMesh::Builder faces;
    for (const auto& [a, b] : {std::pair(1, 2), {2, 3}, {3, 4}, {4, 5}, {5, 1}}) faces.face({0, a, b});
    faces.face({2, 1, 6});
    faces.face({1, 5, 7});
    const RuleMesh mesh(8, std::move(faces));
    REQUIRE(mesh.ring(1).faces() == 4);
    RowWeights expected;
    // The ring of 1 is 6, 2, 0, 5, 7 one way or the other: the rule of its middle has equal ends, both 0.
    const std::vector<double> inside = inner_rule(5, 0), crease = crease_rule(4, 2);
    const int round_inside[] = {0, 1, 2, 3, 4, 5}, round_crease[] = {1, 6, 2, 0, 5, 7};
    for (int i = 0; i < 6; ++i) {
        expected[round_inside[i]] += inside[i] / 2;
        expected[round_crease[i]] += crease[i] / 2;
    }
    check_weights(edge_weights(mesh, modified_butterfly_step(mesh, {}), 0, 1), expected);
}

TEST_CASE("modified butterfly: from whichever end an edge is seen, its row is the same") {
    std::vector<RuleMesh> meshes{TriangleGrid(6, 6, {{.row = 2, .first = 0, .last = 3}}).mesh, TriangleGrid(5, 2).mesh};
    for (const int n : {1, 2, 3, 4, 5, 7})
        for (const bool boundary : {false, true})
            if (boundary || n > 2) meshes.push_back(TriangleFan(n, boundary, 2).mesh);
    for (const RuleMesh& mesh : meshes) {
        // The faces in the other order: the half-edge by which an edge is known is then its other one.
        RuleMesh::Builder faces;
        for (int f = mesh.face_count() - 1; f >= 0; --f) {
            for (int h = 3 * f; h < 3 * f + 3; ++h) faces.corner(mesh.origin(h), mesh.sharpness(h));
            faces.end_face();
        }
        const RuleMesh turned(mesh.vertex_count(), std::move(faces));
        const RuleStep here = modified_butterfly_step(mesh, {}), there = modified_butterfly_step(turned, {});
        std::set<std::pair<int, int>> halfedges;
        int inner = 0;
        for (int e = 0; e < mesh.edge_count(); ++e) {
            const int h = mesh.edge_halfedge(e), t = turned.edge_halfedge(e);
            halfedges.emplace(mesh.origin(h), mesh.target(h));
            halfedges.emplace(turned.origin(t), turned.target(t));
            inner += mesh.twin(h) != RuleMesh::none ? 1 : 0;
            CAPTURE(mesh.origin(h));
            CAPTURE(mesh.target(h));
            check_weights(edge_weights(turned, there, mesh.origin(h), mesh.target(h)),
                          edge_weights(mesh, here, mesh.origin(h), mesh.target(h)));
        }
        CHECK(static_cast<int>(halfedges.size()) == mesh.edge_count() + inner);
    }
}

TEST_CASE(
    "[inv7] modified butterfly keeps quadratics beside boundaries, cubics inside and along, linear ones on strips") {
    const TriangleGrid grid(9, 9);
    // Any affine image: polynomials of a degree are the same.
    const auto x = [&](int v) { return 0.3 * grid.place(v).first - 0.1 * grid.place(v).second - 1; };
    const auto y = [&](int v) { return 0.1 * grid.place(v).first + 0.25 * grid.place(v).second - 1.5; };
    const auto error = [&](const TriangleGrid& of, const RuleStep& step, int e, int degree) {
        const int h = of.mesh.edge_halfedge(e), u = of.mesh.origin(h), v = of.mesh.target(h);
        double worst = 0;
        for (int p = 0; p <= degree; ++p)
            for (int q = 0; p + q <= degree; ++q) {
                double value = 0;
                for (const auto& [at, w] : weights_of(step, of.mesh.vertex_count() + e))
                    value += w * monomial(p, q, x(at), y(at));
                worst = std::max(worst, std::abs(value - monomial(p, q, (x(u) + x(v)) / 2, (y(u) + y(v)) / 2)));
            }
        return worst;
    };
    const RuleStep step = modified_butterfly_step(grid.mesh, {}),
                   reflected = modified_butterfly_step(grid.mesh, {.reflect_at_boundary = true});
    int inside = 0, along = 0, beside = 0, corner = 0;
    for (int e = 0; e < grid.mesh.edge_count(); ++e) {
        const int h = grid.mesh.edge_halfedge(e), ends[] = {grid.mesh.origin(h), grid.mesh.target(h)};
        int on_boundary = 0;
        bool regular = true;
        for (const int v : ends) {
            on_boundary += grid.mesh.on_boundary(v) ? 1 : 0;
            regular = regular && grid.mesh.ring(v).faces() == (grid.mesh.on_boundary(v) ? 3 : 6);
        }
        CAPTURE(ends[0]);
        CAPTURE(ends[1]);
        if (!regular) continue;  // at the grid's corners
        if (on_boundary == 0) {
            CHECK(error(grid, step, e, 3) < 1e-14);
            ++inside;
        } else if (grid.mesh.sharp(h)) {
            CHECK(error(grid, step, e, 3) < 1e-14);
            ++along;
        } else {
            CHECK(error(grid, step, e, 2) < 1e-14);
            // Reflection does not.
            CHECK(error(grid, reflected, e, 2) > 1e-3);
            ++(on_boundary == 1 ? beside : corner);
        }
    }
    CHECK(inside > 100);
    CHECK(along == 4 * 6);
    CHECK(beside > 40);
    CHECK(corner == 2);
    // Across a strip no more than linear ones; that is all which two points can do.
    TriangleGrid strip(9, 2);
    const RuleStep narrow = modified_butterfly_step(strip.mesh, {});
    int across = 0;
    for (int e = 0; e < strip.mesh.edge_count(); ++e) {
        const int h = strip.mesh.edge_halfedge(e);
        if (strip.mesh.sharp(h)) continue;
        CHECK(error(strip, narrow, e, 1) < 1e-14);
        ++across;
    }
    CHECK(across == 8 + 7);
}

TEST_CASE("kobbelt: a face point takes the row of fewer extraordinary vertices, or else the mean of both") {
    int fewer[2] = {0, 0}, mean = 0, same = 0;
    for (unsigned seed = 0; seed < 12; ++seed) {
        CAPTURE(seed);
        const RuleMesh first = split_polyhedron(seed);
        for (const RuleMesh& mesh : {first, kobbelt_step(first, {}).mesh}) {
            const RuleStep step = kobbelt_step(mesh, {});
            for (int f = 0; f < mesh.face_count(); ++f) {
                CAPTURE(f);
                const FacePoint point = face_point(mesh, step, f);
                const auto& [a, b] = point.rows;
                if (weights_apart(a.weights, b.weights) < 1e-14) {
                    CHECK(weights_apart(point.ours, a.weights) < 1e-14);
                    ++same;
                } else if (a.extraordinary != b.extraordinary) {
                    const int chosen = a.extraordinary < b.extraordinary ? 0 : 1;
                    CHECK(weights_apart(point.ours, point.rows[chosen].weights) < 1e-14);
                    ++fewer[chosen];
                } else {
                    RowWeights half;
                    for (const FacePointRow& row : point.rows)
                        for (const auto& [p, w] : row.weights) half[p] += w / 2;
                    CHECK(weights_apart(point.ours, half) < 1e-14);
                    ++mean;
                }
            }
        }
    }
    for (const int count : {fewer[0], fewer[1], mean, same}) CHECK(count > 20);
}

TEST_SUITE_END();
