#pragma once

#include "../../../eval/surface/triangle_mesh.hpp"
#include "../../../hier/base/vec.hpp"
#include "../../../schemes/analysis/spectrum.hpp"
#include "../../../schemes/core/rule_mesh.hpp"

#include <vector>

namespace tetrakis::cli {

/// The neighbourhood of an extraordinary point, mapped to the plane by its characteristic map, with one basis function
/// as heights: that of the vertex in the middle or (dual schemes) of the first corner of the face in the middle. At a
/// boundary it is the upper half-plane, and its two directions have different eigenvalues.
struct FanPatch {
    RuleMesh mesh;
    std::vector<Vec2d> plane;    ///< plane positions of the vertices; the middle point is the origin
    std::vector<double> height;  ///< control heights of the basis function
    std::vector<int> start;      ///< half-edges from which find_fan() starts; empty for hexagons
    int intervals = 1;           ///< edges of `mesh` along an edge of the first mesh
    int steps = 0;
    bool characteristic = true;  ///< false: the spectrum has no characteristic map, and `plane` is a sketch
};

/// The unrefined patch, several rings of control mesh, around the point that the analysis is about.
/// @throws std::invalid_argument  the scheme does not accept the options
FanPatch fan_patch(const SchemeInfo& scheme, const SpectralAnalysis& analysis, const RuleOptions& rules);
void refine(FanPatch& patch, const SchemeInfo& scheme, const RuleOptions& rules);

/// Rings of a FanPatch that the rim of its mesh does not influence, after any number of steps.
inline constexpr int k_patch_rings = 4;

/// Graph of a patch's basis function over the plane, as limit points: y is up, x to the right.
struct BasisSurface {
    TriangleMesh mesh;
    double peak = 0;  ///< largest value of the function at the mesh's vertices
};

/// @param near    vertices of the patch that the graph contains, with the faces between them
/// @param height  height of the function value 1
BasisSurface basis_surface(const FanPatch& patch, const SchemeInfo& scheme, const RuleOptions& rules,
                           const std::vector<int>& near, double height);

}  // namespace tetrakis::cli
