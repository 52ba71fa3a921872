#include "factored_dual.hpp"

#include <cmath>
#include <numbers>

namespace tetrakis {

namespace {

using std::numbers::pi;

/// @param eigenvalue  of mode m, 0 <= m < k / 2; that of mode k / 2 is the corner's weight, since midpoints lose it
template <class Eigenvalue>
FactoredCornerMask from_modes(int k, double corner, Eigenvalue&& eigenvalue) {
    FactoredCornerMask mask{.corner = corner, .centre = 0, .midpoint = std::vector<double>(k, (1 - corner) / k)};
    for (int m = 1; 2 * m < k; ++m) {
        const double mode = (eigenvalue(m) - corner) / std::cos(pi * m / k);
        if (mode == 0) continue;
        for (int i = 0; i < k; ++i) {
            // Whole turns are taken out first: m (2 i + 1) pi / k would lose digits.
            const int turn = static_cast<int>(static_cast<long long>(m) * (2 * i + 1) % (2 * k));
            mask.midpoint[i] += 2 * mode * std::cos(pi * turn / k) / k;
        }
    }
    return mask;
}

FactoredCornerMask beside(int k, double corner, double centre, double midpoint) {
    FactoredCornerMask mask{.corner = corner, .centre = centre, .midpoint = std::vector<double>(k, 0.0)};
    mask.midpoint[0] = mask.midpoint[k - 1] = midpoint;
    return mask;
}

}  // namespace

FactoredCornerMask factored_doo_sabin(int k) {
    return from_modes(k, 0.25, [](int m) { return m == 1 ? 0.5 : 0.25; });
}

FactoredCornerMask factored_doo_sabin_catmull_clark(int k) { return beside(k, 0.25, 0.25, 0.25); }

FactoredCornerMask factored_midedge(int k) {
    return from_modes(k, 0, [](int m) { return std::ldexp(1.0, -m); });
}

FactoredCornerMask factored_midedge_simplest(int k) { return beside(k, 0, 0, 0.5); }

}  // namespace tetrakis
