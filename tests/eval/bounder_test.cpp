#include "../../eval/bounds/cell_bounder.hpp"
#include "../../eval/bounds/star_pieces.hpp"
#include "../../eval/triangles/point_triangle.hpp"

#include "../kit/patch_meshes.hpp"

#include "../../eval/surface/local_frame.hpp"
#include "../../eval/tessellate/leaf_estimator.hpp"
#include "../../eval/tessellate/measure.hpp"

#include <doctest/doctest.h>

#include <atomic>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <vector>

using namespace tetrakis;

namespace {

/// The error of a leaf (see CellBounder) at the points of a lattice; and the largest distance from a lattice point of
/// the triangle to the samples, less what lies between these.
struct SampledError {
    double error = 0, back = 0;
};

/// @param surface  the surface at barycentrics (b0, b1, b2) of the leaf
/// @param apex     the triangle's last corner, if it is not the surface's
template <class Surface>
SampledError sampled_distance(int n, Surface&& surface, const Vec3d* apex = nullptr) {
    std::vector<Vec3d> points;
    const auto index = [n](int i, int j) { return static_cast<std::size_t>(i * (2 * n + 3 - i) / 2 + j); };
    for (int i = 0; i <= n; ++i)
        for (int j = 0; i + j <= n; ++j) points.push_back(surface(double(i) / n, double(j) / n, double(n - i - j) / n));
    const Vec3d c0 = points[index(n, 0)], c1 = points[index(0, n)], c2 = apex ? *apex : points[index(0, 0)];
    SampledError sampled{glm::length(points[index(0, 0)] - c2), 0};
    double spacing = 0;
    for (int i = 0; i <= n; ++i)
        for (int j = 0; i + j <= n; ++j) {
            const Vec3d& p = points[index(i, j)];
            const auto look = [&](double e) { sampled.error = std::max(sampled.error, e); };
            look(std::sqrt(detail::nearest_on_triangle(p, c0, c1, c2).squared_distance));
            if (i == 0) look(detail::segment_distance(p, c1, c2));
            if (j == 0) look(detail::segment_distance(p, c0, c2));
            if (i + j == n) look(detail::segment_distance(p, c0, c1));
            if (i + j < n)
                spacing = std::max(
                    {spacing, glm::length(p - points[index(i + 1, j)]), glm::length(p - points[index(i, j + 1)])});
        }
    for (int i = 0; i <= n; ++i)
        for (int j = 0; i + j <= n; ++j) {
            const Vec3d q = (double(i) * c0 + double(j) * c1 + double(n - i - j) * c2) / double(n);
            double nearest = std::numeric_limits<double>::infinity();
            for (const Vec3d& p : points) nearest = std::min(nearest, glm::length(p - q));
            sampled.back = std::max(sampled.back, nearest - spacing);
        }
    return sampled;
}

constexpr double k_infinity = std::numeric_limits<double>::infinity();

}  // namespace

TEST_SUITE_BEGIN("eval");

TEST_CASE_TEMPLATE("[inv9] bounds of leaves are never below the error sampled, and tight", Family, QuadFamily,
                   LoopFamily) {
    for (const std::uint64_t seed : test::seeds(24)) {
        CAPTURE(seed);
        const ControlMesh mesh = test::random_patch_mesh<Family>(seed);
        const typename Family::Patches patches(mesh);
        typename Family::Bounder bounder(patches);
        const double size = bounding_box(mesh.positions()).diagonal(), rounding = 1e-12 * size;
        const double added = 2 * detail::surface_rounding(mesh);  // by every bound
        test::Random random(seed);
        for (int i = 0; i < 60; ++i) {
            const CellTriangle leaf = test::random_leaf<Family>(random, mesh, 6);
            CAPTURE(leaf.root.value);
            CAPTURE(int(leaf.level));
            const auto [sampled, back] = sampled_distance(16, [&](double b0, double b1, double b2) {
                const SurfaceParameter at = Family::parameter(mesh, leaf, b0, b1, b2);
                return patches.evaluate(at.root, at.x, at.y).position;
            });
            // decide_at 0 asks for nothing but a lower bound; infinity for any upper one; half and twice the error
            // decide quickly; the error itself asks for a tight bound.
            for (const double decide_at : {0.0, 0.5 * sampled, 2 * sampled, k_infinity}) {
                const LeafError error = bounder.leaf_error(leaf, decide_at);
                CHECK(error.upper >= sampled - rounding);
                CHECK(error.lower <= error.upper);
                if (decide_at > 1.06 * sampled + added) CHECK(error.upper <= decide_at);
            }
            // The lattice may miss the largest deviation by a little.
            const double certified = bounder.certified_error(leaf, 0);
            CHECK(certified >= sampled - rounding);
            CHECK(certified >= back - rounding);
            CHECK(certified <= 1.25 * sampled + added);
            CHECK(bounder.leaf_error(leaf, k_infinity).lower <= certified + rounding);
            CHECK(bounder.certified_error(leaf, 0.7 * sampled) >= sampled - rounding);
            CHECK(bounder.certified_error(leaf, 3 * sampled) <= 3 * sampled + added);
            for (std::size_t k = 0; k < 3; ++k) {
                const SurfaceParameter at = Family::parameter(mesh, leaf, k == 0, k == 1, k == 2);
                const Site site = Family::corner_site(mesh, leaf, k);
                const Vec3d corner = patches.position(at.root, at.x, at.y);
                CHECK(glm::length(corner - patches.limit(site.root, site.at, site.level)) < rounding);
            }
        }
    }
}

TEST_CASE("[inv9] bounds of roots whose centre is given") {
    for (const std::uint64_t seed : test::seeds(8)) {
        CAPTURE(seed);
        const ControlMesh mesh = test::random_patch_mesh<QuadFamily>(2 * seed);
        const QuadPatches patches(mesh);
        QuadBounder bounder(patches);
        const double rounding = 1e-12 * bounding_box(mesh.positions()).diagonal();
        const double added = 2 * detail::surface_rounding(mesh);
        test::Random random(seed);
        for (int i = 0; i < 40; ++i) {
            const HalfedgeId root(random.below(mesh.halfedge_count()));
            const Vec3d centre = mesh.position(mesh.origin(root)) + Vec3d(random.uniform(), random.uniform(), 0);
            const auto surface = [&](double b0, double b1, double b2) {
                const SurfaceParameter at = QuadFamily::parameter(mesh, root_triangle(root), b0, b1, b2);
                return patches.evaluate(at.root, at.x, at.y).position;
            };
            const auto [sampled, back] = sampled_distance(16, surface, &centre);
            CHECK(bounder.root_error(root, centre, 0, false).upper >= back - rounding);
            CHECK(bounder.root_error(root, centre, 0, false).upper >= sampled - rounding);
            CHECK(bounder.root_error(root, centre, 0, false).upper <= 1.25 * sampled + added);
            CHECK(bounder.root_error(root, centre, 0.5 * sampled).upper >= sampled - rounding);
        }
    }
}

TEST_CASE("[inv9] the certified bound of a face's fan holds for 3 to 9 corners") {
    int checked = 0;
    for (std::uint32_t n = 3; n <= 9; ++n)
        for (const std::uint64_t seed : test::seeds(6)) {
            CAPTURE(n);
            CAPTURE(seed);
            // One bumpy n-gon with a ring of quads around it.
            test::Random random(seed * 31 + n);
            std::vector<Vec3d> positions;
            std::vector<std::vector<std::uint32_t>> faces(1);
            for (std::uint32_t ring = 0; ring < 2; ++ring)
                for (std::uint32_t i = 0; i < n; ++i) {
                    const double angle = 2 * std::numbers::pi * (i + random.uniform(-0.2, 0.2)) / n, r = 1 + ring;
                    positions.emplace_back(r * std::cos(angle), r * std::sin(angle), random.uniform(-0.5, 0.5));
                }
            for (std::uint32_t i = 0; i < n; ++i) {
                faces[0].push_back(i);
                faces.push_back({i, n + i, n + (i + 1) % n, (i + 1) % n});
            }
            const ControlMesh mesh = ControlMesh::build(test::mesh_data(std::move(positions), faces));
            const QuadPatches patches(mesh);
            detail::SurfaceMap<QuadFamily> map;
            map.patches = &patches;
            std::vector<Vec3d> corners;
            for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v)
                corners.push_back(patches.evaluate(mesh.vertex_halfedge(VertexId(v)), 0, 0).position);
            const FanChoice fans = choose_fans(mesh, corners);
            const FaceId face(0);
            if (!fans.has(face)) continue;
            ++checked;
            const detail::LeafEstimator<QuadFamily> estimator(map, EstimatorKind::certified, 0.1);
            const detail::FanError error(map, estimator, fans, corners);
            // The surface, laid over the regular polygon of the fan's triangles.
            double sampled = 0;
            for (const auto& t : fans.of(face)) {
                detail::OutputTriangle triangle;
                triangle.fan = face;
                for (std::size_t k = 0; k < 3; ++k) triangle.fan_corner[k] = t[k];
                constexpr int m = 20;
                for (int i = 0; i <= m; ++i)
                    for (int j = 0; i + j <= m; ++j) {
                        const double b0 = double(i) / m, b1 = double(j) / m, b2 = double(m - i - j) / m;
                        const SurfaceParameter at = triangle.parameter<QuadFamily>(mesh, b0, b1, b2);
                        double nearest = k_infinity;
                        for (const auto& other : fans.of(face))
                            nearest =
                                std::min(nearest, detail::nearest_on_triangle(map(at), corners[other[0]],
                                                                              corners[other[1]], corners[other[2]])
                                                      .squared_distance);
                        sampled = std::max(sampled, std::sqrt(nearest));
                    }
            }
            CHECK(error.certified(face, 0, false) >= sampled - 1e-12);
            CHECK(error.certified(face, 0.9 * sampled, true) >= sampled - 1e-12);
            CHECK(error.certified(face, 10 * sampled, false) >= sampled - 1e-12);
        }
    CHECK(checked > 30);
}

TEST_CASE("corners and sides of fans are sampled where they are: beside them trees would grow without end") {
    const ControlMesh mesh = test::random_patch_mesh<QuadFamily>(4);
    for (std::uint32_t f = 0; f < mesh.face_count(); ++f)
        for (std::uint32_t k = 1; k + 1 < mesh.face_size(FaceId(f)); ++k) {
            const detail::OutputTriangle triangle{{}, FaceId(f), {0, k, k + 1}};
            for (std::size_t c = 0; c < 3; ++c) {
                const auto at = [&](std::size_t i) { return i == c ? 1.0 : 0.0; };
                const SurfaceParameter p = triangle.parameter<QuadFamily>(mesh, at(0), at(1), at(2));
                CHECK((p.x == 0 || p.x == 1));
                CHECK(p.y == 0);
            }
            CHECK(triangle.parameter<QuadFamily>(mesh, 0, 0.7, 0.3).y == 0);
        }
}

TEST_SUITE_END();

namespace {

/// Compares StarPieces over all their triangles with samples of random surfaces.
template <class Shape>
void check_star_pieces(int valence) {
    constexpr int n = Shape::k_corners;
    using Pieces = detail::StarPieces<Shape>;
    std::mt19937 random(static_cast<unsigned>(valence));
    std::normal_distribution<double> coordinate;
    detail::Star<n> star;
    star.resize(star.with_first(valence));
    for (Vec3d& p : star.points) p = {coordinate(random), coordinate(random), coordinate(random)};
    const std::vector<Vec3d> points(star.points.begin(), star.points.end());
    std::atomic<std::uint64_t> bytes;
    detail::PatchNode<Shape> cell;
    cell.bytes = &bytes;
    cell.become(detail::Star<n>(star), 0);
    std::vector<Vec2d> corners;
    for (const double y : {0.0, 0.5, 1.0})
        for (const double x : {0.0, 0.5, 1.0})
            if (detail::is_in_cell({x, y}, n)) corners.emplace_back(x, y);
    for (const Vec2d& a : corners)
        for (const Vec2d& b : corners)
            for (const Vec2d& c : corners) {
                if ((b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x) <= 0) continue;
                const Pieces* const pieces = Pieces::of(star, {a, b, c});
                REQUIRE(pieces);
                CHECK(Pieces::of(star, {a, b, c}) == pieces);
                const auto surface = [&](const Vec2d& p) { return PatchTree<Shape>::position(cell, p); };
                const Vec3d at_a = surface(a), at_b = surface(b), at_c = surface(c);
                double most = 0;
                constexpr int k_side = 6;
                for (int j = 0; j <= k_side; ++j)
                    for (int i = 0; i + j <= k_side; ++i) {
                        const double v = double(i) / k_side, w = double(j) / k_side, u = 1 - v - w;
                        most = std::max(most,
                                        glm::length(surface(u * a + v * b + w * c) - (u * at_a + v * at_b + w * at_c)));
                    }
                const double bound = pieces->whole.deviation(pieces->fit(points));
                CHECK(most <= bound);
                CHECK(bound < 1e3);
                for (const auto& part : pieces->inner) CHECK(part.norms.deviation(pieces->fit(points)) > 0);
            }
    CHECK(!Pieces::of(star, {Vec2d(0), {0.25, 0}, {0, 0.5}}));
    star.resize(star.with_first(star.k_regular));
    CHECK(!Pieces::of(star, {Vec2d(0), {1, 0}, {0, 1}}));
}

}  // namespace

TEST_CASE("[inv9] norms over cells at extraordinary vertices hold for all triangles between corners of quarters") {
    for (const int valence : {3, 5, 9}) {
        check_star_pieces<detail::QuadShape>(valence);
        check_star_pieces<detail::LoopShape>(valence);
    }
    check_star_pieces<detail::QuadShape>(32);
}
