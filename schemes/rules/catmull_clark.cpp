#include "catmull_clark.hpp"

#include <algorithm>
#include <cmath>

namespace tetrakis {

RingMask CatmullClark::vertex_mask(int valence) {
    const double n = valence;
    return {.vertex = (n - 2) / n, .edge = 1 / (n * n), .face = 1 / (n * n)};
}

RingMask CatmullClark::vertex_mask_quads(int valence) {
    const double n = valence;
    return {.vertex = 1 - 7 / (4 * n), .edge = 3 / (2 * n * n), .face = 1 / (4 * n * n)};
}

RingMask CatmullClark::limit_mask(int valence) {
    const double n = valence;
    return {.vertex = n / (n + 5), .edge = 4 / (n * (n + 5)), .face = 1 / (n * (n + 5))};
}

double CatmullClark::mode_eigenvalue(double angle) {
    const double c = std::cos(angle);
    return (5 + c + std::sqrt(std::max(0.0, (1 + c) * (9 + c)))) / 16;
}

double CatmullClark::tangent_edge_factor(double angle) {
    // From the column of a face weight: A / 16 + 1 / 4 = lambda.
    return 16 * mode_eigenvalue(angle) - 4;
}

}  // namespace tetrakis
