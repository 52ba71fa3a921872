#pragma once

#include "../core/masks.hpp"
#include "../core/rule_step.hpp"

namespace tetrakis {

/// The 4-8 scheme of Velho, Zorin 2001, on quads as blocks of two triangles: two bisection steps at once, each quad in
/// four. One bisection: a block's new point is the mean of its four corners; an old vertex keeps 1/2 and takes 1/2 of
/// the mean of its neighbours along the blocks' sides. Boundary and crease edges wait in the first bisection and follow
/// the cubic B-spline in the second; a corner stays. Regular: the box spline of e1, e2, e1 + e2, e1 - e2, twice each;
/// C4.
///
/// The rules at extraordinary vertices and boundaries are the direct generalisation; their eigenstructure is checked by
/// spectral analysis, not against the paper. A mesh with other faces than quads takes four_eight_first_step() first.
RuleStep four_eight_step(const RuleMesh& mesh, const RuleOptions& options);

/// From any polygons to quads: the one bisection of the tetrakis mesh, whose blocks lie across the edges (an edge's two
/// ends and the centroids of its faces). New points as for `bilinear`: vertices, edges, faces; a vertex takes 1/2 of
/// the mean of its faces' centroids, a face its centroid, an edge the mean of its ends and of both centroids.
RuleStep four_eight_first_step(const RuleMesh& mesh, const RuleOptions& options = {});

/// Masks of four_eight_step(). Limits for every valence; tangents in the regular case and along boundaries.
ClosedMasks four_eight_closed_masks(const FanShape& shape, const RuleOptions& options);

}  // namespace tetrakis
