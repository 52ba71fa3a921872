#pragma once

#include "../core/masks.hpp"
#include "../core/rule_step.hpp"

#include <vector>

namespace tetrakis {

/// Modified Butterfly: interpolating, triangles, old vertices never move. Sources: Zorin, Schroeder, Sweldens 1996
/// (interior), Zorin's thesis 1997 (boundary; as re-derived and corrected, see the masks below).
struct ModifiedButterfly {
    /// Weights of an edge between regular interior vertices, with the tension w of the ten-point rule. For w = 0 the
    /// two far points have no weight. In order: each end, opposite corner, wing, and far point on the edge's line.
    struct Regular {
        double end, opposite, wing, far;
    };
    static constexpr Regular regular(double w = 0) { return {0.5 - w, 0.125 + 2 * w, -0.0625 - w, w}; }
    /// Weight of an extraordinary interior vertex itself; its ring has the weights extraordinary_ring().
    static constexpr double extraordinary_vertex = 3.0 / 4;

    /// Ring weights s_i around an extraordinary interior vertex for the edge to neighbour 0.
    static std::vector<double> extraordinary_ring(int valence);
    /// Weights beside an extraordinary crease vertex with K faces on this side, for the edge to ring vertex i, 0 < i <
    /// K: the vertex itself, then ring vertices 0 .. K. The row sums to one and cos(j theta), sin(j theta), sin(2 j
    /// theta), theta = pi / K, are its eigenfunctions with 1/2, 1/2, 1/4; the form printed in the SIGGRAPH 2000 course
    /// notes (1 / k and an even end weight) has neither property.
    static std::vector<double> crease_ring(int faces, int i);
};

/// One step. There are seven kinds of edges: crease (four-point; at its end the missing point is 2 p_0 - p_1), regular
/// interior at both ends, extraordinary interior, regular interior to regular crease, crease to crease (across one
/// corner triangle; across a strip), and extraordinary crease vertex. Two extraordinary ends: the mean of their rules.
/// With options.reflect_at_boundary, points beyond a crease are reflections of the triangle inside.
/// @throws std::invalid_argument  a face is no triangle, or options.butterfly_w is not between -1/16 and 1/24
RuleStep modified_butterfly_step(const RuleMesh& mesh, const RuleOptions& options);
/// The original scheme of Dyn, Levin, Gregory 1990: the eight- or ten-point rule at every valence, with reflections as
/// missing points. Its surface is not smooth at valence 3. It throws as modified_butterfly_step().
RuleStep butterfly_step(const RuleMesh& mesh, const RuleOptions& options);

/// Limit positions are the vertices themselves. Tangents: the cos / sin masks of the ring if the valence is not 6, the
/// 19-vectors of Zorin, Schroeder, Sweldens 1996 if it is 6; along a boundary (1, -8, 0, 8, -1).
ClosedMasks modified_butterfly_closed_masks(const FanShape& shape, const RuleOptions& options);
ClosedMasks butterfly_closed_masks(const FanShape& shape, const RuleOptions& options);

}  // namespace tetrakis
