#include "../../hier/base/error.hpp"
#include "../uniform/refine.hpp"
#include "hierarchy.hpp"
#include "hierarchy_families.hpp"
#include "row_points.hpp"
#include "sqrt3_points.hpp"
#include "vertex_levels.hpp"

#include <string>
#include <utility>

namespace tetrakis {

namespace {

/// A scheme's levels with limit positions from elsewhere.
class OtherLimits final : public LevelSource {
  public:
    OtherLimits(std::shared_ptr<const LevelSource> levels, std::shared_ptr<const PositionSource> limits)
        : levels_(std::move(levels)), limits_(std::move(limits)) {}
    int first_level(const Site& site) const override { return levels_->first_level(site); }
    int max_level() const override { return levels_->max_level(); }
    void positions(std::span<const Site> sites, int level, std::span<Vec3d> out) const override {
        levels_->positions(sites, level, out);
    }
    void frames(std::span<const Site> sites, int level, std::span<LimitPoint> out) const override {
        levels_->frames(sites, level, out);
    }
    void limit_positions(std::span<const Site> sites, std::span<Vec3d> out) const override {
        limits_->positions(sites, out);
    }
    void limits(std::span<const Site> sites, std::span<LimitPoint> out) const override { levels_->limits(sites, out); }

  private:
    std::shared_ptr<const LevelSource> levels_;
    std::shared_ptr<const PositionSource> limits_;
};

/// The levels with limit positions as the options ask for them.
std::shared_ptr<const LevelSource> with_limits(std::unique_ptr<LevelSource> levels, const ControlMesh& mesh,
                                               const SchemeInfo& scheme, const HierarchyOptions& options,
                                               const VertexRoots* roots = nullptr) {
    if (options.limit_positions) return std::make_shared<OtherLimits>(std::move(levels), options.limit_positions);
    if (!options.repeated_rows) return levels;
    return detail::row_points(mesh, scheme, options.rules, std::move(levels), roots, options.context);
}

}  // namespace

Hierarchy make_hierarchy(const ControlMesh& mesh, const SchemeInfo& scheme, const HierarchyOptions& options) {
    if (averaging_steps(scheme, options.rules) < 0)
        throw Error(ErrorCode::invalid_input, "the number of averaging steps must not be negative");
    if (scheme.family != MeshFamily::hexagons && fan_lattice(scheme, options.rules) == FanLattice::dual) {
        const auto points = std::make_shared<const PartialLevels>(mesh, scheme, options.rules);
        VertexRoots roots = points->vertex_roots();
        std::shared_ptr<const LevelSource> of_cells = with_limits(vertex_levels(points), mesh, scheme, options, &roots);
        return Hierarchy(vertex_family(mesh, std::move(of_cells), std::move(roots)), scheme, options.rules);
    }
    const bool triangles = scheme.family == MeshFamily::triangles;
    std::unique_ptr<LevelSource> levels;
    if (boundary_recedes(scheme, options.rules) && mesh.has_boundary())
        throw Error(ErrorCode::unsupported,
                    "a boundary that recedes leaves sites without vertex; hierarchies need one that is replicated");
    if (scheme.refinement == Refinement::sqrt3) {
        if (!mesh.all_triangles())
            throw Error(ErrorCode::invalid_input, "sqrt3 needs a triangle mesh; triangulate() makes one");
        levels = sqrt3_levels(mesh, sqrt3_tree_levels(mesh));
        if (options.limit_positions) levels = std::make_unique<OtherLimits>(std::move(levels), options.limit_positions);
        return Hierarchy(sqrt3_family(mesh, std::move(levels)), scheme, options.rules);
    }
    if (scheme.refinement == Refinement::honeycomb)
        throw Error(ErrorCode::unsupported, "there is no hierarchy for " + std::string(scheme.name) +
                                                ": its vertices are no sites of corner cells or triangles");
    const bool linear = scheme.name == "bilinear" || scheme.name == "midpoint";
    if (linear)
        levels = linear_levels(mesh, triangles);
    else if (detail::has_plain_rules(mesh, scheme, options.rules))
        levels = closure_levels(mesh, triangles ? SchemeKind::loop : SchemeKind::catmull_clark);
    else
        levels = rule_levels(mesh, scheme, options.rules);
    std::shared_ptr<const LevelSource> source;
    if (linear && !options.limit_positions)
        source = std::move(levels);
    else
        source = with_limits(std::move(levels), mesh, scheme, options);
    return Hierarchy(triangles ? triangle_family(mesh, std::move(source)) : bisection_family(mesh, std::move(source)),
                     scheme, options.rules);
}

Hierarchy make_hierarchy(const ControlMesh& mesh, std::string_view scheme, const HierarchyOptions& options) {
    return make_hierarchy(mesh, scheme_named(scheme), options);
}

}  // namespace tetrakis
