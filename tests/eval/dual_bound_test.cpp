#include "../kit/random_mesh.hpp"

#include "../../eval/bounds/dual_bound.hpp"
#include "../../eval/triangles/point_triangle.hpp"
#include "../../refine/points/row_points.hpp"
#include "../../refine/points/vertex_links.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <vector>

using namespace tetrakis;
using test::Random;

namespace {

void say_nothing(double) {}

/// Vertex quadtrees, and the scheme's points for their leaves.
struct DualLeaves {
    VertexForest trees;
    std::shared_ptr<const LevelSource> source;

    DualLeaves(const ControlMesh& mesh, const SchemeInfo& scheme)
        : trees(vertex_roots(mesh, scheme, {})),
          source(detail::row_points(mesh, scheme, {}, &trees.roots(), {}, false)) {}
};

/// The mesh of a forest's leaves, its bounds, and limit points all over the cells.
struct Bounded {
    static constexpr int k_bits = 4, k_side = 1 << k_bits, k_points = k_side * k_side;

    detail::DualTriangles mesh;
    std::vector<Vec3d> positions;
    detail::DualBound::Errors bound;
    std::vector<std::vector<Vec3d>> samples;  ///< per vertex, k_points for each of its sides
    std::vector<double> gap;                  ///< per vertex, from its cell's corners to the samples beside them

    Bounded(const DualLeaves& dual, const SchemeInfo& scheme, const ControlMesh& control) {
        const VertexForest& forest = dual.trees;
        mesh = detail::dual_triangles(forest);
        positions.resize(mesh.vertex_count());
        dual.source->limit_positions(cell_sites(mesh.faces.cells), positions);
        detail::DualBound bounder(*dual.source, scheme, forest.roots(), control);
        bound = bounder.errors(forest, mesh, positions, {0, true}, say_nothing);
        samples.resize(mesh.vertex_count());
        gap.resize(mesh.vertex_count(), 0.0);
        for (std::uint32_t v = 0; v < samples.size(); ++v) add_samples(dual, mesh.faces.cells[v], samples[v], gap[v]);
        for (const auto& side : mesh.faces.other_sides)
            add_samples(dual, forest.cell(side.leaf), samples[side.vertex], gap[side.vertex]);
    }

    static void add_samples(const DualLeaves& dual, const VertexCell& cell, std::vector<Vec3d>& samples, double& gap) {
        std::vector<VertexCell> cells;
        detail::add_cells_below(cell, k_bits, cells);
        // Beside an extraordinary point of many corners, cells hardly become smaller: how far that is from the samples.
        constexpr int k_deep = 16;
        for (const std::uint32_t y : {0u, (1u << k_deep) - 1})
            for (const std::uint32_t x : {0u, (1u << k_deep) - 1})
                cells.push_back({cell.root,
                                 {(cell.at.x << k_deep) + x, (cell.at.y << k_deep) + y},
                                 static_cast<std::uint8_t>(cell.level + k_deep)});
        std::vector<Vec3d> points(cells.size());
        dual.source->limit_positions(cell_sites(cells), points);
        const std::array<std::size_t, 4> corner = {0, k_side - 1, k_points - k_side, k_points - 1};
        for (std::size_t c = 0; c < corner.size(); ++c)
            gap = std::max(gap, glm::length(points[k_points + c] - points[corner[c]]));
        samples.insert(samples.end(), points.begin(), points.begin() + k_points);
    }

    std::span<const std::uint32_t> around(std::uint32_t v) const {
        return std::span(mesh.around).subspan(mesh.around_begin[v], mesh.around_begin[v + 1] - mesh.around_begin[v]);
    }
    double to_triangle(const Vec3d& p, std::uint32_t t) const {
        const auto [a, b, c] = mesh.triangle(t);
        return std::sqrt(detail::nearest_on_triangle(p, positions[a], positions[b], positions[c]).squared_distance);
    }
    /// How far neighbours among the samples of a vertex are apart.
    double spacing(std::uint32_t v) const {
        double most = gap[v];
        for (std::size_t i = 0; i < samples[v].size(); ++i) {
            if (i % k_side != 0) most = std::max(most, glm::length(samples[v][i] - samples[v][i - 1]));
            if (i % k_points >= k_side) most = std::max(most, glm::length(samples[v][i] - samples[v][i - k_side]));
        }
        return most;
    }
};

/// Samples are never farther from all triangles around their vertex than its bound. Returns the largest distance.
double check_forward(const Bounded& b) {
    double farthest = 0;
    for (std::uint32_t v = 0; v < b.samples.size(); ++v)
        for (const Vec3d& p : b.samples[v]) {
            double nearest = std::numeric_limits<double>::infinity();
            for (const std::uint32_t t : b.around(v)) nearest = std::min(nearest, b.to_triangle(p, t));
            if (nearest > b.bound.of_vertex[v]) CHECK(nearest <= b.bound.of_vertex[v]);
            farthest = std::max(farthest, nearest);
        }
    return farthest;
}

/// Nor are points of a triangle farther from the surface over the vertices of its face than a bound of its corners.
void check_backward(const Bounded& b, Random& random) {
    constexpr int k_points = 6;
    std::vector<double> spacing(b.samples.size());
    for (std::uint32_t v = 0; v < spacing.size(); ++v) spacing[v] = b.spacing(v);
    for (std::uint32_t t = 0; t < b.mesh.triangle_count(); ++t) {
        const auto corner = b.mesh.triangle(t);
        std::vector<std::uint32_t> near;
        for (const std::uint32_t v : corner)
            for (const std::uint32_t other : b.around(v))
                for (const std::uint32_t w : b.mesh.triangle(other)) near.push_back(w);
        std::sort(near.begin(), near.end());
        near.erase(std::unique(near.begin(), near.end()), near.end());
        double bound = 0;
        for (const std::uint32_t v : corner) bound = std::max(bound, b.bound.of_vertex[v]);
        for (int i = 0; i < k_points; ++i) {
            double x = random.uniform(), y = random.uniform();
            if (x + y > 1) x = 1 - x, y = 1 - y;
            const Vec3d q =
                (1 - x - y) * b.positions[corner[0]] + x * b.positions[corner[1]] + y * b.positions[corner[2]];
            double nearest = std::numeric_limits<double>::infinity();
            for (const std::uint32_t w : near)
                for (const Vec3d& p : b.samples[w]) nearest = std::min(nearest, glm::length(p - q) - spacing[w]);
            if (nearest > bound) CHECK(nearest <= bound);
        }
    }
}

ControlMesh random_dual_net(std::uint64_t seed, bool creased) {
    test::RandomMeshOptions options = test::random_options(seed);
    options.columns = options.rows = 3;
    options.hole = 0;
    options.crease = creased ? 0.25 : 0;
    options.corner = creased ? 0.1 : 0;
    if (options.boundary_rule == BoundaryRule::none) options.boundary_rule = BoundaryRule::edge_only;
    return test::random_dual_mesh(seed, options);
}

DualLeaves random_adaptive(const ControlMesh& mesh, const SchemeInfo& scheme, Random& random, int rounds) {
    DualLeaves dual(mesh, scheme);
    ForestChange change;
    for (int i = 0; i < rounds; ++i)
        dual.trees.refine(test::random_subset(dual.trees.ordered_leaves(), 0.08, random), change);
    return dual;
}

void check_bounds(const ControlMesh& mesh, const SchemeInfo& scheme, std::uint64_t seed) {
    CAPTURE(scheme.name);
    CAPTURE(seed);
    Random random(seed);
    const DualLeaves dual = random_adaptive(mesh, scheme, random, static_cast<int>(random.below(3)));
    const Bounded b(dual, scheme, mesh);
    REQUIRE(b.bound.of_vertex.size() == b.mesh.vertex_count());
    const double farthest = check_forward(b);
    CHECK(farthest <= b.bound.largest);
    check_backward(b, random);
}

}  // namespace

TEST_CASE("[slow] [inv9] bounds of dual meshes are never below a distance, whatever is around") {
    for (const char* name : {"doo-sabin", "doo-sabin-cc", "midedge", "midedge-simplest"}) {
        const SchemeInfo& scheme = *find_scheme(name);
        for (const std::uint64_t seed : test::seeds(3))
            for (const bool creased : {false, true}) check_bounds(random_dual_net(seed, creased), scheme, seed);
    }
}
