#pragma once

#include "../core/masks.hpp"
#include "../core/rule_step.hpp"

#include <vector>

namespace tetrakis {

/// Modified Butterfly: interpolating, triangles, old vertices never move. Sources: Zorin, Schroeder, Sweldens 1996
/// (interior), Zorin's thesis 1997 (boundary; as re-derived and corrected, see the masks below).
struct ModifiedButterfly {
    /// Weights of an edge between regular interior vertices, with the tension w of the ten-point rule; w = 0 leaves out
    /// the two far points. In order: each end, each opposite corner, each wing, each far point on the edge's line.
    struct Regular {
        double end, opposite, wing, far;
    };
    static constexpr Regular regular(double w = 0) { return {0.5 - w, 0.125 + 2 * w, -0.0625 - w, w}; }
    /// Weight of an extraordinary interior vertex itself; the ring's are extraordinary_ring().
    static constexpr double extraordinary_vertex = 3.0 / 4;

    /// Ring weights s_i around an extraordinary interior vertex for the edge to neighbour 0.
    static std::vector<double> extraordinary_ring(int valence);
    /// Weights beside an extraordinary crease vertex with K faces on this side, for the edge to ring vertex i, 0 < i <
    /// K: the vertex itself, then ring vertices 0 .. K. The row sums to one and cos(j theta), sin(j theta), sin(2 j
    /// theta), theta = pi / K, are its eigenfunctions with 1/2, 1/2, 1/4; the form printed in the SIGGRAPH 2000 course
    /// notes (1 / k and an even end weight) has neither property.
    static std::vector<double> crease_ring(int faces, int i);
};

/// One step. Seven kinds of edges: crease (four-point; at its end the missing point is 2 p_0 - p_1), both ends regular
/// interior, extraordinary, regular interior to regular crease, crease to crease (across one corner triangle; across a
/// strip), beside an extraordinary crease vertex. Two extraordinary ends: the mean of their rules. With
/// options.reflect_at_boundary, points missing beyond a crease are reflections of the triangle inside instead.
/// @throws std::invalid_argument  a face is no triangle
RuleStep modified_butterfly_step(const RuleMesh& mesh, const RuleOptions& options);
/// The original scheme of Dyn, Levin, Gregory 1990: the eight- or ten-point rule everywhere, whatever the valence;
/// missing points by reflection. Its surface is not smooth at valence 3.
RuleStep butterfly_step(const RuleMesh& mesh, const RuleOptions& options);

/// Limit positions are the vertices themselves. Tangents: valence != 6 the cos / sin masks of the ring, valence 6 the
/// 19-vectors of Zorin, Schroeder, Sweldens 1996; along a boundary (1, -8, 0, 8, -1).
ClosedMasks modified_butterfly_closed_masks(const FanShape& shape, const RuleOptions& options);
ClosedMasks butterfly_closed_masks(const FanShape& shape, const RuleOptions& options);

}  // namespace tetrakis
