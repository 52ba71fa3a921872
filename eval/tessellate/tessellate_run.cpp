#include "tessellate_run.hpp"

#include "../../hier/base/memory.hpp"
#include "../../hier/base/parallel.hpp"
#include "../../hier/mesh/mesh_check.hpp"
#include "../../hier/trees/sqrt3_lattice.hpp"
#include "../../refine/attributes/uv_mesh.hpp"
#include "../../refine/rules/rule_limit.hpp"
#include "../../refine/uniform/refine.hpp"
#include "../bounds/dual_bound.hpp"
#include "../distance/surface_family.hpp"
#include "../estimate/linear_bound.hpp"
#include "../estimate/mask_norm_bound.hpp"
#include "../io/mesh_writer.hpp"
#include "../surface/local_frame.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <string>

namespace tetrakis {

namespace detail {

void TessellationRun::add_uvs(FaceUvs from) {
    TriangleMesh& mesh = result_.mesh;
    mesh.uvs = std::move(from.uvs);
    mesh.triangle_uvs.resize(mesh.triangles.size());
    for (std::size_t c = 0; c < from.face_uvs.size(); ++c) mesh.triangle_uvs[c / 3][c % 3] = from.face_uvs[c];
}

/// Materials and groups of the control faces that the triangles come from.
void TessellationRun::add_face_attributes() {
    const ControlMeshData& data = mesh_.data();
    const auto carry = [&](const std::vector<std::uint32_t>& from, std::vector<std::uint32_t>& to) {
        if (from.empty()) return;
        to.resize(result_.triangle_face.size());
        for (std::size_t t = 0; t < to.size(); ++t) to[t] = from[result_.triangle_face[t]];
    };
    carry(data.face_material, result_.mesh.triangle_material);
    carry(data.face_group, result_.mesh.triangle_group);
    if (!data.face_material.empty()) result_.mesh.materials = data.materials;
    if (!data.face_group.empty()) result_.mesh.groups = data.groups;
}

/// The tolerance in the unit of the model; infinite where none is given.
/// @throws Error  invalid_input: one that rounding hides, or a mesh too small to calculate with
double TessellationRun::tolerance_length() const {
    const Box3d box = mesh_.bounding_box();
    double tolerance = options_.tolerance.value_or(std::numeric_limits<double>::infinity());
    if (options_.tolerance && !options_.tolerance_is_absolute) tolerance *= box.diagonal();
    // A tolerance below the rounding of the coordinates can never be reached.
    constexpr double k_least_tolerance = 1e-14;
    const double largest = std::max(glm::length(box.lower), glm::length(box.upper));
    if (options_.tolerance && !(tolerance > k_least_tolerance * largest))
        throw Error(
            ErrorCode::invalid_input,
            box.diagonal() > 0
                ? "the tolerance is below the rounding of coordinates of this size; use a larger one, or move the "
                  "model to the origin"
                : "the control mesh has no extent, so that a relative tolerance means nothing; give an absolute "
                  "one");
    // Fourth powers of lengths must not underflow to zero.
    if (box.diagonal() > 0 && box.diagonal() * k_max_coordinate < 1)
        throw Error(ErrorCode::invalid_input,
                    fmt::format("the control mesh is only {:.2g} across, too small to calculate with; scale it up",
                                box.diagonal()));
    return tolerance;
}

/// The largest error that the estimator accepts. A certified error includes the rounding of written floats, so the
/// certified estimator gets the rest of the tolerance. Warns if rounding leaves nothing of it. Without a tolerance:
/// the rounding of points.
/// @throws Error  invalid_input: the certified estimator with a tolerance below twice surface_rounding()
double TessellationRun::aim_beside_rounding() {
    // Every bound adds the rounding of points; the factor 2 leaves half of the tolerance for the surface.
    const double least = 2 * surface_rounding(mesh_, averaging_steps(options_.scheme.info(), options_.rules));
    if (!options_.tolerance) return least;  // below it, more triangles would not bring the mesh closer
    if (certified() && !(tolerance_ > least))
        throw Error(
            ErrorCode::invalid_input,
            fmt::format("a tolerance of {:.2g} cannot be certified: with coordinates as large as these, rounding "
                        "rules out tolerances up to {:.2g}; use a larger one, the measured estimator, or a model "
                        "near the origin",
                        tolerance_, least),
            mesh_.data().source);
    if (!options_.floats_written) return tolerance_;
    const double rounding = glb_rounding_bound_within(mesh_.bounding_box());
    constexpr double k_below = 1 - 1e-15;  // the sum of error and rounding is rounded, too
    if (!certified() && rounding < tolerance_) return tolerance_;
    if (const double left = tolerance_ * k_below - rounding; certified() && left > least) return left;
    result_.warnings.push_back(
        fmt::format("the floats that are written may be off by {:.2g}, which leaves nothing of the tolerance of "
                    "{:.2g}; write doubles (.obj or .ply) or use a larger tolerance",
                    rounding, tolerance_));
    return tolerance_;
}

/// Upper bound on the error that rounding the result's vertices to float adds; 0 if no floats are written.
double TessellationRun::written_rounding() const {
    return options_.floats_written ? glb_rounding_bound(bounding_box(result_.mesh.positions)) : 0;
}

/// Whether the result, rounding included, is within the tolerance, as far as it was measured and certified. A measured
/// distance from the mesh to the surface may be too large, so a certified bound replaces it.
bool TessellationRun::tolerance_reached() const {
    if (!options_.tolerance) return true;
    if (left_over() || written_rounding() > tolerance_) return false;
    if (certified() && *result_.certified_error > tolerance_) return false;
    const auto& measured = result_.measured_error;
    return !measured || (certified() ? measured->forward : measured->hausdorff) <= tolerance_;
}

void TessellationRun::split_creases(const SideNormals& side) {
    if (result_.mesh.normals.empty()) return;
    const bool creases = !ignores_creases(options_.scheme.info(), options_.rules);
    split_normals(result_.mesh, result_.triangle_face, creases ? &mesh_ : nullptr, options_.crease_degrees, side);
}

void TessellationRun::check_coarsest() const {
    const std::size_t triangles = result_.mesh.triangles.size();
    if (options_.max_triangles == 0 || triangles <= options_.max_triangles) return;
    throw Error(
        ErrorCode::unsupported,
        fmt::format("the coarsest mesh of this surface has {0} triangles, more than the {1} allowed; allow at "
                    "least {0}{2}",
                    triangles, options_.max_triangles, options_.min_level > 0 ? ", or lower the minimum level" : ""));
}

void TessellationRun::warn_of_fine_control_mesh() {
    const std::size_t triangles = result_.mesh.triangles.size();
    if (!options_.tolerance || options_.max_triangles != 0 || options_.max_level == 0 || !result_.tolerance_reached ||
        triangles == 0)
        return;
    std::size_t own = 0;
    for (std::uint32_t f = 0; f < mesh_.face_count(); ++f)
        if (!mesh_.is_hole(FaceId(f))) own += mesh_.face_size(FaceId(f)) - std::size_t{2};
    constexpr std::size_t k_dense = 1000;  // no warning for small meshes, which often suffice
    constexpr double k_hardly = 1.01;      // some faces may need more
    if (own < k_dense || static_cast<double>(triangles) > k_hardly * static_cast<double>(own)) return;
    result_.warnings.push_back(
        fmt::format("the control mesh's own faces are within the tolerance already: {} was refined, and the result has "
                    "their connectivity; a coarser control mesh would do, or a smaller tolerance gives more",
                    triangles > own ? "next to nothing" : "nothing"));
}

Tessellation TessellationRun::run() {
    // Most rounds in which leaves above the tolerance are split and the mesh is measured again.
    constexpr int k_repairs = 8;
    Stopwatch watch;
    result_.tolerance_absolute = tolerance_length();
    tolerance_ = options_.tolerance ? result_.tolerance_absolute : 0.0;
    warn_of_ignored_tags(mesh_, options_.scheme.info(), options_.rules, result_.warnings);
    aim_ = aim_beside_rounding();
    if (!certified()) aim_ *= sampled_aim_;
    off_above_ = certified() ? tolerance_ : tolerance_ * sampled_aim_;
    prepare();
    result_.seconds.build = watch.lap();
    refine();
    export_mesh();
    check_coarsest();
    result_.seconds.estimate = estimate_seconds_;
    result_.seconds.refine = watch.lap() - estimate_seconds_;
    result_.peak_memory_before_measure_bytes = peak_memory_bytes();
    if (options_.measure) {
        for (int round = 0;; ++round) {
            measure();
            result_.seconds.measure += watch.lap();
            if (!options_.tolerance || result_.measured_error->hausdorff <= off_above_ || certified() ||
                !may_repair() || round == k_repairs || !repair(round))
                break;
            export_mesh();
            result_.seconds.refine += watch.lap();
        }
    }
    certify();
    if (result_.certified_error) *result_.certified_error += written_rounding();
    result_.seconds.estimate += watch.lap();
    result_.tolerance_reached = tolerance_reached();
    if (result_.mesh.triangles.empty())
        result_.warnings.emplace_back(
            "no face of the control mesh is part of the surface: all are holes, or touch the boundary under boundary "
            "rule 0 (none); the mesh is empty");
    add_attributes();
    add_face_attributes();
    return std::move(result_);
}

}  // namespace detail

namespace {

void check_scheme(const TessellateOptions& options) {
    const SchemeInfo& scheme = options.scheme.info();
    const std::string name(scheme.name);
    const SchemeSupport support = scheme_support(options.scheme, options.rules);
    if (options.target || options.displacement)
        throw Error(ErrorCode::unsupported,
                    std::string(options.target ? "a target" : "a displacement") +
                        " needs exact points and normals all over the surface, which " + name +
                        " has at its vertices only; use catmull-clark or loop with their plain rules "
                        "and without corner angles");
    if (options.estimator != EstimatorKind::certified || support.certified) return;
    std::string others;
    for (const SchemeInfo& other : scheme_table())
        if (other.has_chosen_steps())
            others += ", " + std::string(other.name) + " in an even number of steps from 2 on";
        else if (scheme_support(other).certified)
            others += ", " + std::string(other.name);
    throw Error(ErrorCode::unsupported,
                "there is no certified bound for " + name +
                    ": its limit is known at points alone; use the measured estimator, or one of " + others.substr(2));
}

}  // namespace

SchemeSupport scheme_support(const SchemeChoice& scheme, const RuleOptions& rules) {
    SchemeSupport support;
    const SchemeInfo& info = scheme.info();
    support.adaptive = info.refinement != Refinement::honeycomb;
    support.patches = detail::has_plain_rules(info, rules);
    support.certified =
        support.patches || info.is_linear() || has_mask_norms(info, rules) || detail::DualBound::has(info);
    return support;
}

SchemeSupport scheme_support(const ControlMesh& mesh, const SchemeChoice& scheme, const RuleOptions& rules) {
    SchemeSupport support = scheme_support(scheme, rules);
    support.patches = support.patches && detail::has_plain_rules(mesh, scheme.info(), rules);
    if (!support.patches && has_mask_norms(scheme.info(), rules))
        support.certified = MaskNormBound<QuadFamily>::has(scheme.info(), rules, mesh);
    return support;
}

Tessellation detail::tessellate_by_limits(const ControlMesh& mesh, const TessellateOptions& options,
                                          const RunContext& context) {
    check_scheme(options);
    try {
        if (!scheme_support(options.scheme, options.rules).adaptive)
            return tessellate_by_levels(mesh, options, context);
        const bool dual = fan_lattice(options.scheme.info(), options.rules) == FanLattice::dual;
        if (dual) return tessellate_dual(mesh, options, context);
        if (boundary_recedes(options.scheme.info(), options.rules) && mesh.has_boundary())
            return tessellate_by_levels(mesh, options, context,
                                        "a boundary that recedes leaves sites without vertex; replicate it");
        return tessellate_on_lattice(mesh, options, context);
    } catch (const detail::NoLimit& none) {
        throw Error(ErrorCode::unsupported,
                    none.reason() +
                        "; change the mesh there (its tags, or how many faces meet), or tessellate by another scheme",
                    none.file());
    }
}

}  // namespace tetrakis
