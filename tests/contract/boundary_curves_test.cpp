#include "../kit/nearest.hpp"
#include "../kit/random_mesh.hpp"

#include "../../refine/uniform/refine.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <set>
#include <span>
#include <utility>
#include <vector>

// Schemes whose boundary and crease curves depend on the control points of the curve alone.

using namespace tetrakis;

namespace {

struct CurveScheme {
    const SchemeInfo* scheme;
    RuleOptions rules{};
};

/// All such schemes. With more averaging steps, inner points influence the boundary.
std::vector<CurveScheme> curve_schemes() {
    std::vector<CurveScheme> result;
    for (const SchemeInfo& scheme : scheme_table()) {
        if (scheme.name == "biquartic") continue;
        CurveScheme one{&scheme};
        if (scheme.name == "averaging") one.rules.averaging_steps = 2;
        result.push_back(one);
        for (const EdgeBesideCrease rule : {EdgeBesideCrease::cosine, EdgeBesideCrease::brief})
            if (scheme.name == "loop" || scheme.name == "catmull-clark") {
                one.rules.edge_beside_crease = rule;
                result.push_back(one);
            }
    }
    return result;
}

/// Vertices on edges with one face.
std::set<std::uint32_t> curve_vertices(std::span<const std::uint32_t> offsets, std::span<const std::uint32_t> corners) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, int> faces;
    for (std::size_t f = 0; f + 1 < offsets.size(); ++f)
        for (std::uint32_t i = offsets[f]; i < offsets[f + 1]; ++i)
            ++faces[std::minmax(corners[i], corners[i + 1 == offsets[f + 1] ? offsets[f] : i + 1])];
    std::set<std::uint32_t> result;
    for (const auto& [edge, count] : faces)
        if (count == 1) result.insert({edge.first, edge.second});
    return result;
}

/// A lower and an upper band of faces around an axis, which meet in a closed crease near z = 0. Random diagonals and
/// larger faces give the crease's vertices different numbers of faces on each side.
struct TwoBands {
    static constexpr std::uint32_t columns = 5, rings = 5;  ///< the crease is the middle one
    std::vector<Vec3d> positions;
    std::vector<std::vector<std::uint32_t>> lower, upper;

    TwoBands(std::uint64_t seed, bool triangles) {
        test::Random random(seed);
        for (std::uint32_t r = 0; r < rings; ++r)
            for (std::uint32_t c = 0; c < columns; ++c) {
                const double angle = 2 * 3.14159265 * (c + random.uniform(-0.2, 0.2)) / columns;
                const double radius = random.uniform(1, 1.5);
                positions.push_back({radius * std::cos(angle), radius * std::sin(angle),
                                     3 * (static_cast<double>(r) - 2) + random.uniform(-0.2, 0.2)});
            }
        for (std::uint32_t r = 0; r + 1 < rings; ++r)
            for (std::uint32_t c = 0; c < columns; ++c) {
                const std::uint32_t p[] = {at(r, c), at(r, c + 1), at(r + 1, c + 1), at(r + 1, c)};
                auto& faces = r < 2 ? lower : upper;
                const bool other = random.chance(0.5);
                if (triangles || random.chance(0.3)) {
                    const std::uint32_t q[] = {p[other], p[other + 1], p[other + 2], p[(other + 3) % 4]};
                    faces.push_back({q[0], q[1], q[2]});
                    faces.push_back({q[2], q[3], q[0]});
                } else if (c % 2 == 0 && c + 2 < columns && random.chance(0.3)) {
                    faces.push_back({p[0], p[1], at(r, c + 2), at(r + 1, c + 2), p[2], p[3]});
                    ++c;
                } else {
                    faces.push_back({p[0], p[1], p[2], p[3]});
                }
            }
    }
    static std::uint32_t at(std::uint32_t ring, std::uint32_t column) { return ring * columns + column % columns; }

    ControlMesh mesh(bool low, bool up) const {
        ControlMeshData data;
        data.face_offsets.push_back(0);
        std::map<std::uint32_t, std::uint32_t> number;
        for (const auto* faces : {&lower, &upper}) {
            if (!(faces == &lower ? low : up)) continue;
            for (const auto& face : *faces) {
                for (const std::uint32_t v : face) {
                    const auto [known, is_new] =
                        number.try_emplace(v, static_cast<std::uint32_t>(data.positions.size()));
                    if (is_new) data.positions.push_back(positions[v]);
                    data.face_vertices.push_back(known->second);
                }
                data.face_offsets.push_back(static_cast<std::uint32_t>(data.face_vertices.size()));
            }
        }
        if (low && up)
            for (std::uint32_t c = 0; c < columns; ++c)
                data.creases.push_back({number.at(at(2, c)), number.at(at(2, c + 1)), k_infinite_sharpness});
        data.boundary_rule = BoundaryRule::edge_only;
        return ControlMesh::build(std::move(data));
    }
};

/// Points of one half on the boundary curve that it shares with the other half.
std::vector<Vec3d> common_curve(const PolygonMesh& half) {
    std::vector<Vec3d> result;
    for (const std::uint32_t v : curve_vertices(half.face_offsets, half.face_vertices))
        if (std::abs(half.positions[v].z) < 1.5) result.push_back(half.positions[v]);
    return result;
}

/// Largest distance of the points from their nearest points in `from`.
double largest_gap(const std::vector<Vec3d>& points, const std::vector<Vec3d>& from) {
    const PointMatch match(from);
    double most = 0;
    for (const Vec3d& p : points) most = std::max(most, glm::length(from[match.nearest(p)] - p));
    return most;
}

}  // namespace

TEST_SUITE_BEGIN("contract");

TEST_CASE("boundary curves see nothing of the inside, on any level and in the limit") {
    for (const std::uint64_t seed : test::seeds(1))
        for (const auto& [scheme, rules] : curve_schemes()) {
            CAPTURE(seed);
            CAPTURE(scheme->name);
            test::RandomMeshOptions options{
                .columns = 4, .rows = 3, .removed_faces = 1, .hole = 0, .crease = 0, .corner = 0};
            options.triangles_only = scheme->family == MeshFamily::triangles;
            ControlMeshData data = test::random_mesh_data(seed, options);
            const ControlMesh mesh = ControlMesh::build(data);
            const std::set<std::uint32_t> outside = curve_vertices(data.face_offsets, data.face_vertices);
            test::Random random(seed);
            for (std::uint32_t v = 0; v < data.positions.size(); ++v)
                if (!outside.contains(v))
                    data.positions[v] += Vec3d(random.uniform(), random.uniform(), random.uniform());
            const ControlMesh moved = ControlMesh::build(std::move(data));
            for (const bool limit : {false, true}) {
                CAPTURE(limit);
                const RefineOptions how{.rules = rules, .limit = limit};
                const int levels = limit ? 1 : 2;
                const PolygonMesh a = refine(mesh, *scheme, levels, how), b = refine(moved, *scheme, levels, how);
                const std::set<std::uint32_t> curve = curve_vertices(a.face_offsets, a.face_vertices);
                int same = 0;
                for (const std::uint32_t v : curve) same += a.positions[v] == b.positions[v] ? 1 : 0;
                CHECK(same == static_cast<int>(curve.size()));
                CHECK(curve.size() >= outside.size());
                CHECK(largest_gap(a.positions, b.positions) > 0.01);
            }
        }
}

TEST_CASE(
    "crease curves are the same for both sides, which have the rules of a boundary there, on any level and in the "
    "limit") {
    for (const std::uint64_t seed : test::seeds(1))
        for (const auto& [scheme, rules] : curve_schemes()) {
            CAPTURE(seed);
            CAPTURE(scheme->name);
            const TwoBands bands(seed, scheme->family == MeshFamily::triangles);
            const ControlMesh low = bands.mesh(true, false), up = bands.mesh(false, true),
                              both = bands.mesh(true, true);
            for (const bool limit : {false, true}) {
                CAPTURE(limit);
                const RefineOptions how{.rules = rules, .limit = limit};
                const int levels = limit ? 1 : 2;
                const PolygonMesh whole = refine(both, *scheme, levels, how),
                                  below_all = refine(low, *scheme, levels, how),
                                  above_all = refine(up, *scheme, levels, how);
                const std::vector<Vec3d> below = common_curve(below_all), above = common_curve(above_all);
                CHECK(below.size() >= TwoBands::columns);
                CHECK(below.size() == above.size());
                CHECK(largest_gap(below, above) < 1e-13);
                CHECK(largest_gap(above, below) < 1e-13);
                CHECK(largest_gap(below, whole.positions) < 1e-13);
                // On each side of the crease the boundary rules of that side hold. Averaging reaches across it.
                if (scheme->name == "averaging") continue;
                CHECK(largest_gap(below_all.positions, whole.positions) < 1e-13);
                CHECK(largest_gap(above_all.positions, whole.positions) < 1e-13);
            }
        }
}

TEST_CASE("crease curves are not the same for both sides by Hoppe's rule, which counts the faces") {
    const TwoBands bands(0, true);
    const RefineOptions how{.rules = {.hoppe_crease = true}};
    const std::vector<Vec3d> below = common_curve(refine(bands.mesh(true, false), "loop", 2, how)),
                             above = common_curve(refine(bands.mesh(false, true), "loop", 2, how));
    CHECK(below.size() == above.size());
    CHECK(largest_gap(below, above) > 0.01);
}

TEST_SUITE_END();
