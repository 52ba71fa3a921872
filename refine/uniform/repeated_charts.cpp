#include "repeated_charts.hpp"

#include "../attributes/missing_ring.hpp"
#include "../attributes/uv_mesh.hpp"
#include "chart_cells.hpp"

#include <numeric>
#include <span>
#include <utility>
#include <vector>

namespace tetrakis::detail {

std::optional<RepeatedCharts> RepeatedCharts::make(const ControlMesh& mesh, const ControlMesh& surface,
                                                   const SchemeInfo& scheme, int levels, const RuleOptions& rules,
                                                   const RepeatedRows::Demand& demand, const RunContext& context) {
    const bool linear = mesh.face_varying_rule() == FaceVaryingRule::linear_all, recedes = &surface != &mesh;
    RepeatedCharts all;
    all.surface_ = &surface;
    all.scheme_ = &scheme;
    all.rules_ = recedes ? inside_missing_ring(rules) : rules;
    all.dual_ = fan_lattice(scheme, rules) == FanLattice::dual;
    all.extended_ = all.dual_ || (!linear && extends_charts(scheme, rules));
    const bool by_lines = linear && !all.dual_;
    // Triangles of charts are in another order than the mesh's; linear charts have no end where the surface has.
    if (by_lines && (scheme.refinement == Refinement::sqrt3 || recedes)) return std::nullopt;
    const SchemeInfo& by =
        by_lines ? *find_scheme(scheme.family == MeshFamily::triangles ? "midpoint" : "bilinear") : scheme;
    if (all.extended_) all.extension_ = extend_over_seams(mesh, rule_mesh(mesh), scheme, rules);
    ControlMesh charts = all.extended_ ? chart_mesh(all.extension_) : uv_mesh(mesh, rules);
    all.own_ = mesh.halfedge_count();
    all.known_ = charts.vertex_count();
    all.charts_ = std::make_unique<const ControlMesh>(recedes ? with_missing_ring(charts) : std::move(charts));
    const RuleOptions of_charts = chart_rules(all.rules_);
    auto chart_levels = std::make_unique<RuleLevels>(*all.charts_, by, of_charts, 0);
    RepeatedRows::Demand plain = demand;
    plain.limit = plain.normals = false;
    if (all.dual_) plain.root_level = RepeatedRows::first_whole_level(rule_mesh(surface), scheme, rules);
    all.rows_ = RepeatedRows::make(*all.charts_, by, levels, of_charts, chart_levels, plain, context);
    if (!all.rows_) return std::nullopt;
    return all;
}

/// What the surface's corners are in the charts; missing rings go along the same edges of both.
ChartCorners RepeatedCharts::corners() {
    std::vector<int> partner(surface_->halfedge_count());
    std::iota(partner.begin(), partner.end(), 0);
    if (own_ < partner.size()) {
        extension_.mesh = rule_mesh(*charts_);
        extension_.uvs.resize(charts_->vertex_count());
    }
    for (std::size_t h = own_; h < partner.size(); h += 4) {
        const HalfedgeId inside = surface_->twin(HalfedgeId(static_cast<std::uint32_t>(h)));
        std::iota(&partner[h], &partner[h] + 4, static_cast<int>(charts_->twin(inside).value));
    }
    return chart_corners(rule_mesh(*surface_), std::move(extension_), std::move(partner), *scheme_, rows_->root_level(),
                         rules_);
}

std::optional<FollowedUvs> RepeatedCharts::refine(const RepeatedRows& rows, const RepeatedRows::Faces& faces,
                                                  const RunContext& context) {
    if (rows.root_level() != rows_->root_level()) return std::nullopt;
    const std::span<const Vec3d> known = charts_->positions().first(known_);
    std::vector<Vec3d> control(known.begin(), known.end()), points(rows_->point_count());
    control.resize(charts_->vertex_count(), k_missing_point);
    rows_->refine(control, points, {}, context);
    FollowedUvs result;
    result.uvs.assign(points.begin(), points.end());
    if (dual_) {
        auto cells = cell_uvs(rows.net(), rows_->net(), corners(), rows.segments(), faces, result.uvs);
        if (!cells) return std::nullopt;
        result.face_uvs = std::move(cells->face_uvs);
        result.control_face = std::move(cells->control_face);
    } else {
        // The mesh's faces are the first ones of both; those of a missing ring are none that stay.
        result.face_uvs = rows_->faces(context).vertices;
        result.face_uvs.resize(faces.vertices.size());
    }
    return result;
}

}  // namespace tetrakis::detail
