#pragma once

#include "../core/masks.hpp"
#include "../core/rule_step.hpp"

#include <vector>

namespace tetrakis {

/// Loop's scheme with prescribed eigenvalues at extraordinary vertices (the modified Loop scheme that the SIGGRAPH 2000
/// course notes describe, section 4.8, without coefficients; these are derived here).
///
/// An edge at an extraordinary vertex c takes 3/8 of c and b_i of the whole ring, which makes the ring's block of
/// Fourier mode j the single number sum b_i cos(2 pi i j / n). Prescribed: 5/8 for mode 0 (with 3/8 of c the row sums
/// to one), 1/2 for modes +-1, 1/4 for +-2, 1/8 for the others; these are the regular vertex' own, and b is their
/// inverse transform. The vertex gives 3/8 to its ring, as the regular one does, so the other eigenvalue of mode 0 is
/// 1/4. With `tuning` t every eigenvalue is (1 - t) Loop's + t the prescribed one: t = 1 gives evenly sized triangles
/// and no crease at high valence, but larger ripples inside the first ring: on a parabolic ridge at valence 12 and 24
/// seven and ten times Loop's there, 0.0006 and 0.0003 of an edge's length (tools/figures, sheet tuned_loop); t = 0 is
/// Loop.
struct TunedLoop {
    /// b_i, i = 0 .. n - 1, for the edge to ring vertex 0.
    static std::vector<double> edge_ring(int valence, double tuning);
    static constexpr double edge_vertex = 3.0 / 8;
    /// Weight of each neighbour in the vertex rule; with two edges Loop's, as all rules are there.
    static double beta(int valence, double tuning);
};

/// One step. Boundary, creases, corners, darts as Loop's; an edge between two extraordinary vertices takes the mean of
/// their rules. @throws std::invalid_argument  a face is no triangle
RuleStep tuned_loop_step(const RuleMesh& mesh, const RuleOptions& options);
ClosedMasks tuned_loop_closed_masks(const FanShape& shape, const RuleOptions& options);

}  // namespace tetrakis
