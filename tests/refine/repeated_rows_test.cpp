#include "../../refine/uniform/repeated_rows.hpp"

#include "../kit/corner_angle_mesh.hpp"
#include "../kit/point_match.hpp"
#include "../kit/random_mesh.hpp"

#include "../../hier/base/error.hpp"
#include "../../hier/mesh/triangulate.hpp"
#include "../../refine/rules/rule_refiner.hpp"
#include "../../refine/uniform/refine.hpp"
#include "../../schemes/rules/linear.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <memory>
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
            {"tuned-loop", 4},
            {"butterfly", 4},
            {"modified-butterfly", 4},
            {"sqrt3", 4},
            {"catmull-clark", 4, cosine},
            {"catmull-clark", 4, measured},
            {"kobbelt", 5},
            {"4-8", 4},
            {"bilinear", 4},
            {"midpoint", 4},
            {"averaging", 4, two},
            {"averaging", 4, four},
            {"doo-sabin", 4},
            {"doo-sabin-cc", 4},
            {"midedge", 4},
            {"midedge-simplest", 4},
            {"biquartic", 4}};
}

/// @param sharp_for_ever  or without anything sharp but boundaries
ControlMesh make_mesh(std::uint64_t seed, bool triangles, bool sharp_for_ever) {
    test::RandomMeshOptions options = test::random_options(seed);
    options.columns = 3 + static_cast<int>(seed % 2);
    options.rows = 3;
    // Two of three are without creases, one of them closed: what dual schemes ask for.
    if (seed % 3 != 2) options.edge_vertices = options.hole = options.crease = options.corner = 0;
    if (seed % 3 == 0) {
        options.topology = seed % 2 == 0 ? test::Topology::sphere : test::Topology::torus;
        options.removed_faces = 0;
    }
    if (!sharp_for_ever) options.crease = options.corner = 0;
    ControlMeshData data = test::random_mesh_data(seed, options);
    for (auto& tag : data.creases) tag.sharpness = k_sharpness_infinity;
    for (auto& tag : data.corners) tag.sharpness = k_sharpness_infinity;
    const ControlMesh mesh = ControlMesh::build(std::move(data));
    return triangles ? triangulate(mesh) : mesh;
}

/// One point per face, other ones for faces whose corners are turned or exchanged.
std::vector<Vec3d> marks(const PolygonMesh& mesh) {
    std::vector<Vec3d> result;
    for (std::uint32_t f = 0; f < mesh.face_count(); ++f) {
        const std::uint32_t begin = mesh.face_offsets[f], end = mesh.face_offsets[f + 1];
        Vec3d sum(0), turn(0);
        for (std::uint32_t c = begin; c < end; ++c) {
            const std::uint32_t next = c + 1 == end ? begin : c + 1;
            const Vec3d &p = mesh.positions[mesh.face_vertices[c]], &q = mesh.positions[mesh.face_vertices[next]];
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

/// Creases along edges here and there, most of which end at darts, or around regions of faces, of which none does; each
/// as sharp as one of these, and a corner as the first and as the last.
ControlMesh with_tags(const ControlMesh& mesh, std::uint64_t seed, bool darts, const std::vector<float>& sharpness) {
    ControlMeshData data = mesh.data();
    test::Random random(seed);
    std::vector<bool> region;
    for (std::uint32_t f = 0; f < mesh.face_count(); ++f) region.push_back(random.chance(0.5));
    for (std::uint32_t e = 0; e < mesh.edge_count(); ++e) {
        const HalfedgeId h = mesh.edge_halfedge(EdgeId(e)), t = mesh.twin(h);
        if (!t.valid() || (darts ? !random.chance(0.25) : region[mesh.face(h).value] == region[mesh.face(t).value]))
            continue;
        const float s = sharpness[random.below(static_cast<std::uint32_t>(sharpness.size()))];
        data.creases.push_back({mesh.origin(h).value, mesh.target(h).value, s});
    }
    for (const float s : {sharpness.front(), sharpness.back()})
        data.corners.push_back({random.below(mesh.vertex_count()), s});
    return ControlMesh::build(std::move(data));
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
    by_rules.refine(mesh.positions(), points, point_normals);
    const double size = bounding_box(mesh.positions()).diagonal();
    CHECK(farthest_apart(ours.positions, points) < 1e-12 * size);

    detail::RepeatedRows::Faces faces = rows->faces({});
    ours.face_offsets = std::move(faces.offsets);
    ours.face_vertices = std::move(faces.vertices);
    CHECK(farthest_apart(marks(ours), marks(mesh_of(by_rules, points))) < 1e-11 * (size + size * size));
    std::vector<int> cells(mesh.face_count(), 0);
    for (std::uint32_t f = 0; f < by_rules.face_count(); ++f) --cells[by_rules.control_face(f)];
    for (const std::uint32_t f : faces.control) ++cells[f];
    CHECK(std::ranges::count(cells, 0) == static_cast<std::ptrdiff_t>(cells.size()));

    if (!normals) return true;
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
        const bool linear = find_scheme(c.scheme)->is_linear();  // no tangents, and limits in ways of their own
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

TEST_CASE(
    "[slow] rows beside creases of dual schemes, and of tags that turn smooth on the way, are those of the rules") {
    for (const Case& c : cases()) {
        CAPTURE(c.scheme);
        int repeated = 0;
        for (const std::uint64_t seed : test::seeds(is_dual(c) ? 8 : 4)) {
            CAPTURE(seed);
            const bool limit = seed % 2 == 1 && !find_scheme(c.scheme)->is_linear();
            const float last = static_cast<float>(c.levels);
            // Sharp beyond the last level is as sharp as for ever; but not for limits.
            const std::vector<float> for_ever{k_sharpness_infinity, limit ? k_sharpness_infinity : 8.5f},
                turning{0.6f, 1.0f, last - 1, last + 0.5f, k_sharpness_infinity, last - 0.4f};
            const ControlMesh mesh =
                make_mesh(is_dual(c) ? 3 * (seed % 3) + seed % 2 : seed, takes_triangles(c), false);
            repeated += check_rows(with_tags(mesh, seed, !is_dual(c) || seed >= 6, is_dual(c) ? for_ever : turning), c,
                                   limit, limit);
        }
        CHECK(repeated >= (is_dual(c) ? 8 : 4));
    }
}

TEST_CASE("hundreds of edges around a vertex and around a face: rows that repeat themselves are those of the rules") {
    const ControlMesh mesh = ControlMesh::build(test::pyramid(260));
    for (const Case& c : {Case{"doo-sabin", 3}, Case{"tuned-loop", 3}, Case{"4-8", 3}}) {
        CAPTURE(c.scheme);
        CHECK(check_rows(test::mesh_for(*find_scheme(c.scheme), mesh), c));
    }
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
            const PolygonMesh refined = refine(mesh, scheme, levels, options);
            REQUIRE(refined.face_count() > 0);
            int outside = 0;
            for (std::uint32_t f = 0; f < refined.face_count(); ++f) {
                Vec3d centre(0);
                for (std::uint32_t c = refined.face_offsets[f]; c < refined.face_offsets[f + 1]; ++c)
                    centre += 0.25 * refined.positions[refined.face_vertices[c]];
                const std::uint32_t in = refined.face_material[f];
                outside += std::max(std::abs(centre.x - in % n - 0.5), std::abs(centre.y - in / n - 0.5)) > 0.5 + 1e-9;
            }
            CHECK(outside == 0);
        }
}

TEST_CASE("limits beside a crease that bends at a vertex of regular valence are the same seen from any level") {
    // The sheet's crease that turns down leaves two triangles on one side of the bend and four on the other.
    ControlMeshData data = test::sheet(true).data();
    data.corners.clear();
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

TEST_CASE("refinement by repeated rows can be cancelled, charts as well") {
    ControlMeshData data = make_mesh(3, true, false).data();
    test::add_charts(data);
    const ControlMesh mesh = ControlMesh::build(std::move(data));
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
