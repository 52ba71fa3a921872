#pragma once

#include "../core/rule_step.hpp"

#include <vector>

namespace tetrakis {

/// Kobbelt's interpolating scheme for quads (Kobbelt 1996): the tensor product of the four-point rule. A virtual point
/// continues the row of an edge beyond an extraordinary vertex. It is chosen so that both rows through a face at that
/// vertex give the same face point.
struct Kobbelt {
    static constexpr double w = -1.0 / 16, a = 0.5 - w;
    /// The virtual point for ring edge 0 of an extraordinary interior vertex, as weights of the edge neighbours and of
    /// the corners f_i between edges i and i + 1.
    struct VirtualPoint {
        std::vector<double> edge, face;
    };
    static VirtualPoint virtual_point(int valence);
    /// The point beyond a boundary or crease vertex with K faces, on the row of its ring edge i, 0 < i < K: weights of
    /// the vertex and of ring edges 0 .. K. It mirrors the ring's best planar fit with half-plane angles i pi / K, so
    /// that only two modes have the eigenvalue 1/2. With 2 p_0 - p_1, which it is for K = 2, each row would have such a
    /// mode, and there would be no tangent plane. The next eigenvalue is that of a row against a fixed point, (9 +
    /// sqrt(17)) / 32 = 0.410. (The paper has rules for regular boundaries only; this one is tested by analyse().)
    static std::vector<double> boundary_point(int faces, int i);
};

/// One step. Boundaries and creases follow the four-point rule along themselves. Rows of vertices that end there are
/// continued by boundary_point(), at corners by 2 p_0 - p_1; rows of edge points always by 2 p_0 - p_1. A face point
/// comes from the row that meets fewer extraordinary vertices, or is the mean of both rows if neither meets fewer; in
/// the regular case they agree. A mesh with faces other than quads takes a step of `bilinear` instead, which
/// interpolates as well and leaves only quads.
RuleStep kobbelt_step(const RuleMesh& mesh, const RuleOptions& options);

}  // namespace tetrakis
