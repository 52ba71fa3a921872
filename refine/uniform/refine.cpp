#include "refine.hpp"

#include "../../hier/base/error.hpp"
#include "../../hier/base/memory.hpp"
#include "../../hier/base/parallel.hpp"
#include "../../hier/mesh/triangulate.hpp"
#include "../attributes/followed_uvs.hpp"
#include "../attributes/used_values.hpp"
#include "../attributes/uv_mesh.hpp"
#include "../rules/rule_refiner.hpp"
#include "../rules/triangle_cut.hpp"
#include "refined_points.hpp"
#include "repeated_rows.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <utility>

namespace tetrakis {

std::optional<std::string> detail::ignored_creases(const ControlMesh& mesh, const SchemeInfo& scheme,
                                                   const RuleOptions& rules) {
    if (!ignores_creases(scheme, rules)) {
        if (!splits_vertices(scheme, rules)) return std::nullopt;
        const auto semi_sharp = [&](auto id) { return is_semi_sharp(mesh.sharpness(id)); };
        bool any = false;
        for (std::uint32_t e = 0; e < mesh.edge_count(); ++e) any = any || semi_sharp(EdgeId(e));
        for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v) any = any || semi_sharp(VertexId(v));
        if (!any) return std::nullopt;
        return "semi-sharp edges and vertices stay sharp for ever: a crease of " + std::string(scheme.name) +
               " is a boundary on each side";
    }
    for (std::uint32_t e = 0; e < mesh.edge_count(); ++e)
        if (is_sharp(mesh.sharpness(EdgeId(e))) && !mesh.is_boundary(EdgeId(e)))
            return "the creases were ignored: " + std::string(scheme.name) + " has no rule for them" +
                   (!scheme.has_chosen_steps()            ? ""
                    : averaging_steps(scheme, rules) != 2 ? ", unless in two steps"
                                                          : " where its boundary recedes");
    return std::nullopt;
}

bool detail::has_plain_rules(const SchemeInfo& scheme, const RuleOptions& rules) {
    const bool triangles = scheme.pieces == SurfacePieces::quartic_box;
    if ((!triangles && scheme.pieces != SurfacePieces::bicubic) ||
        rules.edge_beside_crease != EdgeBesideCrease::plain || rules.corner_angle != 0 || rules.measure_corner_angles)
        return false;
    if (triangles) return rules.loop_weights == LoopWeights::loop && !rules.hoppe_crease;
    return !rules.catmull_clark_beta && !rules.catmull_clark_gamma;
}

bool detail::has_plain_rules(const ControlMesh& mesh, const SchemeInfo& scheme, const RuleOptions& rules) {
    return !mesh.has_corner_angles() && has_plain_rules(scheme, rules);
}

RuleOptions detail::with_crease_method(const ControlMesh& mesh, const SchemeInfo& scheme, RuleOptions rules) {
    if (mesh.crease_method() == CreaseMethod::chaikin && has_plain_rules(mesh, scheme, rules))
        rules.chaikin_creases = true;
    return rules;
}

void detail::warn_of_ignored_tags(const ControlMesh& mesh, const SchemeInfo& scheme, const RuleOptions& rules,
                                  std::vector<std::string>& warnings) {
    if (mesh.crease_method() == CreaseMethod::chaikin && !rules.chaikin_creases && !scheme.is_linear() &&
        !has_plain_rules(mesh, scheme, rules))
        warnings.push_back(
            "the creases were refined by the uniform rule: Chaikin's is known to plain catmull-clark and loop only");
    if (mesh.has_corner_angles() && !scheme.takes_corner_angles)
        warnings.push_back("the corner angles were ignored: " + std::string(scheme.name) +
                           " has no rule for them, but loop, tuned-loop and catmull-clark have");
    if (auto warning = ignored_creases(mesh, scheme, rules)) warnings.push_back(std::move(*warning));
}

namespace {

/// @throws Error  invalid_input: a width below one, or not `width` values for each control vertex (names the attribute)
void check_attributes(const ControlMesh& mesh, std::span<const VertexAttribute> attributes) {
    for (const VertexAttribute& attribute : attributes) {
        if (attribute.width < 1)
            throw Error(ErrorCode::invalid_input,
                        "attribute \"" + attribute.name + "\" must have at least one number per vertex");
        const std::size_t expected = std::size_t{mesh.vertex_count()} * static_cast<std::size_t>(attribute.width);
        if (attribute.values.size() == expected) {
            const auto bad = std::ranges::find_if_not(attribute.values, [](double x) { return std::isfinite(x); });
            if (bad == attribute.values.end()) continue;
            const auto vertex = (bad - attribute.values.begin()) / attribute.width;
            throw Error(ErrorCode::invalid_input, "attribute \"" + attribute.name + "\" of vertex " +
                                                      std::to_string(vertex) + " is not finite; give a finite number");
        }
        throw Error(ErrorCode::invalid_input,
                    "attribute \"" + attribute.name + "\" has " + std::to_string(attribute.values.size()) +
                        " values, but " + std::to_string(mesh.vertex_count()) + " vertices with " +
                        std::to_string(attribute.width) + " each need " + std::to_string(expected));
    }
}

}  // namespace

void detail::RefinedPoints::make(const ControlMesh& mesh, const RefineOptions& options, PolygonMesh& result) const {
    resize_large(result.positions, count);
    if (options.normals) resize_large(result.normals, count);
    refine(mesh.positions(), result.positions, result.normals);
    // Attributes are refined as points, three numbers at a time; numbers that the last point lacks are zero.
    std::vector<Vec3d> control, refined;
    for (const VertexAttribute& attribute : options.attributes) {
        const auto width = static_cast<std::size_t>(attribute.width);
        VertexAttribute& out = result.attributes.emplace_back(VertexAttribute{attribute.name, attribute.width, {}});
        out.values.resize(count * width);
        refined.resize(count);
        for (std::size_t first = 0; first < width; first += 3) {
            const std::size_t size = std::min<std::size_t>(3, width - first);
            control.assign(mesh.vertex_count(), Vec3d(0));
            for_each_index(mesh.vertex_count(), [&](std::uint32_t v) {
                for (std::size_t k = 0; k < size; ++k)
                    control[v][static_cast<int>(k)] = attribute.values[v * width + first + k];
            });
            refine(control, refined, {});
            for_each_index(count, [&](std::uint32_t v) {
                for (std::size_t k = 0; k < size; ++k)
                    out.values[v * width + first + k] = static_cast<float>(refined[v][static_cast<int>(k)]);
            });
        }
    }
}

void detail::drop_unused_points(PolygonMesh& mesh, RefinedPoints* points) {
    std::vector<std::uint32_t> used = drop_unused_vertices(mesh);
    if (points != nullptr && used.size() != points->count) points->used = std::move(used);
}

namespace {

/// The scheme that refines UVs whose face-varying rule is linear_all.
const SchemeInfo& linear_scheme(const SchemeInfo& scheme) {
    return *find_scheme(scheme.family == MeshFamily::triangles ? "midpoint" : "bilinear");
}

/// Refines the UVs as charts, which have the same faces and half-edges as the mesh. False: the refined charts do not
/// match the refined mesh.
bool refine_uvs(const ControlMesh& tagged, const SchemeInfo& scheme, int levels, const RefineOptions& options,
                const RuleMesh& last, PolygonMesh& result) {
    const std::optional<ControlMesh> untagged = detail::without_ignored_tags(tagged, scheme, options.rules);
    const ControlMesh& mesh = untagged ? *untagged : tagged;
    const bool triples = scheme.refinement == Refinement::sqrt3;
    const bool linear = mesh.face_varying_rule() == FaceVaryingRule::linear_all;
    const bool across =
        scheme.refinement == Refinement::honeycomb || fan_lattice(scheme, options.rules) == FanLattice::dual;
    if (across && linear && levels > 0)
        result.warnings.push_back(
            "the texture coordinates were refined smoothly, not linearly as their tag asks: faces of " +
            std::string(scheme.name) + " do not lie in faces of the control mesh");
    if (levels > 0 && (triples || across || (!linear && detail::extends_charts(scheme, options.rules)))) {
        detail::FollowedUvs followed = detail::follow_uvs(mesh, scheme, levels, options.rules);
        if (followed.face_uvs.size() != static_cast<std::size_t>(last.halfedge_count())) return false;
        detail::drop_unused(followed.face_uvs, followed.uvs);
        result.uvs = std::move(followed.uvs);
        result.face_uvs = std::move(followed.face_uvs);
        // The material and the group of a face are those of the control face that its UVs come from.
        for (const std::uint32_t control : followed.control_face) {
            if (!mesh.data().face_material.empty()) result.face_material.push_back(mesh.data().face_material[control]);
            if (!mesh.data().face_group.empty()) result.face_group.push_back(mesh.data().face_group[control]);
        }
        return true;
    }
    const SchemeInfo& by = linear ? linear_scheme(scheme) : scheme;
    RefineOptions plain{.rules = detail::chart_rules(options.rules), .context = options.context};
    plain.context.progress = nullptr;
    const ControlMesh chart = uv_mesh(mesh, options.rules);
    const RuleRefiner refiner(chart, by, levels, plain);
    if (refiner.last().halfedge_count() != last.halfedge_count()) return false;
    std::vector<Vec3d> points(refiner.vertex_count());
    refiner.refine(chart.positions(), points);
    for (const Vec3d& p : points) result.uvs.emplace_back(p);
    result.face_uvs.resize(result.face_vertices.size());
    for (int h = 0; h < last.halfedge_count(); ++h)
        result.face_uvs[h] = static_cast<std::uint32_t>(refiner.last().origin(h));
    return true;
}

void keep_faces(const std::vector<char>& kept, PolygonMesh& mesh) {
    std::vector<std::uint32_t> offsets{0}, faces, corners;
    for (std::uint32_t f = 0; f < mesh.face_count(); ++f) {
        if (kept[f] == 0) continue;
        faces.push_back(f);
        for (std::uint32_t c = mesh.face_offsets[f]; c < mesh.face_offsets[f + 1]; ++c) corners.push_back(c);
        offsets.push_back(static_cast<std::uint32_t>(corners.size()));
    }
    mesh.face_offsets = std::move(offsets);
    for (auto* of_corners : {&mesh.face_vertices, &mesh.face_uvs}) detail::pick(corners, *of_corners);
    for (auto* of_faces : {&mesh.face_material, &mesh.face_group}) detail::pick(faces, *of_faces);
}

/// Adds materials, groups and warnings; removes faces in holes or at missing vertices. True: all faces stay.
/// @param control_face  gives the control face that a face belongs to
/// @param missing       whether a vertex is missing; empty: no vertex is
template <class ControlFace>
bool keep_surface(const ControlMesh& mesh, const SchemeInfo& scheme, const RuleOptions& rules,
                  const ControlFace& control_face, const std::function<bool(std::uint32_t)>& missing,
                  PolygonMesh& result) {
    const ControlMeshData& data = mesh.data();
    bool holes = false;
    for (std::uint32_t f = 0; f < mesh.face_count(); ++f) holes = holes || mesh.is_hole(FaceId(f));
    const bool all_kept = !holes && !missing;
    std::vector<char> kept(all_kept ? 0 : result.face_count(), 1);
    for (std::uint32_t f = 0; f < kept.size(); ++f) {
        for (std::uint32_t c = result.face_offsets[f]; missing && c < result.face_offsets[f + 1]; ++c)
            if (missing(result.face_vertices[c])) kept[f] = 0;
        if (kept[f] != 0 && mesh.is_hole(FaceId(control_face(f)))) kept[f] = 0;
    }
    // With UVs by follow_uvs(), materials and groups are there already.
    const auto per_face = [&](const std::vector<std::uint32_t>& from, std::vector<std::uint32_t>& to) {
        if (from.empty() || !to.empty()) return;
        to.resize(result.face_count());
        for_each_index(result.face_count(), [&](std::uint32_t f) {
            if (all_kept || kept[f] != 0) to[f] = from[control_face(f)];
        });
    };
    per_face(data.face_material, result.face_material);
    per_face(data.face_group, result.face_group);
    result.materials = data.materials;
    result.groups = data.groups;
    detail::warn_of_ignored_tags(mesh, scheme, rules, result.warnings);
    if (all_kept) return true;
    keep_faces(kept, result);
    if (result.face_count() == 0)
        result.warnings.push_back("no face is left: all are holes, or touch the boundary under boundary rule none");
    if (!result.uvs.empty()) detail::drop_unused(result.face_uvs, result.uvs);
    return false;
}

/// The results that refine() needs, and the memory that the refined mesh takes.
detail::RepeatedRows::Demand demand_of(const ControlMesh& mesh, const SchemeInfo& scheme,
                                       const RefineOptions& options) {
    detail::RepeatedRows::Demand demand;
    demand.limit = options.limit && !scheme.interpolating;
    demand.normals = options.normals;
    if (demand.limit) demand.point_bytes += sizeof(Vec3d);  // the last level's points, too
    if (demand.normals) {
        // Numbers of those that faces use are looked up in a copy.
        demand.point_bytes += sizeof(Vec3d) + 2 * sizeof(std::uint64_t);
        demand.corner_bytes += sizeof(std::uint32_t);
    }
    if (!mesh.data().face_material.empty()) demand.face_bytes += sizeof(std::uint32_t);
    if (!mesh.data().face_group.empty()) demand.face_bytes += sizeof(std::uint32_t);
    for (const VertexAttribute& attribute : options.attributes)
        demand.point_bytes += sizeof(float) * static_cast<std::uint64_t>(std::max(attribute.width, 0));
    if (!options.attributes.empty()) demand.point_bytes += sizeof(Vec3d);  // three numbers at a time
    if (mesh.has_uvs()) {
        // Charts are refined as meshes, and their points then made into texture coordinates.
        demand.point_bytes += 2 * (sizeof(Vec3d) + sizeof(Vec2d));
        demand.corner_bytes += sizeof(std::uint32_t);
    }
    // Faces in holes, or lost to a boundary that recedes, are removed while making a copy.
    if (!mesh.data().holes.empty() || mesh.boundary_rule() == BoundaryRule::none ||
        (boundary_recedes(scheme, options.rules) && mesh.has_boundary())) {
        demand.point_bytes *= 2;
        demand.corner_bytes *= 2;
    }
    return demand;
}

/// NaN, so that all points that are computed from a missing one are NaN, too.
constexpr Vec3d k_missing_point(std::numeric_limits<double>::quiet_NaN());

/// The mesh with one more ring of quads along its boundaries, whose outer points are missing. A boundary that recedes
/// (AveragingBoundary::recede) leaves the points that do not depend on these. Vertices and faces keep their numbers,
/// and new ones follow them; tags, UVs and data of faces are left out.
ControlMesh with_missing_ring(const ControlMesh& mesh) {
    ControlMeshData data;
    data.source = mesh.data().source;
    data.positions = mesh.data().positions;
    data.face_offsets = mesh.data().face_offsets;
    data.face_vertices = mesh.data().face_vertices;
    std::vector<std::uint32_t> outer(mesh.vertex_count(), 0);  // 0: none
    const auto beyond = [&](VertexId v) {
        std::uint32_t& of = outer[v.value];
        if (of == 0) {
            of = static_cast<std::uint32_t>(data.positions.size());
            data.positions.emplace_back(0);  // k_missing_point later: a mesh must be finite
        }
        return of;
    };
    for (std::uint32_t i = 0; i < mesh.halfedge_count(); ++i) {
        const HalfedgeId h(i);
        if (mesh.twin(h).valid()) continue;
        const VertexId u = mesh.origin(h), v = mesh.target(h);
        for (const std::uint32_t corner : {v.value, u.value, beyond(u), beyond(v)})
            data.face_vertices.push_back(corner);
        data.face_offsets.push_back(static_cast<std::uint32_t>(data.face_vertices.size()));
    }
    return ControlMesh::build(std::move(data));
}

/// Refines by stencil rows that repeat from level to level (RepeatedRows), the fast way. Empty if that is not possible
/// or not faster; `first_levels` then keeps the levels that the rules have made.
std::optional<PolygonMesh> refine_repeated(const ControlMesh& mesh, const SchemeInfo& scheme, int levels,
                                           const RefineOptions& options,
                                           std::unique_ptr<detail::RuleLevels>& first_levels,
                                           detail::RefinedPoints* keep) {
    if (scheme.refinement == Refinement::honeycomb) return std::nullopt;
    const bool recedes = boundary_recedes(scheme, options.rules) && mesh.has_boundary();
    const std::optional<ControlMesh> wide = recedes ? std::optional(with_missing_ring(mesh)) : std::nullopt;
    const ControlMesh& surface = wide ? *wide : mesh;
    const detail::RepeatedRows::Demand demand = demand_of(mesh, scheme, options);
    // Charts report no fraction of their own; the callback can cancel them.
    RunContext quiet = options.context;
    if (options.context.progress)
        quiet.progress = [&](std::string_view stage, double) { return options.context.progress(stage, 0); };
    // Charts with the mesh's faces in the same order are refined in the same way.
    std::optional<ControlMesh> charts;
    std::unique_ptr<const detail::RepeatedRows> chart_rows;
    if (mesh.has_uvs()) {
        const bool linear = mesh.face_varying_rule() == FaceVaryingRule::linear_all;
        if (recedes || fan_lattice(scheme, options.rules) == FanLattice::dual ||
            (linear ? scheme.refinement == Refinement::sqrt3 : detail::extends_charts(scheme, options.rules)))
            return std::nullopt;
        const SchemeInfo& by = linear ? linear_scheme(scheme) : scheme;
        const std::optional<ControlMesh> untagged = detail::without_ignored_tags(mesh, scheme, options.rules);
        charts.emplace(uv_mesh(untagged ? *untagged : mesh, options.rules));
        const RuleOptions of_charts = detail::chart_rules(options.rules);
        auto chart_levels = std::make_unique<detail::RuleLevels>(*charts, by, of_charts, 0);
        detail::RepeatedRows::Demand of_points = demand;
        of_points.limit = of_points.normals = false;
        chart_rows = detail::RepeatedRows::make(*charts, by, levels, of_charts, chart_levels, of_points, quiet);
        if (!chart_rows) return std::nullopt;
    }
    RuleOptions rules = options.rules;
    if (recedes) rules.averaging_boundary = AveragingBoundary::replicate;  // the missing ring replaces the boundary
    // Smoothing comes before the missing ring is added.
    std::shared_ptr<const detail::RuleLevels> smoothed;
    if (recedes && options.smoothing > 0)
        smoothed = std::make_shared<const detail::RuleLevels>(mesh, scheme, options.rules, options.smoothing);
    std::unique_ptr<detail::RuleLevels> wide_levels;
    if (recedes) wide_levels = std::make_unique<detail::RuleLevels>(surface, scheme, rules, 0);
    const std::shared_ptr<const detail::RepeatedRows> rows = detail::RepeatedRows::make(
        surface, scheme, levels, rules, recedes ? wide_levels : first_levels, demand, options.context);
    if (!rows) return std::nullopt;
    PolygonMesh result;
    detail::RefinedPoints made{rows->point_count(),
                               [rows, smoothed, context = options.context](auto control, auto positions, auto normals) {
                                   if (control.size() == rows->control_count())
                                       return rows->refine(control, positions, normals, context);
                                   std::vector<Vec3d> all(control.begin(), control.end());
                                   if (smoothed) smoothed->net(control, all);
                                   all.resize(rows->control_count(), k_missing_point);
                                   rows->refine(all, positions, normals, context);
                               }};
    made.make(mesh, options, result);
    detail::RepeatedRows::Faces faces = rows->faces(options.context);
    if (charts) {
        std::vector<Vec3d> points(chart_rows->point_count());
        chart_rows->refine(charts->positions(), points, {}, quiet);
        result.uvs.assign(points.begin(), points.end());
        result.face_uvs = chart_rows->faces(quiet).vertices;
    }
    result.face_offsets = std::move(faces.offsets);
    result.face_vertices = std::move(faces.vertices);
    std::function<bool(std::uint32_t)> missing;
    if (recedes)
        missing = [&](std::uint32_t v) {
            return std::isnan(result.positions[v].x) || (!result.normals.empty() && std::isnan(result.normals[v].x));
        };
    const bool all_kept = keep_surface(
        mesh, scheme, options.rules, [&](std::uint32_t f) { return faces.control_face(f); }, missing, result);
    if (recedes && result.face_count() == 0) return std::nullopt;
    if (keep != nullptr) *keep = std::move(made);
    if (!all_kept || !rows->uses_all_points()) detail::drop_unused_points(result, keep);
    return result;
}

void check_rounds(int levels, const RefineOptions& options) {
    if (levels < 0)
        throw Error(ErrorCode::invalid_input, "the number of levels must not be negative; 0 is the control mesh");
    if (options.smoothing < 0)
        throw Error(ErrorCode::invalid_input, "the number of smoothing rounds must not be negative");
}

PolygonMesh refine_general(const ControlMesh& mesh, const SchemeInfo& scheme, int levels, RefineOptions options,
                           StencilTable* stencils, detail::RefinedPoints* keep) {
    options.normals = options.normals && !scheme.is_linear();
    options.rules = detail::with_crease_method(mesh, scheme, options.rules);
    check_attributes(mesh, options.attributes);
    check_rounds(levels, options);
    std::unique_ptr<detail::RuleLevels> first_levels;
    if (stencils == nullptr) {
        first_levels = std::make_unique<detail::RuleLevels>(mesh, scheme, options.rules, options.smoothing);
        if (std::optional<PolygonMesh> result = refine_repeated(mesh, scheme, levels, options, first_levels, keep))
            return std::move(*result);
    }
    const auto by_rules = std::make_shared<const RuleRefiner>(mesh, scheme, levels, options, std::move(first_levels));
    const RuleRefiner& refiner = *by_rules;
    const RuleMesh& last = refiner.last();
    PolygonMesh result;
    detail::RefinedPoints made{refiner.vertex_count(), [by_rules](auto control, auto positions, auto normals) {
                                   by_rules->refine(control, positions, normals);
                               }};
    made.make(mesh, options, result);
    if (keep != nullptr) *keep = std::move(made);
    result.face_offsets.resize(refiner.face_count() + std::size_t{1});
    detail::resize_large(result.face_vertices, last.halfedge_count());
    for (int f = 0; f < last.face_count(); ++f)
        result.face_offsets[f + 1] = result.face_offsets[f] + static_cast<std::uint32_t>(last.face_size(f));
    for (int h = 0; h < last.halfedge_count(); ++h)
        result.face_vertices[h] = static_cast<std::uint32_t>(last.origin(h));
    if (mesh.has_uvs() && !refine_uvs(mesh, scheme, levels, options, last, result))
        result.warnings.push_back("the texture coordinates were dropped: " + std::string(scheme.name) +
                                  " changes the charts otherwise than the mesh");
    std::function<bool(std::uint32_t)> missing;
    if (const std::span<const int> beyond = refiner.vertices_beyond(); !beyond.empty())
        missing = [beyond](std::uint32_t v) { return std::ranges::binary_search(beyond, static_cast<int>(v)); };
    keep_surface(
        mesh, scheme, options.rules, [&](std::uint32_t f) { return refiner.control_face(f); }, missing, result);
    if (!refiner.vertices_beyond().empty() && result.face_count() == 0)
        throw Error(ErrorCode::unsupported,
                    "nothing of the limit surface is left: its boundary recedes by more than the mesh has",
                    mesh.data().source);
    if (stencils != nullptr) {
        std::vector<char> used(result.positions.size(), 0);
        for (const std::uint32_t v : result.face_vertices) used[v] = 1;
        *stencils = refiner.stencils(used);
    }
    detail::drop_unused_points(result, keep);
    return result;
}

PolygonMesh refine_triangulated(const ControlMesh& mesh, const SchemeInfo& scheme, int levels, RefineOptions options) {
    check_attributes(mesh, options.attributes);
    const ControlMesh cut = triangulate(mesh, options.context);
    // triangulate() cuts a face without ears into a fan around its mean, a new vertex.
    std::vector<VertexAttribute> attributes;
    for (const VertexAttribute& attribute : options.attributes) {
        const auto width = static_cast<std::size_t>(attribute.width);
        std::vector<float>& values = attributes.emplace_back(attribute).values;
        for (std::uint32_t v = mesh.vertex_count(); v < cut.vertex_count(); ++v) {
            std::vector<double> sum(width, 0.0);
            double count = 0;
            const HalfedgeId first = cut.vertex_halfedge(VertexId(v));
            HalfedgeId h = first;
            do {
                const std::size_t from = width * cut.target(h).value;
                for (std::size_t i = 0; i < width; ++i) sum[i] += static_cast<double>(values[from + i]);
                ++count;
                h = cut.ccw_outgoing(h);
            } while (h != first);
            for (const double s : sum) values.push_back(static_cast<float>(s / count));
        }
    }
    options.attributes = attributes;
    PolygonMesh result = detail::refine_with_points(cut, scheme, levels, options, nullptr);
    std::vector<std::string> warnings;
    for (const std::string& warning : cut.warnings())
        if (std::ranges::count(mesh.warnings(), warning) == 0) warnings.push_back(warning);
    result.warnings.insert(result.warnings.begin(), warnings.begin(), warnings.end());
    return result;
}

}  // namespace

const SchemeInfo& scheme_named(std::string_view text) {
    if (const SchemeInfo* scheme = find_scheme(text)) return *scheme;
    std::string names;
    for (const SchemeInfo& s : scheme_table()) names += (names.empty() ? "" : ", ") + std::string(s.name);
    throw Error(ErrorCode::invalid_input, "no scheme is called " + std::string(text) + "; did you mean " +
                                              std::string(nearest_scheme_name(text)) + "? There are: " + names);
}

PolygonMesh detail::refine_with_points(const ControlMesh& mesh, const SchemeInfo& scheme, int levels,
                                       const RefineOptions& options, RefinedPoints* points) {
    return with_threads(options.context,
                        [&] { return refine_general(mesh, scheme, levels, options, nullptr, points); });
}

PolygonMesh refine(const ControlMesh& mesh, const SchemeInfo& scheme, int levels, const RefineOptions& options) {
    if (scheme.family == MeshFamily::triangles && !mesh.all_triangles())
        return refine_triangulated(mesh, scheme, levels, options);
    return detail::refine_with_points(mesh, scheme, levels, options, nullptr);
}

RefinedStencils refine_stencils(const ControlMesh& mesh, const SchemeInfo& scheme, int levels,
                                const RefineOptions& options) {
    return with_threads(options.context, [&] {
        RefinedStencils result;
        result.mesh = refine_general(mesh, scheme, levels, options, &result.stencils, nullptr);
        return result;
    });
}

PolygonMesh refine(const ControlMesh& mesh, std::string_view scheme, int levels, const RefineOptions& options) {
    return refine(mesh, scheme_named(scheme), levels, options);
}

}  // namespace tetrakis
