#pragma once

#include <vector>

namespace tetrakis {

/// A dual scheme's rule for the new corner at corner a_0 of a k-gon, in what the 4-8 mesh has around the k-gon's
/// centre c once its sides are cut in half: weights of a_0, of c (the mean of the corners), and of the midpoints s_i of
/// (a_i, a_(i+1)), i from 0 to k - 1. The weights sum to one.
///
/// Taking the corners back out of a_0 and the midpoints (a_(i+1) = 2 s_i - a_i, Velho) is exact, but rounding grows
/// linearly with k. Instead: midpoints scale the k-gon's Fourier mode m by cos(pi m / k) and turn it by half a step, so
/// a scheme with eigenvalues l_m follows from its corner's weight w and the midpoint weights whose modes are
/// (l_m - w) / cos(pi m / k). No weights are large: their magnitudes sum to 5/3 at most.
struct FactoredCornerMask {
    double corner = 0, centre = 0;
    std::vector<double> midpoint;
};

/// The rules of doo_sabin.hpp in that form. Source: Velho, "Using semi-regular 4-8 meshes for subdivision surfaces"
/// (the factorisation); the Fourier form is ours.
FactoredCornerMask factored_doo_sabin(int k);
/// Catmull and Clark's weights: (a_0 + s_0 + s_(k-1) + c) / 4, only what is beside the new corner.
FactoredCornerMask factored_doo_sabin_catmull_clark(int k);
FactoredCornerMask factored_midedge(int k);
/// (s_0 + s_(k-1)) / 2, only what is beside the new corner.
FactoredCornerMask factored_midedge_simplest(int k);

}  // namespace tetrakis
