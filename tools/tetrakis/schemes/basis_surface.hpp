#pragma once

#include "fan_patch.hpp"

#include "../../../eval/surface/triangle_mesh.hpp"

#include <vector>

namespace tetrakis::cli {

/// The graph of a patch's basis function over the plane, on the limit surface: y is up, x to the right.
struct BasisSurface {
    TriangleMesh mesh;
    double peak = 0;  ///< the largest value of the function, of those at the mesh's vertices
};

/// @param near    the vertices that are drawn, and the faces between them
/// @param height  of the function's value one
BasisSurface basis_surface(const FanPatch& patch, const SchemeInfo& scheme, const RuleOptions& rules,
                           const std::vector<int>& near, double height);

}  // namespace tetrakis::cli
