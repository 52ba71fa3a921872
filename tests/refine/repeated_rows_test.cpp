#include "../../refine/uniform/repeated_rows.hpp"

#include "../kit/point_match.hpp"
#include "../kit/random_mesh.hpp"

#include "../../hier/base/error.hpp"
#include "../../hier/mesh/triangulate.hpp"
#include "../../refine/rules/rule_refiner.hpp"
#include "../../refine/uniform/refine.hpp"
#include "../../schemes/rules/linear.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <numbers>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

using namespace tetrakis;
using test::farthest_apart;

namespace {

struct Case {
    std::string_view scheme;
    int levels;
    RuleOptions rules{};
};

std::vector<Case> cases() {
    RuleOptions warren, cosine, measured, two, four;
    warren.loop_weights = LoopWeights::warren;
    cosine.edge_beside_crease = EdgeBesideCrease::cosine;
    measured.measure_corner_angles = true;
    two.averaging_steps = 2;
    four.averaging_steps = 4;
    return {{"loop", 4, warren},
            {"loop", 4, cosine},
            {"loop", 4, measured},
            {"tuned-loop", 5},
            {"butterfly", 4},
            {"modified-butterfly", 5},
            {"sqrt3", 4},
            {"catmull-clark", 5, cosine},
            {"catmull-clark", 5, measured},
            {"kobbelt", 5},
            {"4-8", 5},
            {"bilinear", 5},
            {"midpoint", 4},
            {"averaging", 5, two},
            {"averaging", 5, four},
            {"doo-sabin", 5},
            {"doo-sabin-cc", 4},
            {"midedge", 5},
            {"midedge-simplest", 4},
            {"biquartic", 5}};
}

/// @param sharp_for_ever  or without anything sharp but boundaries
ControlMesh make_mesh(std::uint64_t seed, bool triangles, bool sharp_for_ever, bool with_uvs = false) {
    test::RandomMeshOptions options = test::random_options(seed);
    options.columns = 3 + static_cast<int>(seed % 2);
    options.rows = 3;
    // Two of three are without creases, one of them closed: what dual schemes ask for.
    if (seed % 3 != 2) options.edge_vertices = options.hole = options.crease = options.corner = 0;
    if (seed % 3 == 0) {
        options.topology = seed % 2 == 0 ? test::Topology::sphere : test::Topology::torus;
        options.removed_faces = 0;
    }
    ControlMeshData data = test::random_mesh_data(seed, options);
    if (!sharp_for_ever) {
        data.creases.clear();
        data.corners.clear();
    }
    for (auto& tag : data.creases) tag.sharpness = k_sharpness_infinity;
    for (auto& tag : data.corners) tag.sharpness = k_sharpness_infinity;
    if (with_uvs) test::add_charts(data);
    ControlMesh mesh = ControlMesh::build(std::move(data));
    return triangles ? triangulate(mesh) : mesh;
}

/// One point per face, other ones for faces whose corners are turned or exchanged.
std::vector<Vec3d> marks(const PolygonMesh& mesh, bool uvs) {
    std::vector<Vec3d> result;
    for (std::uint32_t f = 0; f < mesh.face_count(); ++f) {
        const std::uint32_t begin = mesh.face_offsets[f], end = mesh.face_offsets[f + 1];
        Vec3d sum(0), turn(0);
        for (std::uint32_t c = begin; c < end; ++c) {
            const std::uint32_t next = c + 1 == end ? begin : c + 1;
            const Vec3d p = uvs ? Vec3d(mesh.uvs[mesh.face_uvs[c]], 0) : mesh.positions[mesh.face_vertices[c]];
            const Vec3d q = uvs ? Vec3d(mesh.uvs[mesh.face_uvs[next]], 0) : mesh.positions[mesh.face_vertices[next]];
            sum += p;
            turn += glm::cross(p, q);
        }
        result.push_back(sum + turn);
    }
    return result;
}

PolygonMesh mesh_of(const RuleRefiner& refiner, const std::vector<Vec3d>& points) {
    PolygonMesh mesh;
    mesh.positions = points;
    mesh.face_offsets.push_back(0);
    for (int f = 0; f < refiner.last().face_count(); ++f) {
        for (const int v : refiner.last().corners(f)) mesh.face_vertices.push_back(static_cast<std::uint32_t>(v));
        mesh.face_offsets.push_back(static_cast<std::uint32_t>(mesh.face_vertices.size()));
    }
    return mesh;
}

/// The mesh that comes with tables of stencils; nothing where receding leaves none, or parts that only touch.
std::optional<PolygonMesh> by_stencils(const ControlMesh& mesh, const SchemeInfo& scheme, int levels,
                                       const RefineOptions& options) {
    try {
        return refine_stencils(mesh, scheme, levels, options).mesh;
    } catch (const Error&) {
        return std::nullopt;
    }
}

/// Creases around regions of faces, of which none ends at a dart, or along edges here and there, of which most do.
ControlMesh with_creases(const ControlMesh& mesh, std::uint64_t seed, bool with_limit, bool darts = false) {
    ControlMeshData data = mesh.data();
    const auto region = [&](HalfedgeId h) {
        const std::uint32_t f = mesh.face(h).value;
        return (f * 2654435761u + seed * 40503u) >> 7 & 3;
    };
    for (std::uint32_t i = 0; i < mesh.halfedge_count(); ++i) {
        const HalfedgeId h(i), t = mesh.twin(h);
        if (!t.valid() || t.value < i) continue;
        const bool chosen = ((i * 2654435761u + seed * 7919u) >> 9) % 5 == 0;
        if (darts ? !chosen : region(h) == region(t)) continue;
        // Sharp beyond the last level is as sharp as for ever; but not for limits.
        const bool finite = !with_limit && i % 3 == 0;
        data.creases.push_back({mesh.origin(h).value, mesh.target(h).value, finite ? 8.5f : k_sharpness_infinity});
    }
    data.corners.push_back({static_cast<std::uint32_t>(seed) % mesh.vertex_count(), k_sharpness_infinity});
    return ControlMesh::build(std::move(data));
}

/// Tags that turn smooth on several levels, some of them on the last but one, on the last or after it.
ControlMesh with_turning_tags(const ControlMesh& mesh, std::uint64_t seed, int levels) {
    ControlMeshData data = mesh.data();
    test::Random random(seed);
    const float sharpness[] = {
        0.6f, 1.0f, float(levels) - 1, float(levels) - 0.4f, float(levels) + 0.5f, k_sharpness_infinity};
    for (std::uint32_t e = 0; e < mesh.edge_count(); ++e) {
        const HalfedgeId h = mesh.edge_halfedge(EdgeId(e));
        if (mesh.is_boundary(EdgeId(e)) || !random.chance(0.25)) continue;
        data.creases.push_back({mesh.origin(h).value, mesh.target(h).value, sharpness[random.below(6)]});
    }
    data.corners.push_back({random.below(mesh.vertex_count()), sharpness[3]});
    data.corners.push_back({random.below(mesh.vertex_count()), sharpness[0]});
    return ControlMesh::build(std::move(data));
}

/// An open mesh, every face of a material of its own.
ControlMesh open_mesh(std::uint64_t seed) {
    test::RandomMeshOptions random = test::random_options(seed);
    random.topology = test::Topology::plane;
    random.columns = random.rows = 7;
    random.removed_faces = seed % 3 == 0 ? 0 : 1;
    random.hole = 0;
    ControlMeshData data = test::random_mesh_data(seed, random);
    for (std::uint32_t f = 0; f + 1 < data.face_offsets.size(); ++f) {
        data.face_material.push_back(f);
        data.materials.push_back(std::to_string(f));
    }
    return ControlMesh::build(std::move(data));
}

/// Each of one set's points with the nearest of another's: the largest distance, and who they are.
double find(const std::vector<Vec3d>& these, const std::vector<Vec3d>& among, std::vector<std::uint32_t>& found) {
    const PointMatch match(among);
    double worst = 0;
    found.clear();
    for (const Vec3d& p : these) {
        found.push_back(match.nearest(p));
        worst = std::max(worst, glm::length(p - among[found.back()]));
    }
    return worst;
}

bool takes_triangles(const Case& c) { return find_scheme(c.scheme)->family == MeshFamily::triangles; }
bool is_dual(const Case& c) { return fan_lattice(*find_scheme(c.scheme), c.rules) == FanLattice::dual; }

/// Whether both sides of a crease lie on one another around a vertex.
bool is_folded(const RuleMesh& mesh, const std::vector<Vec3d>& points, std::size_t v) {
    Vec3d sum(0);
    for (const int h : mesh.ring(static_cast<int>(v)).halfedge)
        sum +=
            unit_or_zero(glm::cross(points[mesh.target(h)] - points[v], points[mesh.origin(mesh.prev(h))] - points[v]));
    return glm::length(sum) < 0.5;
}

/// Points, faces, their control faces, limits and normals by repeated rows and by the rules. False where no rows
/// repeat.
bool check_rows(const ControlMesh& mesh, const Case& c, bool limit = false, bool normals = false) {
    const SchemeInfo& scheme = *find_scheme(c.scheme);
    auto levels = std::make_unique<detail::RuleLevels>(mesh, scheme, c.rules, 0);
    detail::RepeatedRows::Demand demand;
    demand.limit = limit && !scheme.interpolating;
    demand.normals = normals;
    demand.even_if_slower = true;
    const auto rows = detail::RepeatedRows::make(mesh, scheme, c.levels, c.rules, levels, demand, {});
    if (!rows) return false;
    const RuleRefiner by_rules(mesh, scheme, c.levels, {.rules = c.rules, .limit = limit, .normals = normals});
    PolygonMesh ours;
    ours.positions.resize(rows->point_count());
    ours.normals.resize(normals ? rows->point_count() : 0);
    rows->refine(mesh.positions(), ours.positions, ours.normals, {});
    std::vector<Vec3d> points(by_rules.vertex_count()), point_normals(ours.normals.size());
    by_rules.refine(mesh.positions(), points);
    const double size = bounding_box(mesh.positions()).diagonal();
    CHECK(farthest_apart(ours.positions, points) < 1e-12 * size);

    detail::RepeatedRows::Faces faces = rows->faces({});
    ours.face_offsets = std::move(faces.offsets);
    ours.face_vertices = std::move(faces.vertices);
    CHECK(farthest_apart(marks(ours, false), marks(mesh_of(by_rules, points), false)) < 1e-11 * (size + size * size));
    std::vector<int> cells(mesh.face_count(), 0);
    for (std::uint32_t f = 0; f < by_rules.face_count(); ++f) --cells[by_rules.control_face(f)];
    for (const std::uint32_t f : faces.control) ++cells[f];
    CHECK(std::ranges::count(cells, 0) == static_cast<std::ptrdiff_t>(cells.size()));

    if (!normals) return true;
    by_rules.normals(mesh.positions(), point_normals);
    std::vector<Vec3d> ends, net(points.size());
    for (std::size_t i = 0; i < points.size(); ++i) ends.push_back(ours.positions[i] + ours.normals[i]);
    RuleRefiner(mesh, scheme, c.levels, {.rules = c.rules}).refine(mesh.positions(), net);
    // Points at the same place have their normals in any order.
    const PointMatch match(ends);
    double worst = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
        if (is_dual(c) && is_folded(by_rules.last(), net, i)) continue;  // rounding decides
        const Vec3d end = points[i] + point_normals[i];
        worst = std::max(worst, glm::length(end - ends[match.nearest(end)]));
    }
    CHECK(worst < 1e-7);
    return true;
}

}  // namespace

TEST_SUITE_BEGIN("refine");

TEST_CASE("[inv1] [slow] rows that repeat themselves give what the rules give, limits and normals as well") {
    for (const Case& c : cases()) {
        CAPTURE(c.scheme);
        const bool linear = is_linear(*find_scheme(c.scheme));  // no tangents, and limits in ways of their own
        int repeated = 0, with_normals = 0;
        for (const std::uint64_t seed : test::seeds(4)) {
            CAPTURE(seed);
            ControlMesh mesh = make_mesh(seed, takes_triangles(c), seed % 2 == 1);
            repeated += check_rows(mesh, c);
            if (linear) continue;
            if (seed == 2) {
                // What has turned smooth before rows are learned has no effect on them.
                ControlMeshData data = mesh.data();
                for (std::uint32_t h = 0; h < mesh.halfedge_count(); h += 5)
                    data.creases.push_back(
                        {mesh.origin(HalfedgeId(h)).value, mesh.target(HalfedgeId(h)).value, 0.7f + 0.1f * (h % 2)});
                mesh = ControlMesh::build(std::move(data));
            }
            with_normals += check_rows(mesh, c, seed % 4 != 2, true);
        }
        CHECK(repeated > 0);
        CHECK((linear || with_normals > 1));
    }
}

TEST_CASE("[slow] refine() by rows that repeat themselves: texture coordinates, attributes, holes as by the rules") {
    for (const Case& c : cases()) {
        CAPTURE(c.scheme);
        const SchemeInfo& scheme = *find_scheme(c.scheme);
        const bool triangles = scheme.family == MeshFamily::triangles;
        for (const std::uint64_t seed : test::seeds(4)) {
            CAPTURE(seed);
            const ControlMesh mesh = make_mesh(seed, triangles, seed % 2 == 1, true);
            // An attribute that is the position: the same masks give the same numbers.
            VertexAttribute attribute{"p", 3, {}};
            for (const Vec3d& p : mesh.positions())
                for (int i = 0; i < 3; ++i) attribute.values.push_back(static_cast<float>(p[i]));
            RefineOptions options{.rules = c.rules, .limit = seed == 1, .normals = seed == 1};
            options.attributes = {&attribute, 1};
            const PolygonMesh ours = refine(mesh, scheme, c.levels, options);
            // Stencils are always made by the rules.
            const PolygonMesh expected = refine_stencils(mesh, scheme, c.levels, options).mesh;
            const double size = bounding_box(mesh.positions()).diagonal();
            REQUIRE(ours.face_count() == expected.face_count());
            CHECK(farthest_apart(ours.positions, expected.positions) < 1e-12 * size);
            CHECK(farthest_apart(marks(ours, false), marks(expected, false)) < 1e-11 * (size + size * size));
            REQUIRE(ours.face_uvs.size() == expected.face_uvs.size());
            CHECK(ours.uvs.size() == expected.uvs.size());
            CHECK(farthest_apart(marks(ours, true), marks(expected, true)) < 1e-11 * (100 + size) * (100 + size));
            REQUIRE(ours.attributes.size() == 1);
            double worst = 0;
            for (std::size_t v = 0; v < ours.positions.size(); ++v)
                for (int i = 0; i < 3; ++i)
                    worst = std::max(worst, std::abs(ours.attributes[0].values[3 * v + i] - ours.positions[v][i]));
            CHECK(worst < 1e-5 * size);
            CHECK(ours.face_material == expected.face_material);
        }
    }
}

TEST_CASE("[slow] creases of dual schemes by rows that repeat themselves are those of the rules") {
    for (const Case& c : cases()) {
        if (!is_dual(c)) continue;
        CAPTURE(c.scheme);
        int repeated = 0;
        for (const std::uint64_t seed : test::seeds(12)) {
            CAPTURE(seed);
            const bool limit = seed % 2 == 0;
            const ControlMesh mesh = make_mesh(3 * (seed % 3) + seed % 2, false, false);
            repeated += check_rows(with_creases(mesh, seed, limit, seed % 12 >= 6), c, limit, limit);
        }
        CHECK(repeated >= 12);
    }
}

TEST_CASE("[slow] rows of tags that turn smooth on the way are those of the rules, limits and normals as well") {
    for (const Case& c : cases()) {
        if (is_dual(c)) continue;
        CAPTURE(c.scheme);
        for (const std::uint64_t seed : test::seeds(6)) {
            CAPTURE(seed);
            const ControlMesh mesh = with_turning_tags(make_mesh(seed, takes_triangles(c), false), seed, c.levels);
            const bool limit = seed % 2 == 1 && !is_linear(*find_scheme(c.scheme));
            CHECK(check_rows(mesh, c, limit, limit));
        }
    }
}

TEST_CASE("[slow] boundaries that recede: rows that repeat themselves give what the rules give") {
    int repeated = 0, all = 0;
    for (const std::uint64_t seed : test::seeds(8))
        for (int steps = 1; steps <= 5; ++steps) {
            CAPTURE(seed);
            CAPTURE(steps);
            const ControlMesh mesh = open_mesh(seed);
            VertexAttribute attribute{"x", 1, {}};
            for (const Vec3d& p : mesh.positions()) attribute.values.push_back(static_cast<float>(p.x));
            RefineOptions options;
            options.attributes = {&attribute, 1};
            options.smoothing = static_cast<int>(seed % 3);
            options.normals = seed % 4 >= 2;
            options.limit = seed % 4 == 3 && steps < 5;
            options.rules.averaging_steps = steps;
            options.rules.averaging_boundary = AveragingBoundary::recede;
            const SchemeInfo& scheme = *find_scheme(steps == 3 ? "biquartic" : "averaging");
            const std::optional<PolygonMesh> expected = by_stencils(mesh, scheme, 4, options);
            if (!expected) continue;
            const PolygonMesh ours = refine(mesh, scheme, 4, options);
            const double size = bounding_box(mesh.positions()).diagonal();
            ++all;
            // By rules they would be in the same order.
            if (ours.positions != expected->positions) ++repeated;

            std::vector<std::uint32_t> vertex, face;
            CHECK(find(expected->positions, ours.positions, vertex) < 1e-12 * size);
            CHECK(find(marks(*expected, false), marks(ours, false), face) < 1e-11 * (size + size * size));
            if (!options.normals) {
                CHECK(ours.positions.size() == expected->positions.size());
                CHECK(ours.face_count() == expected->face_count());
            }
            CHECK(ours.warnings == expected->warnings);
            int other_material = 0;
            for (std::size_t f = 0; f < face.size(); ++f)
                other_material += ours.face_material[face[f]] != expected->face_material[f];
            CHECK(other_material == 0);
            double worst = 0, worst_value = 0;
            REQUIRE(ours.normals.size() == (options.normals ? ours.positions.size() : 0));
            REQUIRE(ours.attributes[0].values.size() == ours.positions.size());
            for (std::size_t v = 0; v < vertex.size(); ++v) {
                worst_value = std::max(worst_value, std::abs(double(ours.attributes[0].values[vertex[v]]) -
                                                             double(expected->attributes[0].values[v])));
                if (options.normals)
                    worst = std::max(worst, glm::length(ours.normals[vertex[v]] - expected->normals[v]));
            }
            CHECK(worst < 1e-7);
            CHECK(worst_value < 1e-5 * size);
            for (const Vec3d& n : ours.normals) CHECK(std::abs(glm::length(n) - 1) < 1e-9);
        }
    CHECK(repeated > all / 2);
}

TEST_CASE("faces beside boundaries that recede lie in their control faces") {
    constexpr std::uint32_t n = 8;
    ControlMeshData data = test::grid(n);
    for (std::uint32_t f = 0; f < n * n; ++f) {
        data.face_material.push_back(f);
        data.materials.push_back(std::to_string(f));
    }
    const ControlMesh mesh = ControlMesh::build(std::move(data));
    for (int steps = 1; steps <= 5; ++steps)
        for (int levels = 1; levels <= 4; ++levels) {
            CAPTURE(steps);
            CAPTURE(levels);
            RefineOptions options;
            options.rules.averaging_steps = steps;
            options.rules.averaging_boundary = AveragingBoundary::recede;
            const SchemeInfo& scheme = *find_scheme("averaging");
            for (const PolygonMesh& refined :
                 {refine(mesh, scheme, levels, options), refine_stencils(mesh, scheme, levels, options).mesh}) {
                REQUIRE(refined.face_count() > 0);
                int outside = 0;
                for (std::uint32_t f = 0; f < refined.face_count(); ++f) {
                    Vec3d centre(0);
                    for (std::uint32_t c = refined.face_offsets[f]; c < refined.face_offsets[f + 1]; ++c)
                        centre += 0.25 * refined.positions[refined.face_vertices[c]];
                    const std::uint32_t in = refined.face_material[f];
                    outside +=
                        std::max(std::abs(centre.x - in % n - 0.5), std::abs(centre.y - in / n - 0.5)) > 0.5 + 1e-9;
                }
                CHECK(outside == 0);
            }
        }
}

TEST_CASE("hundreds of edges around a vertex and around a face: rows that repeat themselves are those of the rules") {
    constexpr std::uint32_t k_edges = 260;
    for (const Case& c : {Case{"doo-sabin", 3}, Case{"tuned-loop", 3}, Case{"4-8", 3}}) {
        CAPTURE(c.scheme);
        // A pyramid; where faces are triangles, two of them back to back.
        std::vector<Vec3d> positions;
        for (std::uint32_t i = 0; i < k_edges; ++i) {
            const double angle = 2 * std::numbers::pi * i / k_edges, r = 1 + 0.1 * std::sin(5 * angle);
            positions.emplace_back(r * std::cos(angle), r * std::sin(angle), 0.1 * std::cos(3 * angle));
        }
        positions.emplace_back(0, 0, 1);
        std::vector<std::vector<std::uint32_t>> faces;
        for (std::uint32_t i = 0; i < k_edges; ++i) faces.push_back({i, (i + 1) % k_edges, k_edges});
        if (takes_triangles(c)) {
            positions.emplace_back(0, 0, -1);
            for (std::uint32_t i = 0; i < k_edges; ++i) faces.push_back({(i + 1) % k_edges, i, k_edges + 1});
        } else {
            faces.emplace_back();
            for (std::uint32_t i = k_edges; i-- > 0;) faces.back().push_back(i);
        }
        CHECK(check_rows(ControlMesh::build(test::mesh_data(std::move(positions), faces)), c));
    }
}

TEST_CASE("semi-sharp tags of dual schemes leave the mesh that the rules leave") {
    // A grid with a line of creases across it, or a tagged corner on its boundary.
    constexpr std::uint32_t n = 6;
    for (const bool crease : {true, false})
        for (const float sharpness : {1.0f, 1.5f, 2.0f, 2.5f, 4.5f}) {
            ControlMeshData data = test::skewed_grid(n);
            for (std::uint32_t x = 0; crease && x < n; ++x)
                data.creases.push_back({3 * (n + 1) + x, 3 * (n + 1) + x + 1, sharpness});
            if (!crease) data.corners.push_back({3, sharpness});
            const ControlMesh mesh = ControlMesh::build(std::move(data));
            for (const char* scheme : {"doo-sabin", "midedge", "biquartic"}) {
                CAPTURE(scheme);
                CAPTURE(sharpness);
                const PolygonMesh ours = refine(mesh, scheme, 4),
                                  expected = refine_stencils(mesh, *find_scheme(scheme), 4).mesh;
                REQUIRE(ours.positions.size() == expected.positions.size());
                CHECK(ours.face_count() == expected.face_count());
                CHECK(farthest_apart(ours.positions, expected.positions) < 1e-11);
            }
        }
}

TEST_CASE("limits beside a crease that bends at a vertex of regular valence are the same seen from any level") {
    // A triangular lattice whose crease leaves two faces on one side of the middle, four on the other.
    constexpr std::uint32_t n = 7, middle = n / 2;
    const auto at = [](std::uint32_t x, std::uint32_t y) { return y * n + x; };
    ControlMeshData data;
    data.face_offsets = {0};
    for (std::uint32_t y = 0; y < n; ++y)
        for (std::uint32_t x = 0; x < n; ++x)
            data.positions.emplace_back(x + 0.5 * y + 0.1 * std::sin(7.0 * at(x, y)), 0.8 * y,
                                        std::cos(5.0 * at(x, y)));
    for (std::uint32_t y = 0; y + 1 < n; ++y)
        for (std::uint32_t x = 0; x + 1 < n; ++x)
            for (const auto& face : {std::array{at(x, y), at(x + 1, y), at(x, y + 1)},
                                     std::array{at(x + 1, y), at(x + 1, y + 1), at(x, y + 1)}}) {
                data.face_vertices.insert(data.face_vertices.end(), face.begin(), face.end());
                data.face_offsets.push_back(static_cast<std::uint32_t>(data.face_vertices.size()));
            }
    for (std::uint32_t i = 0; i < middle; ++i) {
        data.creases.push_back({at(i, middle), at(i + 1, middle), k_sharpness_infinity});
        data.creases.push_back({at(middle, middle + i), at(middle, middle + i + 1), k_sharpness_infinity});
    }
    const ControlMesh mesh = ControlMesh::build(std::move(data));
    const RefineOptions plain{.limit = true, .normals = true};
    RefineOptions hoppe = plain;
    hoppe.rules.hoppe_crease = true;
    const std::pair<std::string_view, RefineOptions> chosen[] = {
        {"loop", plain}, {"loop", hoppe}, {"tuned-loop", plain}, {"modified-butterfly", plain}};
    for (const auto& [name, options] : chosen) {
        CAPTURE(name);
        for (const auto& [early, late] : {std::pair(1, 2), {2, 4}}) {
            const PolygonMesh a = refine(mesh, *find_scheme(name), early, options),
                              b = refine(mesh, *find_scheme(name), late, options);
            const PointMatch in_b(b.positions), in_control(mesh.positions());
            double worst = 0, worst_normal = 0;
            for (std::size_t v = 0; v < a.positions.size(); ++v) {
                const std::uint32_t w = in_b.nearest(a.positions[v]);
                worst = std::max(worst, glm::length(a.positions[v] - b.positions[w]));
                // Corners stay where they are, and have the mean normal of their faces.
                const Vec3d& nearest = mesh.positions()[in_control.nearest(a.positions[v])];
                if (!options.rules.hoppe_crease && glm::length(a.positions[v] - nearest) > 1e-9)
                    worst_normal = std::max(worst_normal, glm::length(a.normals[v] - b.normals[w]));
            }
            CHECK(worst < 1e-12);
            CHECK(worst_normal < 1e-9);
        }
    }
}

TEST_CASE("two averaging steps that recede know no creases where a mesh is closed") {
    const ControlMesh torus = make_mesh(3, false, false);
    ControlMeshData data = torus.data();
    for (std::uint32_t h = 0; h < torus.halfedge_count(); h += 3)
        data.creases.push_back(
            {torus.origin(HalfedgeId(h)).value, torus.target(HalfedgeId(h)).value, k_sharpness_infinity});
    const ControlMesh mesh = ControlMesh::build(std::move(data));
    RefineOptions options;
    options.rules.averaging_steps = 2;
    options.rules.averaging_boundary = AveragingBoundary::recede;
    const SchemeInfo& scheme = *find_scheme("averaging");
    CHECK(farthest_apart(refine(mesh, scheme, 4, options).positions,
                         refine_stencils(mesh, scheme, 4, options).mesh.positions) < 1e-11);
}

TEST_CASE("rows do not repeat themselves where there are too few levels") {
    const ControlMesh smooth = make_mesh(2, true, false);
    CHECK(check_rows(smooth, {"modified-butterfly", 4}));
    CHECK_FALSE(check_rows(smooth, {"modified-butterfly", 2}));
    CHECK_FALSE(check_rows(smooth, {"honeycomb", 5}));
    ControlMeshData data = smooth.data();
    std::uint32_t inner = 0;
    while (!smooth.twin(HalfedgeId(inner)).valid()) ++inner;
    data.creases.push_back({smooth.origin(HalfedgeId(inner)).value, smooth.target(HalfedgeId(inner)).value, 3.5f});
    // Sharp for ever.
    CHECK(check_rows(ControlMesh::build(data), {"doo-sabin", 4}));
    CHECK(check_rows(ControlMesh::build(data), {"modified-butterfly", 4}));
}

TEST_CASE("refinement by repeated rows can be cancelled, charts as well") {
    const ControlMesh mesh = make_mesh(3, true, false, true);
    int calls = 0;
    RefineOptions options;
    options.context.progress = [&](std::string_view, double) { return ++calls > 0; };
    refine(mesh, "butterfly", 5, options);
    const int all = calls;
    CHECK(all > 4);
    for (int stop = 1; stop <= all; ++stop) {
        calls = 0;
        options.context.progress = [&](std::string_view, double) { return ++calls < stop; };
        CHECK_THROWS_AS(refine(mesh, "butterfly", 5, options), Error);
    }
}

TEST_SUITE_END();
