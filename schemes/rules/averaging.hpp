#pragma once

#include "../core/closed_masks.hpp"
#include "../core/rule_step.hpp"

#include <array>

namespace tetrakis {

/// Repeated averaging (Zorin, Schroeder 2001; Warren, Weimer; Stam 2001): every k-gon in k quads, then m times each
/// quad's centroid becomes a vertex. m = 0 bilinear, 1 Doo-Sabin with Catmull and Clark's weights, 2 nearly
/// Catmull-Clark, 3 biquartic; on quads the tensor product B-spline of degree m + 1. Even m: primal, odd m: dual.
///
/// Boundary, AveragingBoundary::replicate: m = 2 takes the cubic B-spline; the others see copies of the boundary
/// vertices around the mesh, as many layers as they reach (m <= 4 one; a tagged corner with one face sees a quad of
/// copies of itself as well). AveragingBoundary::recede: only what needs no missing point is made, so the control
/// mesh's outer ring (two from m = 5 on) is used up and the surface ends inside. Creases have no rule here: tags inside
/// the mesh are ignored.
/// @throws std::invalid_argument  steps < 0, or nothing of the mesh is left
RuleStep averaging_step(const RuleMesh& mesh, const RuleOptions& options);
/// averaging_step() with three steps.
RuleStep biquartic_step(const RuleMesh& mesh, const RuleOptions& options);
ClosedMasks averaging_closed_masks(const FanShape& shape, const RuleOptions& options);
ClosedMasks biquartic_closed_masks(const FanShape& shape, const RuleOptions& options);

/// The biquartic rule at once, for a vertex all of whose faces but one k-gon are quads: weights of its k-gon's corners
/// and of the eight vertices around. The k-gon lies north-west of the vertex.
struct BiquarticMask {
    /// In the k-gon, from the vertex itself (0) on, north neighbour first: what is added on top of `around`.
    std::vector<double> ring;
    /// Weights of N, NE, W, C, E, SW, S, SE, where C is the vertex, N and W its neighbours in the k-gon.
    std::array<double, 8> around;
};
enum class BiquarticChild { north_west, north_east, south_east };
/// Of the three kinds of children (south-west is north-east mirrored).
BiquarticMask biquartic_mask(int k, BiquarticChild child);

}  // namespace tetrakis
