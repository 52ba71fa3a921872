#pragma once

#include "tetrakis/schemes/closed_masks.hpp"
#include "tetrakis/schemes/rule_step.hpp"

namespace tetrakis {

/// Kobbelt's interpolating scheme for quads (Kobbelt 1996): the tensor product of the four-point rule, with a virtual
/// point that continues the row of an edge beyond an extraordinary vertex so that both rows through a face of that
/// vertex give the same face point.
struct Kobbelt {
    static constexpr double w = -1.0 / 16, a = 0.5 - w;
    /// The virtual point for ring edge 0 of an extraordinary interior vertex, as weights of the edge neighbours and of
    /// the corners f_i between edges i and i + 1.
    struct VirtualPoint {
        std::vector<double> edge, face;
    };
    static VirtualPoint virtual_point(int valence);
};

/// One step. Boundaries and creases follow the four-point rule along themselves; rows that end there are continued by
/// 2 p_0 - p_1. The face point takes the row that meets fewer extraordinary vertices, the mean of both rows if neither
/// meets fewer; in the regular case they agree. A mesh with faces other than quads is first split by midpoints and
/// face means (as `bilinear`), which interpolates as well and leaves only quads.
RuleStep kobbelt_step(const RuleMesh& mesh, const RuleOptions& options);
/// Limit positions are the vertices. Tangents have closed forms along boundaries only and in the regular case.
ClosedMasks kobbelt_closed_masks(const FanShape& shape, const RuleOptions& options);

}  // namespace tetrakis
