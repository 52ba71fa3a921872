#pragma once

#include "../../../eval/surface/triangle_mesh.hpp"
#include "../../../hier/base/vec.hpp"
#include "../../../schemes/analysis/spectrum.hpp"
#include "../../../schemes/core/rule_mesh.hpp"

#include <vector>

namespace tetrakis::cli {

/// The surroundings of an extraordinary point laid out in the plane by its characteristic map, with a basis function
/// above them: of the vertex in the middle, or (dual schemes) of the first corner of the face in the middle. At a
/// boundary: a half of the plane, the boundary its lower side, and the two tangents' own eigenvalues.
struct FanPatch {
    RuleMesh mesh;
    std::vector<Vec2d> plane;    ///< the vertices in the plane, the point in the middle at the origin
    std::vector<double> height;  ///< of the basis function
    std::vector<int> start;      ///< half-edges to walk from, as find_fan() takes them; empty for hexagons
    int intervals = 1;           ///< edges of `mesh` along an edge of the first mesh
    int steps = 0;
    bool characteristic = true;  ///< else the spectrum has no such map, and the plane is a sketch
};

/// The control mesh, several rings of it, at the point that the analysis looks at.
/// @throws std::invalid_argument  the scheme cannot take the options
FanPatch fan_patch(const SchemeInfo& scheme, const SpectralAnalysis& analysis, const RuleOptions& rules);
void refine(FanPatch& patch, const SchemeInfo& scheme, const RuleOptions& rules);

/// Rings of a FanPatch that the rim of its mesh is far enough from, after any number of steps.
inline constexpr int k_patch_rings = 4;

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
