#include "../kit/corner_angle_mesh.hpp"
#include "../kit/nearest.hpp"
#include "../kit/random_mesh.hpp"

#include "../../hier/base/error.hpp"
#include "../../hier/mesh/triangulate.hpp"
#include "../../refine/uniform/position_refiner.hpp"
#include "../../refine/uniform/refine.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

// refine() has several code paths, which depend on scheme, mesh, tags, level and options. A table of such cases
// compares all of them with the general path: rows of refine_stencils() times the control points.

using namespace tetrakis;

namespace {

enum class Shape { closed, open, prism, valence_2, many_edges, hole };
constexpr Shape k_shapes[] = {Shape::closed,    Shape::open,       Shape::prism,
                              Shape::valence_2, Shape::many_edges, Shape::hole};
enum class Tags { none, crease, semi_sharp, dart, corner, seams };
constexpr Tags k_tags[] = {Tags::none, Tags::crease, Tags::semi_sharp, Tags::dart, Tags::corner, Tags::seams};

/// A prism over an n-gon. @param valence_2  adds a vertex in the middle of an upright edge
ControlMeshData prism(std::uint32_t n, bool valence_2 = false) {
    std::vector<Vec3d> positions;
    std::vector<std::vector<std::uint32_t>> faces(2);
    for (int top = 0; top < 2; ++top)
        for (std::uint32_t i = 0; i < n; ++i) positions.push_back(test::on_unit_circle(i, n, top));
    for (std::uint32_t i = 0; i < n; ++i) {
        const std::uint32_t j = (i + 1) % n;
        faces[0].push_back(n - 1 - i);
        faces[1].push_back(n + i);
        faces.push_back({i, j, n + j, n + i});
    }
    if (valence_2) {
        positions.emplace_back(1.2, 0.1, 0.5);
        faces[2].push_back(2 * n);
        faces.back() = {n - 1, 0, 2 * n, n, 2 * n - 1};
    }
    return test::mesh_data(std::move(positions), faces);
}

ControlMeshData shape_data(Shape shape) {
    if (shape == Shape::open) return test::skewed_grid(3);
    if (shape == Shape::many_edges) return test::pyramid(40);
    ControlMeshData data = prism(shape == Shape::prism || shape == Shape::hole ? 5 : 4, shape == Shape::valence_2);
    if (shape == Shape::hole) data.holes = {1};
    return data;
}

/// Gives each face its own material.
void add_materials(ControlMeshData& data) {
    for (std::uint32_t f = 0; f + 1 < data.face_offsets.size(); ++f) {
        data.face_material.push_back(f);
        data.materials.push_back("material " + std::to_string(f));
    }
}

ControlMesh make_mesh(const SchemeInfo& scheme, Shape shape, Tags tags) {
    ControlMeshData data = shape_data(shape);
    test::Random random(7);
    for (Vec3d& p : data.positions)
        p += 0.1 * Vec3d(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1));
    add_materials(data);
    if (tags == Tags::seams) test::add_charts(data);
    ControlMesh mesh = ControlMesh::build(std::move(data));
    if (scheme.family == MeshFamily::triangles) mesh = triangulate(mesh);
    data = mesh.data();
    // Tags are along the edges of the last face, or of the middle face of the open mesh.
    const FaceId face(shape == Shape::open ? mesh.face_count() / 2 : mesh.face_count() - 1);
    std::vector<HalfedgeId> loop{mesh.face_halfedge(face)};
    while (loop.size() < mesh.face_size(face)) loop.push_back(mesh.next(loop.back()));
    switch (tags) {
        case Tags::none:
        case Tags::seams:
            break;
        case Tags::crease:
            for (const HalfedgeId h : loop)
                data.creases.push_back({mesh.origin(h).value, mesh.target(h).value, k_infinite_sharpness});
            break;
        case Tags::semi_sharp:
            for (const HalfedgeId h : loop)
                data.creases.push_back({mesh.origin(h).value, mesh.target(h).value, h == loop[0] ? 2.3f : 1.5f});
            break;
        case Tags::dart:
            data.creases.push_back({mesh.origin(loop[1]).value, mesh.target(loop[1]).value, k_infinite_sharpness});
            break;
        case Tags::corner:
            data.corners.push_back({mesh.origin(loop[0]).value, k_infinite_sharpness});
            data.corners.push_back({mesh.origin(loop[2]).value, 1.5f});
            break;
    }
    return ControlMesh::build(std::move(data));
}

struct Entry {
    Shape shape;
    Tags tags;
    int level;
    bool limit;
};

/// The levels that are compared. At the last one, refine() uses repeating stencil rows instead of the general rules.
std::vector<int> levels_of(const SchemeInfo& scheme) {
    if (scheme.refinement == Refinement::honeycomb) return {0, 1, 2, 3};  // has no repeating rows
    return {0, 1, 2, scheme.refinement == Refinement::sqrt3 ? 4 : 5};
}

/// Whether an entry is compared. The other entries would take too long.
bool is_in_table(const SchemeInfo& scheme, const Entry& e) {
    const bool few_tags = e.tags == Tags::none || e.tags == Tags::crease || e.tags == Tags::seams;
    if (e.shape == Shape::many_edges) {
        if (scheme.averaging_steps != 0) return e.level <= 1 && e.tags == Tags::none;
        return e.limit ? e.level <= 1 && few_tags : e.level <= 1 || (e.level == 2 && few_tags);
    }
    // The default of three averaging steps is the biquartic scheme, which has its own table.
    if (scheme.averaging_steps == SchemeInfo::k_chosen_steps && e.limit && !few_tags) return false;
    if (e.level <= 1) return true;
    // "biquartic" has the same rules.
    if (e.level > 2 && scheme.averaging_steps == SchemeInfo::k_chosen_steps) return false;
    if (e.level == 2) return !e.limit || e.shape == Shape::closed || e.shape == Shape::open;
    if (scheme.refinement == Refinement::sqrt3)
        return !e.limit && (e.tags == Tags::none || e.tags == Tags::crease) && e.shape == Shape::closed;
    if (e.limit) return e.tags == Tags::none && (e.shape == Shape::closed || e.shape == Shape::open);
    if (e.tags == Tags::semi_sharp) return e.shape == Shape::open && scheme.refinement == Refinement::vertex_split;
    return few_tags && (e.shape == Shape::closed || e.shape == Shape::open || e.shape == Shape::hole);
}

/// For each face, by its renumbered corners from the least one on: its number, and the position of that corner.
std::map<std::vector<std::uint32_t>, std::pair<std::uint32_t, std::uint32_t>> face_numbers(
    const PolygonMesh& mesh, const std::vector<std::uint32_t>& number) {
    std::map<std::vector<std::uint32_t>, std::pair<std::uint32_t, std::uint32_t>> result;
    std::uint32_t f = 0;
    for (auto face : test::faces_of(mesh)) {
        for (std::uint32_t& v : face) v = number[v];
        const auto least = std::min_element(face.begin(), face.end());
        const auto first = static_cast<std::uint32_t>(least - face.begin());
        std::rotate(face.begin(), least, face.end());
        result[face] = {f++, first};
    }
    return result;
}

bool has_two_faces(const ControlMesh& mesh, VertexId v) { return !mesh.is_boundary(v) && mesh.face_valence(v) == 2; }

/// Number of vertices at which Catmull-Clark and Loop have no tangent plane, so that the normal is a matter of choice.
int without_tangent_plane(const ControlMesh& mesh) {
    int count = 0;
    for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v)
        count += mesh.sharpness(VertexId(v)) == k_sharpness_infinity || has_two_faces(mesh, VertexId(v));
    return count;
}

bool same_mesh(const PolygonMesh& a, const PolygonMesh& b) {
    bool same = test::same_bytes(a.positions, b.positions) && test::same_bytes(a.normals, b.normals) &&
                test::same_bytes(a.uvs, b.uvs) && a.face_offsets == b.face_offsets &&
                a.face_vertices == b.face_vertices && a.face_uvs == b.face_uvs && a.face_material == b.face_material &&
                a.attributes.size() == b.attributes.size();
    for (std::size_t i = 0; same && i < a.attributes.size(); ++i)
        same = test::same_bytes(a.attributes[i].values, b.attributes[i].values);
    return same;
}

/// Compares refine() with the rows. Returns false, without a comparison, if both report the case as unsupported.
bool compare(const SchemeInfo& scheme, const ControlMesh& mesh, int level, RefineOptions options) {
    VertexAttribute attribute{"numbers", 2, {}};
    test::Random random(11);
    for (std::uint32_t v = 0; v < 2 * mesh.vertex_count(); ++v)
        attribute.values.push_back(static_cast<float>(random.uniform(-1, 1)));
    options.attributes = {&attribute, 1};
    RefinedStencils expected;
    try {
        expected = refine_stencils(mesh, scheme, level, options);
    } catch (const Error& e) {
        // A level by itself is refused where further steps that recede take its fault away.
        if (options.rules.averaging_boundary == AveragingBoundary::recede) return false;
        REQUIRE(e.code() == ErrorCode::unsupported);
        ErrorCode code{};
        try {
            refine(mesh, scheme, level, options);
        } catch (const Error& ours) {
            code = ours.code();
        }
        CHECK(code == ErrorCode::unsupported);
        return false;
    }
    options.context.threads = 1;
    const PolygonMesh ours = refine(mesh, scheme, level, options);
    options.context.threads = 2;
    CHECK(same_mesh(ours, refine(mesh, scheme, level, options)));
    CHECK(ours.warnings == expected.mesh.warnings);

    // The rows times the control points are the mesh's vertices.
    const double size = mesh.bounding_box().diagonal();
    const std::size_t count = expected.mesh.positions.size();
    REQUIRE(expected.stencils.row_count() == static_cast<int>(count));
    std::vector<Vec3d> rows(count);
    expected.stencils.apply<Vec3d>(mesh.positions(), rows);
    double rows_apart = 0;
    for (std::size_t v = 0; v < count; ++v)
        rows_apart = std::max(rows_apart, glm::length(rows[v] - expected.mesh.positions[v]));
    CHECK(rows_apart < 1e-13 * size);

    // Points, one for one.
    REQUIRE(ours.positions.size() == count);
    const PointMatch match(rows);
    std::vector<std::uint32_t> number;
    double apart = 0;
    for (const Vec3d& p : ours.positions) {
        number.push_back(match.nearest(p));
        apart = std::max(apart, glm::length(rows[number.back()] - p));
    }
    CHECK(apart < 1e-12 * size);
    if (std::set<std::uint32_t>(number.begin(), number.end()).size() < count) {
        // Folded edges give two vertices at one point, so a position does not tell which one a face uses.
        bool is_twice = false;
        for (std::uint32_t v = 0; v < count; ++v) is_twice |= match.count_within(rows[v], 1e-12 * size) > 1;
        CHECK(is_twice);
        return true;
    }

    // Faces, with orientation, material and texture coordinates.
    std::vector<std::uint32_t> identity(count);
    for (std::uint32_t v = 0; v < count; ++v) identity[v] = v;
    const auto our_faces = face_numbers(ours, number), their_faces = face_numbers(expected.mesh, identity);
    REQUIRE(ours.face_count() == expected.mesh.face_count());
    REQUIRE(our_faces.size() == ours.face_count());
    REQUIRE(ours.face_material.size() == ours.face_count());
    REQUIRE(ours.face_uvs.size() == expected.mesh.face_uvs.size());
    CHECK(ours.uvs.size() == expected.mesh.uvs.size());
    CHECK(ours.materials == expected.mesh.materials);
    CHECK(ours.face_uvs.empty() == !mesh.has_uvs());
    std::size_t missing = 0, material = 0;
    double uv_apart = 0;
    for (const auto& [corners, at] : our_faces) {
        const auto other = their_faces.find(corners);
        if (other == their_faces.end()) {
            ++missing;
            continue;
        }
        const auto [f, first] = at;
        const auto [g, other_first] = other->second;
        material += ours.face_material[f] != expected.mesh.face_material[g] ? 1 : 0;
        if (ours.face_uvs.empty()) continue;
        for (std::uint32_t i = 0; i < corners.size(); ++i) {
            const auto n = static_cast<std::uint32_t>(corners.size());
            const Vec2d a = ours.uvs[ours.face_uvs[ours.face_offsets[f] + (first + i) % n]];
            const Vec2d b =
                expected.mesh.uvs[expected.mesh.face_uvs[expected.mesh.face_offsets[g] + (other_first + i) % n]];
            uv_apart = std::max(uv_apart, glm::length(a - b));
        }
    }
    CHECK(missing == 0);
    CHECK(material == 0);
    CHECK(uv_apart < 1e-12 * 100);

    // Attributes.
    REQUIRE(ours.attributes.size() == 1);
    REQUIRE(ours.attributes[0].values.size() == 2 * count);
    double attributes_apart = 0;
    for (std::size_t v = 0; v < count; ++v)
        for (std::size_t k = 0; k < 2; ++k) {
            double sum = 0;
            const int r = static_cast<int>(number[v]);
            for (std::size_t i = 0; i < expected.stencils.points(r).size(); ++i)
                sum += expected.stencils.weights(r)[i] *
                       attribute.values[2 * static_cast<std::size_t>(expected.stencils.points(r)[i]) + k];
            attributes_apart = std::max(attributes_apart, std::abs(sum - ours.attributes[0].values[2 * v + k]));
        }
    CHECK(attributes_apart < 1e-6);

    // Normals.
    REQUIRE(ours.normals.size() == expected.mesh.normals.size());
    int other_normals = 0;
    for (std::size_t v = 0; v < ours.normals.size(); ++v)
        other_normals += glm::length(ours.normals[v] - expected.mesh.normals[number[v]]) > 1e-9 ? 1 : 0;
    const bool plain = scheme.name == "catmull-clark" || scheme.name == "loop";
    CHECK(other_normals <= (plain ? without_tangent_plane(mesh) : 0));
    return true;
}

/// @param entries  least number of entries that are supported; for the others both paths must report an error
void check_table(std::string_view name, int entries) {
    CAPTURE(name);
    const SchemeInfo& scheme = scheme_named(name);
    int compared = 0;
    for (const Shape shape : k_shapes)
        for (const Tags tags : k_tags)
            for (const int level : levels_of(scheme))
                for (const bool limit : {false, true}) {
                    const Entry entry{shape, tags, level, limit};
                    if (!is_in_table(scheme, entry)) continue;
                    CAPTURE(static_cast<int>(shape));
                    CAPTURE(static_cast<int>(tags));
                    CAPTURE(level);
                    CAPTURE(limit);
                    const RefineOptions options{.limit = limit, .normals = limit};
                    compared += compare(scheme, make_mesh(scheme, shape, tags), level, options) ? 1 : 0;
                }
    CHECK(compared >= entries);
}

/// A random mesh with few faces and without tags. Every third mesh is closed.
ControlMeshData untagged_data(std::uint64_t seed, const SchemeInfo& scheme) {
    test::RandomMeshOptions options = test::random_options(seed);
    options.columns = 3 + static_cast<int>(seed % 2);
    options.rows = 3;
    options.crease = options.corner = 0;
    if (seed % 3 != 2) options.edge_vertices = options.hole = 0;
    if (seed % 3 == 0) {
        options.topology = seed % 2 == 0 ? test::Topology::sphere : test::Topology::torus;
        options.removed_faces = 0;
    }
    ControlMeshData data = test::mesh_for(scheme, test::random_mesh(seed, options)).data();
    add_materials(data);
    return data;
}

/// Adds creases along random edges (`darts`; most end at darts) or around random regions of faces, each with a value of
/// `sharpness`, and corners with its first and last value. If it is empty: no tags, but UVs in two charts.
ControlMesh with_tags(ControlMeshData data, std::uint64_t seed, bool darts, const std::vector<float>& sharpness) {
    if (sharpness.empty()) test::add_charts(data);
    const ControlMesh mesh = ControlMesh::build(data);
    if (sharpness.empty()) return mesh;
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

/// Checks that a PositionRefiner gives the bytes of refine(), also in buffers that hold older results.
void check_refined_again(const SchemeInfo& scheme, const ControlMesh& mesh, int level, const RefineOptions& options) {
    ControlMeshData data = mesh.data();
    test::Random random(3);
    for (Vec3d& p : data.positions) p += 0.05 * Vec3d(random.uniform(), random.uniform(), random.uniform());
    const ControlMesh moved = ControlMesh::build(std::move(data));
    const PositionRefiner refiner(mesh, scheme, level, options);
    CHECK(same_mesh(refiner.mesh(), refine(mesh, scheme, level, options)));
    PolygonMesh again = refiner.mesh();
    for (const ControlMesh* control : {&moved, &mesh, &moved})
        refiner.refine(control->positions(), again.positions, again.normals);
    CHECK(same_mesh(again, refine(moved, scheme, level, options)));
    CHECK(!test::same_bytes(again.positions, refiner.mesh().positions));
}

}  // namespace

TEST_SUITE_BEGIN("contract");

// Limits that are not supported: at vertices with two faces on level 0 of dual schemes, and at darts of honeycomb
// refinement.
TEST_CASE("[slow] refine() is rows of weights times the control points: loop, catmull-clark, 4-8") {
    for (const char* name : {"loop", "catmull-clark", "4-8"}) check_table(name, 194);
}

TEST_CASE("[slow] refine() is rows of weights times the control points: sqrt3, doo-sabin, midedge") {
    check_table("sqrt3", 185);
    for (const char* name : {"doo-sabin", "midedge"}) check_table(name, 191);
}

TEST_CASE("[slow] refine() is rows of weights times the control points: further schemes of triangles") {
    for (const char* name : {"tuned-loop", "butterfly", "modified-butterfly", "midpoint"}) check_table(name, 194);
}

TEST_CASE("[slow] refine() is rows of weights times the control points: further schemes of quads, dual ones") {
    for (const char* name : {"kobbelt", "bilinear"}) check_table(name, 194);
    for (const char* name : {"doo-sabin-cc", "midedge-simplest"}) check_table(name, 191);
}

TEST_CASE("[slow] refine() is rows of weights times the control points: averages, honeycomb, and no scheme left out") {
    check_table("biquartic", 172);
    check_table("averaging", 127);
    check_table("honeycomb", 182);
    CHECK(scheme_table().size() == 6 + 8 + 3);
}

TEST_CASE("[slow] refine() is rows of weights times the control points: other rules, receding boundaries") {
    // Corner angles on creases, with seams.
    for (const char* name : {"loop", "tuned-loop", "catmull-clark"}) {
        CAPTURE(name);
        const SchemeInfo& scheme = scheme_named(name);
        ControlMeshData data = test::with_mixed_angles(test::sheet(scheme.family == MeshFamily::triangles), 3).data();
        add_materials(data);
        CHECK(compare(scheme, ControlMesh::build(std::move(data)), 4, {.limit = true}));
    }
    RuleOptions receding{.averaging_steps = 2, .averaging_boundary = AveragingBoundary::recede};
    const SchemeInfo& averaging = scheme_named("averaging");
    CHECK(compare(averaging, make_mesh(averaging, Shape::closed, Tags::crease), 4, {.rules = receding}));
    int compared = 0;
    for (const std::uint64_t seed : {0, 1, 2})
        for (int steps = 1; steps <= 5; ++steps) {
            CAPTURE(seed);
            CAPTURE(steps);
            const test::RandomMeshOptions plane{.columns = 7, .rows = 7, .removed_faces = seed > 0 ? 1 : 0, .hole = 0};
            ControlMeshData data = test::random_mesh_data(seed, plane);
            add_materials(data);
            receding.averaging_steps = steps;
            const SchemeInfo& scheme = steps == 3 ? scheme_named("biquartic") : averaging;
            const ControlMesh mesh = ControlMesh::build(std::move(data));
            if (!compare(scheme, mesh, 4, {.rules = receding, .smoothing = static_cast<int>(seed)})) continue;
            ++compared;
            if (steps > 3) continue;  // limits lie on what is left then
            // With normals there are vertices that no face needs.
            const RefineOptions normals{.rules = receding, .normals = true};
            const PolygonMesh ours = refine(mesh, scheme, 4, normals),
                              rules = refine_stencils(mesh, scheme, 4, normals).mesh;
            const PointMatch match(ours.positions);
            double off = 0;
            for (std::size_t v = 0; v < rules.positions.size(); ++v)
                off = std::max(off, glm::length(ours.normals[match.nearest(rules.positions[v])] - rules.normals[v]));
            CHECK(off < 1e-7);
        }
    CHECK(compared > 10);
}

TEST_CASE(
    "[slow] refine() is rows of weights times the control points: random meshes, tags that turn smooth on the way") {
    struct Row {
        std::string_view scheme;
        RuleOptions rules{};
    };
    constexpr EdgeBesideCrease cosine = EdgeBesideCrease::cosine;
    for (const auto& [name, rules] : {Row{"loop", {.loop_weights = LoopWeights::warren}},
                                      Row{"loop", {.edge_beside_crease = cosine}},
                                      Row{"loop", {.measure_corner_angles = true}},
                                      Row{"tuned-loop"},
                                      Row{"butterfly"},
                                      Row{"modified-butterfly"},
                                      Row{"sqrt3"},
                                      Row{"catmull-clark", {.edge_beside_crease = cosine}},
                                      Row{"catmull-clark", {.measure_corner_angles = true}},
                                      Row{"kobbelt"},
                                      Row{"4-8"},
                                      Row{"bilinear"},
                                      Row{"midpoint"},
                                      Row{"averaging", {.averaging_steps = 2}},
                                      Row{"averaging", {.averaging_steps = 4}},
                                      Row{"doo-sabin"},
                                      Row{"doo-sabin-cc"},
                                      Row{"midedge"},
                                      Row{"midedge-simplest"},
                                      Row{"biquartic"}}) {
        CAPTURE(name);
        const SchemeInfo& scheme = scheme_named(name);
        const int levels = levels_of(scheme).back();
        const float last = static_cast<float>(levels);
        const bool dual = fan_lattice(scheme, rules) == FanLattice::dual;
        for (const std::uint64_t seed : test::seeds(dual ? 6 : 4)) {
            CAPTURE(seed);
            std::vector<float> sharpness;
            if (seed % 4 == 1) sharpness = {k_infinite_sharpness};
            if (seed % 4 == 2) sharpness = {0.7f, 0.8f};
            if (seed % 4 == 3) sharpness = {0.6f, 1.0f, last - 1, last + 0.5f, k_infinite_sharpness, last - 0.4f};
            if (dual && seed % 4 > 1) sharpness = {k_infinite_sharpness};
            const ControlMesh mesh = with_tags(untagged_data(seed, scheme), seed, !dual || seed == 5, sharpness);
            CHECK(compare(scheme, mesh, levels, {.rules = rules}));
            if (!scheme.is_linear()) compare(scheme, mesh, levels, {.rules = rules, .limit = true, .normals = true});
        }
    }
    // Hundreds of edges around a vertex and around a face.
    ControlMeshData wide = test::pyramid(260);
    add_materials(wide);
    for (const char* name : {"doo-sabin", "tuned-loop", "4-8"})
        CHECK(compare(scheme_named(name), test::mesh_for(scheme_named(name), ControlMesh::build(wide)), 3, {}));
}

TEST_CASE("positions refined again are the bytes of refine() for control points that have moved") {
    for (const SchemeInfo& scheme : scheme_table())
        for (const Shape shape : {Shape::closed, Shape::open, Shape::hole})
            for (const bool limit : {false, true}) {
                CAPTURE(scheme.name);
                CAPTURE(static_cast<int>(shape));
                CAPTURE(limit);
                const ControlMesh mesh = make_mesh(scheme, shape, Tags::semi_sharp);
                check_refined_again(scheme, mesh, limit ? 1 : 3, {.limit = limit, .normals = limit});
            }
    const std::pair<const char*, RefineOptions> others[] = {
        {"loop", {.rules = {.edge_beside_crease = EdgeBesideCrease::cosine}}},
        {"catmull-clark", {.rules = {.catmull_clark_beta = 0.4}}},
        {"averaging", {.rules = {.averaging_steps = 4}}},
        {"kobbelt", {.smoothing = 2}},
        {"bilinear", {.smoothing = 2}},
        {"modified-butterfly", {.smoothing = 2}}};
    for (const auto& [name, options] : others) {
        CAPTURE(name);
        // With vertices without faces, before and after the others.
        ControlMeshData data = make_mesh(scheme_named(name), Shape::open, Tags::corner).data();
        data.holes = {0};
        data.positions.insert(data.positions.begin(), Vec3d(7, 8, 9));
        data.positions.emplace_back(-7, 8, 9);
        for (std::uint32_t& v : data.face_vertices) ++v;
        for (auto& tag : data.corners) ++tag.vertex;
        check_refined_again(scheme_named(name), ControlMesh::build(std::move(data)), 3, options);
    }
}

TEST_SUITE_END();
