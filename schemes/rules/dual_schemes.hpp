#pragma once

#include <vector>

namespace tetrakis {

/// Dual schemes with one rule: weights of a k-gon's corners in a new corner, in order from the old corner there.
/// Sources: Doo, Sabin 1978; Catmull, Clark 1978 (their weights for it).
struct DooSabin {
    /// 1/4 + 5/(4k), then (3 + 2 cos(2 pi i / k)) / (4k). Eigenvalues of the k-gon: 1, 1/2 twice, 1/4.
    static std::vector<double> weights(int k);
    /// Catmull and Clark's: 1/2 for the corner and 1/8 for its neighbours, plus 1/(4k) for every corner. Subdominant
    /// eigenvalue: 1/2 + cos(2 pi / k) / 4.
    static std::vector<double> weights_catmull_clark(int k);
};

/// Dual schemes with one rule, as in DooSabin. Sources: Habib, Warren 1995; Peters, Reif 1997.
struct Midedge {
    /// (1 + 2 sum 2^(-j) cos(2 pi i j / k), 0 < j < k / 2) / k: eigenvalues 1 and 2^(-j) twice, so the subdominant ones
    /// are 1/2 for every k. The form follows from these properties (the sum starts at 1; printed sums start at 0).
    static std::vector<double> weights(int k);
    /// Two rounds of joining midpoints: 1/2, and 1/4 for each neighbour. Subdominant (1 + cos(2 pi / k)) / 2.
    static std::vector<double> weights_simplest(int k);
};

/// A dual scheme's rule for the new corner at corner a_0 of a k-gon, in the points that the 4-8 mesh has around the
/// k-gon's centre c after its sides are bisected. The weights are of a_0, of c (the mean of the corners), and of the
/// midpoints s_i of (a_i, a_(i+1)), i from 0 to k - 1. They sum to one.
///
/// The corners could be computed from a_0 and the midpoints (a_(i+1) = 2 s_i - a_i, Velho), but rounding errors then
/// grow linearly with k. The midpoints scale the k-gon's Fourier mode m by cos(pi m / k) and turn it by half a step. So
/// a scheme with eigenvalues l_m has the corner's weight w, and midpoint weights whose modes are (l_m - w) / cos(pi m /
/// k). No weights are large: their magnitudes sum to 5/3 at most.
struct FactoredCornerMask {
    double corner = 0, centre = 0;
    std::vector<double> midpoint;
};

/// Doo-Sabin's rules in that form. Source: Velho, "Using semi-regular 4-8 meshes for subdivision surfaces"
/// (the factorisation); the Fourier form is not in that paper.
FactoredCornerMask factored_doo_sabin(int k);
/// Catmull and Clark's weights: (a_0 + s_0 + s_(k-1) + c) / 4: only points beside the new corner.
FactoredCornerMask factored_doo_sabin_catmull_clark(int k);
/// Midedge subdivision with the weights of Midedge::weights().
FactoredCornerMask factored_midedge(int k);
/// (s_0 + s_(k-1)) / 2: only points beside the new corner.
FactoredCornerMask factored_midedge_simplest(int k);

}  // namespace tetrakis
