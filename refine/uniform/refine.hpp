#pragma once

#include "../../hier/mesh/control_mesh.hpp"
#include "../../schemes/core/scheme_table.hpp"
#include "../../schemes/core/stencil_table.hpp"
#include "../rules/refine_options.hpp"

#include <optional>
#include <string>
#include <string_view>

namespace tetrakis {

/// Refines the control mesh everywhere by any scheme, for a given number of levels.
///
/// The rules (RuleRefiner) make the first levels, often none on quads or triangles. From there on the faces are
/// lattices whose stencil rows repeat from level to level, and no connectivity is made; the interior rows of
/// Catmull-Clark and Loop have kernels. The rules make all levels for: honeycomb refinement; Chaikin's creases while
/// they are semi-sharp; UVs of dual schemes and where boundaries recede; smooth UVs of averages in 4, 6, ... steps;
/// linear UVs of sqrt3; more than 32767 faces around a vertex or edges around a face; small meshes where it is faster.
/// The order of vertices and faces is unspecified. Holes are left out, then also the vertices that no face uses. A face
/// has the material and the group of its control face. UVs are refined face-varying (see uv_mesh()) by the same scheme,
/// with seams as boundaries. Faces of dual schemes and honeycomb lie across seams: there charts are continued straight
/// beyond the seam, so that the smooth rules hold up to it. Such a face takes the UVs of one side, whatever the
/// face-varying rule. Creases are refined by the uniform rule; plain Catmull-Clark and Loop also know Chaikin's.
/// Triangle schemes take other faces cut by triangulate(), with a warning.
/// @param levels  >= 0: steps of the scheme (a sqrt3 or 4-8 step is two of its simple steps)
/// @param options limit: moves points only, UVs stay those of the level; normals: empty for bilinear and midpoint,
/// whose surfaces have no tangent planes
/// @throws Error  invalid_input: levels < 0, an attribute of the wrong length, or a mesh that the scheme cannot take
///                (the message says why); unsupported: more elements than 32 bits can count, or a limit that the
///                scheme has no mask for; memory_limit; cancelled
/// Cost: 10 to 30 ns per vertex where rows repeat, and 1 to 2 ms once to learn them; 0.2 to 3 us per vertex by rules.
/// The same bytes for any number of threads.
PolygonMesh refine(const ControlMesh& mesh, const SchemeInfo& scheme, int levels, const RefineOptions& options = {});
/// @throws Error  also invalid_input: no scheme has this name; the message gives the nearest name and all names
PolygonMesh refine(const ControlMesh& mesh, std::string_view scheme, int levels, const RefineOptions& options = {});

/// A mesh as from refine(), but always made by RuleRefiner, and its vertices as combinations of the control vertices,
/// for users with kernels of their own: row r of `stencils` gives vertex r of `mesh`. Where a boundary recedes, the
/// limit surface may end one ring earlier.
/// @throws Error  as refine(); invalid_input: faces that a triangle scheme would have to cut first, see triangulate()
struct RefinedStencils {
    PolygonMesh mesh;
    StencilTable stencils;
};
RefinedStencils refine_stencils(const ControlMesh& mesh, const SchemeInfo& scheme, int levels,
                                const RefineOptions& options = {});

/// The scheme of that name. @throws Error invalid_input, as refine()
const SchemeInfo& scheme_named(std::string_view name);

namespace detail {

/// Whether the scheme is Catmull-Clark or Loop, with the rules that patches assume. Options of other schemes are
/// ignored.
bool has_plain_rules(const SchemeInfo& scheme, const RuleOptions& rules);
/// The same, and the mesh has no corner angles.
bool has_plain_rules(const ControlMesh& mesh, const SchemeInfo& scheme, const RuleOptions& rules);
/// The rules, with Chaikin's method for semi-sharp creases if the mesh asks for it and the scheme has it.
RuleOptions with_crease_method(const ControlMesh& mesh, const SchemeInfo& scheme, RuleOptions rules);

/// A warning if the mesh has creases that the scheme ignores, or semi-sharp ones that it keeps sharp for ever.
std::optional<std::string> ignored_creases(const ControlMesh& mesh, const SchemeInfo& scheme, const RuleOptions& rules);

/// Adds a warning for each type of tag on the mesh that the scheme ignores or refines by another rule.
void warn_of_ignored_tags(const ControlMesh& mesh, const SchemeInfo& scheme, const RuleOptions& rules,
                          std::vector<std::string>& warnings);

}  // namespace detail

}  // namespace tetrakis
