#include "../../hier/base/error.hpp"
#include "../families/hierarchy_families.hpp"
#include "../points/row_points.hpp"
#include "../points/vertex_links.hpp"
#include "../uniform/refine.hpp"
#include "hierarchy.hpp"

#include <string>
#include <utility>

namespace tetrakis {

Hierarchy make_hierarchy(const ControlMesh& mesh, const SchemeInfo& scheme, const HierarchyOptions& options) {
    if (const int steps = averaging_steps(scheme, options.rules); steps < 0 || steps > k_most_averaging_steps)
        throw Error(ErrorCode::invalid_input, "the number of averaging steps must be from 0 to 64");
    const auto by_rows = [&](const RuleOptions& rules, const VertexRoots* roots) {
        return detail::row_points(mesh, scheme, rules, roots, options.context, options.whole_levels,
                                  options.limit_positions);
    };
    if (scheme.family != MeshFamily::hexagons && fan_lattice(scheme, options.rules) == FanLattice::dual) {
        VertexRoots roots = vertex_roots(mesh, scheme, options.rules);
        std::shared_ptr<const LevelSource> of_cells = by_rows(options.rules, &roots);
        return Hierarchy(vertex_family(mesh, std::move(of_cells), std::move(roots)), scheme, options.rules);
    }
    if (boundary_recedes(scheme, options.rules) && mesh.has_boundary())
        throw Error(ErrorCode::unsupported,
                    "a boundary that recedes leaves sites without vertex; hierarchies need one that is replicated");
    if (scheme.refinement == Refinement::sqrt3) {
        if (!mesh.all_triangles())
            throw Error(ErrorCode::invalid_input, "sqrt3 needs a triangle mesh; triangulate() makes one");
        std::shared_ptr<const LevelSource> levels =
            sqrt3_levels(mesh, scheme, options.rules, options.context, options.whole_levels, options.limit_positions);
        return Hierarchy(sqrt3_family(mesh, std::move(levels)), scheme, options.rules);
    }
    if (scheme.refinement == Refinement::honeycomb)
        throw Error(ErrorCode::unsupported, "there is no hierarchy for " + std::string(scheme.name) +
                                                ": its vertices are no sites of corner cells or triangles");
    const auto source = by_rows(detail::with_crease_method(mesh, scheme, options.rules), nullptr);
    const bool triangles = scheme.family == MeshFamily::triangles;
    return Hierarchy(triangles ? triangle_family(mesh, source) : bisection_family(mesh, source), scheme, options.rules);
}

Hierarchy make_hierarchy(const ControlMesh& mesh, std::string_view scheme, const HierarchyOptions& options) {
    return make_hierarchy(mesh, scheme_named(scheme), options);
}

}  // namespace tetrakis
