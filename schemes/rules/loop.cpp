#include "loop.hpp"

#include <cmath>
#include <numbers>

namespace tetrakis {

double Loop::mode_eigenvalue(double angle) { return 3.0 / 8 + std::cos(angle) / 4; }

double Loop::beta(int valence) {
    if (valence == 6) return 1.0 / 16;  // exactly, where the cosine would round
    const double lambda = mode_eigenvalue(2 * std::numbers::pi / valence);
    return (5.0 / 8 - lambda * lambda) / valence;
}

double Loop::beta_warren(int valence) { return valence > 3 ? 3.0 / (8.0 * valence) : 3.0 / 16; }

RingMask Loop::limit_mask(int valence, double beta) {
    const double chi = 1 / (3 / (8 * beta) + valence);
    return {.vertex = 1 - valence * chi, .edge = chi};
}

}  // namespace tetrakis
