#pragma once

#include "../../hier/mesh/control_mesh.hpp"
#include "../../hier/trees/vertex_roots.hpp"
#include "../../schemes/core/scheme_table.hpp"
#include "cell_frame.hpp"

#include <vector>

namespace tetrakis::detail {

/// The cells of a dual scheme's level 1, before their orientation is made that of corner cells: one for each vertex,
/// then for each vertex on creases those of its other sides.
struct FirstCells {
    /// Of corners' children as the corners lie; else the half-edge is the first counter-clockwise of its side, at
    /// corner 2.
    std::vector<VertexFrame> frames;
    std::vector<FaceId> face;  ///< of the cells that are children of corners: the control face; else invalid
};
FirstCells first_cells(const ControlMesh& control, const RuleStep& first_step);

}  // namespace tetrakis::detail

namespace tetrakis {

/// The roots of a dual scheme's vertex quadtrees: the vertices of level 1, and how their cells lie beside each other.
/// O(H).
/// @throws Error  invalid_input: a mesh that the scheme cannot take, a scheme that is not dual; unsupported: a vertex
///                that does not have four children on each side of its creases, a boundary that recedes
VertexRoots vertex_roots(const ControlMesh& control, const SchemeInfo& scheme, const RuleOptions& rules = {});

}  // namespace tetrakis
