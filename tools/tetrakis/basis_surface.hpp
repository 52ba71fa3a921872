#pragma once

#include "fan_patch.hpp"

#include "../../eval/surface/triangle_mesh.hpp"
#include "../../hier/base/run_context.hpp"

namespace tetrakis::cli {

/// The graph of a patch's basis function over the plane, on the limit surface: y is up, x to the right.
struct BasisSurface {
    TriangleMesh mesh;
    double peak = 0;  ///< the largest value of the function, of those at the mesh's vertices
};

/// @param patch   refined so far that a fan of `rings` rings is fine enough but for its middle, which is refined here:
///                level by level half as far around the extraordinary point, until a face there is a dot
/// @param rings   of the first mesh
/// @param height  of the function's value one
BasisSurface basis_surface(const FanPatch& patch, const SchemeInfo& scheme, const FanLabels& labels,
                           const RuleOptions& rules, int rings, double height);
/// Of hexagons, which are no fan: the faces of the patch within a distance of the middle.
BasisSurface hexagon_basis_surface(const FanPatch& patch, const SchemeInfo& scheme, const RuleOptions& rules,
                                   double reach, double height);

}  // namespace tetrakis::cli
