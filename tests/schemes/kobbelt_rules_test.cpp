#include "../../schemes/rules/kobbelt.hpp"
#include "../../schemes/rules/linear.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <random>
#include <vector>

// The two ways to compute a face point of Kobbelt's scheme: from the edge points of the row that goes through two
// opposite edges, or through the other two.

using namespace tetrakis;

namespace {

using PointWeights = std::map<int, double>;

PointWeights weights_of(const RuleStep& step, int row) {
    PointWeights result;
    for (std::size_t i = 0; i < step.stencils.points(row).size(); ++i)
        result[step.stencils.points(row)[i]] += step.stencils.weights(row)[i];
    return result;
}

double weights_apart(const PointWeights& a, const PointWeights& b) {
    double most = 0;
    for (const auto& [point, w] : a) most = std::max(most, std::abs(w - (b.contains(point) ? b.at(point) : 0)));
    for (const auto& [point, w] : b) most = std::max(most, a.contains(point) ? 0 : std::abs(w));
    return most;
}

/// A face point by one of its rows.
struct FacePointRow {
    PointWeights weights;
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
    PointWeights ours;
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
                    PointWeights half;
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
