#include "linear.hpp"

#include "../core/corner_angles.hpp"
#include "../core/scheme_table.hpp"
#include "../parts/face_split.hpp"

namespace tetrakis {

RuleStep midpoint_step(const RuleMesh& mesh, const RuleOptions& options) {
    detail::need_triangles(mesh, "midpoint");
    return detail::split_triangles(mesh, detail::HalfSharpness(mesh), options.runner, detail::vertex_itself,
                                   [&](int h) { return detail::edge_midpoint(mesh, h); });
}

RuleStep bilinear_step(const RuleMesh& mesh, const RuleOptions& options) {
    return detail::split_polygons(
        mesh, detail::HalfSharpness(mesh), options.runner, detail::vertex_itself,
        [&](int h) { return detail::edge_midpoint(mesh, h); }, [&](int f) { return detail::face_mean(mesh, f); });
}

ClosedMasks linear_closed_masks(const FanShape&, const RuleOptions&) { return {.limit = {{{}, 1}}}; }

namespace detail {

extern constinit const SchemeInfo midpoint_scheme{
    .name = "midpoint",
    .title = "Midpoints of triangles",
    .refinement = Refinement::face_split,
    .family = MeshFamily::triangles,
    .interpolating = true,
    .smoothness = "C0",
    .generation = "1",
    .lattice = FanLattice::triangles,
    .rings = 1,
    .step = midpoint_step,
    .closed_masks = linear_closed_masks,
    .notes = "triangles; the control mesh itself",
    .pieces = SurfacePieces::linear,
    .one_ring_limits = true,
};

extern constinit const SchemeInfo bilinear_scheme{
    .name = "bilinear",
    .title = "Bilinear",
    .refinement = Refinement::face_split,
    .family = MeshFamily::quads,
    .interpolating = true,
    .smoothness = "C0",
    .generation = "bi-1",
    .lattice = FanLattice::quads,
    .rings = 1,
    .step = bilinear_step,
    .closed_masks = linear_closed_masks,
    .notes = "any polygons; quads become bilinear patches",
    .pieces = SurfacePieces::linear,
    .one_ring_limits = true,
};

}  // namespace detail
}  // namespace tetrakis
