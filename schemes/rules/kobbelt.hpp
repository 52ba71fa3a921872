#pragma once

#include "../core/rule_step.hpp"

#include <vector>

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
    /// The point beyond a boundary or crease vertex with K faces, on the row of its ring edge i, 0 < i < K: weights of
    /// the vertex and of ring edges 0 .. K. It mirrors the ring's best planar fit with half-plane angles i pi / K, so
    /// that only two modes keep the eigenvalue 1/2; 2 p_0 - p_1 on each row would give every row one, and no tangent
    /// plane. For K = 2 it is 2 p_0 - p_1. The next eigenvalue is that of a row against a fixed point, (9 + sqrt(17)) /
    /// 32 = 0.410. (Ours; the paper has rules for regular boundaries only. Tested by spectral analysis.)
    static std::vector<double> boundary_point(int faces, int i);
};

/// One step. Boundaries and creases follow the four-point rule along themselves; rows that end there are continued by
/// boundary_point(), at corners by 2 p_0 - p_1, and rows of edge points by 2 p_0 - p_1 always. The face point takes the
/// row that meets fewer extraordinary vertices, the mean of both rows if neither meets fewer; in the regular case they
/// agree. A mesh with faces other than quads is first split by midpoints and face means (as `bilinear`), which
/// interpolates as well and leaves only quads.
RuleStep kobbelt_step(const RuleMesh& mesh, const RuleOptions& options);

}  // namespace tetrakis
