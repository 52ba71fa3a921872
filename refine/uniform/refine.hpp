#pragma once

#include "../../hier/mesh/control_mesh.hpp"
#include "../../schemes/core/scheme_table.hpp"
#include "../../schemes/core/stencil_table.hpp"
#include "../rules/refine_options.hpp"

#include <optional>
#include <string>
#include <string_view>

namespace tetrakis {

/// The control mesh refined everywhere by any scheme, as many levels as asked.
///
/// The schemes' rules (RuleRefiner) make the first levels: none on quads and triangles without tags that run out, one
/// or a few elsewhere. From there on the faces of a level are lattices, whose rows of weights repeat themselves from
/// level to level, and no connectivity is made any more; the regular rows of Catmull-Clark and Loop have kernels. What
/// does not repeat goes by the rules to the end: honeycomb refinement; Chaikin's creases while they are semi-sharp;
/// linear texture coordinates of sqrt3 and of even averages whose boundary recedes; those of dual schemes along a
/// crease that ends at a seam; more than 32767 faces around a vertex or edges around a face. Vertices and faces are in
/// no order to rely on. Holes are left out, and then the vertices that no face uses. Materials and groups are those of
/// the control face that a face belongs to. UVs are refined face-varying (see uv_mesh()) by the same scheme, seams as
/// boundaries. Faces of dual schemes and honeycomb lie across the seams; there charts go on straight beyond them, so
/// that the smooth rules hold up to the seam, and a face takes the UVs of one side (the face-varying rule makes no
/// difference to them). Creases are refined by the uniform rule but for plain Catmull-Clark and Loop. Triangle schemes
/// take other faces cut by triangulate(), with a warning.
/// @param levels  >= 0: steps of the scheme (a sqrt3 or 4-8 step is two of its simple steps)
/// @param options limit: of the points alone; UVs are those of the level. normals: none for the schemes whose surfaces
/// have no tangent planes, bilinear and midpoint
/// @throws Error  invalid_input: levels < 0, an attribute of the wrong length, or a mesh that the scheme cannot take
///                (the message says why); unsupported: more elements than 32 bits can count, or a limit that the
///                scheme has no mask for; memory_limit; cancelled
/// Cost: 10 to 30 ns per vertex where rows repeat and once a millisecond or two to learn them; 0.2 to 3 us by rules.
/// The same bytes for any number of threads.
PolygonMesh refine(const ControlMesh& mesh, const SchemeInfo& scheme, int levels, const RefineOptions& options = {});
/// @throws Error  invalid_input as well for an unknown name; the message has the nearest one and all that there are
PolygonMesh refine(const ControlMesh& mesh, std::string_view scheme, int levels, const RefineOptions& options = {});

/// The same by RuleRefiner for every scheme, with its vertices as combinations of the control vertices, for users with
/// kernels of their own: row r of `stencils` is vertex r of `mesh`. Limits beside a boundary that recedes may end a
/// ring earlier.
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

/// Whether the scheme is Catmull-Clark or Loop by the rules of the patches. Options of other
/// schemes do not matter.
bool has_plain_rules(const SchemeInfo& scheme, const RuleOptions& rules);
/// And on this mesh, whose corners may have angles of their own.
bool has_plain_rules(const ControlMesh& mesh, const SchemeInfo& scheme, const RuleOptions& rules);
/// The rules, with Chaikin's for semi-sharp creases where the mesh asks for it and the scheme has it.
RuleOptions with_crease_method(const ControlMesh& mesh, const SchemeInfo& scheme, RuleOptions rules);

/// A warning, if the mesh has creases and the scheme no rule for them.
std::optional<std::string> ignored_creases(const ControlMesh& mesh, const SchemeInfo& scheme, const RuleOptions& rules);

/// Adds warnings of the mesh's tags that the scheme has no rule for, or another one.
void warn_of_ignored_tags(const ControlMesh& mesh, const SchemeInfo& scheme, const RuleOptions& rules,
                          std::vector<std::string>& warnings);

}  // namespace detail

}  // namespace tetrakis
