#include "../core/dense_eigen.hpp"
#include "catmull_clark.hpp"
#include "loop.hpp"
#include "ring_layout.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

namespace tetrakis::detail {

namespace {

/// The mirror at the sharp edge 0 swaps edge i with -i and face i with -1 - i. Symmetric modes live on its orbits.
struct MirrorOrbits {
    std::vector<int> orbit;           ///< of each ring point
    std::vector<int> representative;  ///< of each orbit
    std::vector<int> length;

    MirrorOrbits(const RingLayout& at, int n) : orbit(at.size(), -1) {
        insert(0, 0);
        for (int i = 0; i < n; ++i) insert(at.edge(i), at.edge((n - i) % n));
        for (int i = 0; at.quads && i < n; ++i) insert(at.face(i), at.face(n - 1 - i));
    }
    int count() const { return static_cast<int>(length.size()); }

  private:
    void insert(int a, int b) {
        if (orbit[a] >= 0) return;
        orbit[a] = orbit[b] = count();
        representative.push_back(a);
        length.push_back(a == b ? 1 : 2);
    }
};

}  // namespace

RingLimit dart_limit(SchemeKind scheme, int n) {
    RingShape shape{.faces = n, .sharp = std::vector<std::uint8_t>(n, 0)};
    shape.sharp[0] = 1;
    const RingLayout at(scheme, shape);
    const std::vector<double> full = ring_matrix(scheme, shape);
    const int size = at.size();

    const MirrorOrbits orbits(at, n);
    const int count = orbits.count();
    DenseMatrix<double> m(count);
    for (int a = 0; a < count; ++a)
        for (int j = 0; j < size; ++j)
            m(a, orbits.orbit[j]) += full[static_cast<std::size_t>(orbits.representative[a]) * size + j];
    const auto spread = [&](const std::vector<double>& y, double scale) {
        std::vector<double> weights(size);
        for (int j = 0; j < size; ++j) weights[j] = scale * y[orbits.orbit[j]] / orbits.length[orbits.orbit[j]];
        return weights;
    };

    RingLimit limit;
    const std::vector<double> position = left_eigenvector(m, 1.0);
    limit.position = spread(position, 1 / std::accumulate(position.begin(), position.end(), 0.0));

    const std::vector<Complex> values = eigenvalues(m);
    std::vector<double> magnitude(count);
    for (int i = 0; i < count; ++i) magnitude[i] = std::abs(values[i]);
    std::vector<int> order(count);
    for (int i = 0; i < count; ++i) order[i] = i;
    std::sort(order.begin(), order.end(), [&](int a, int b) { return magnitude[a] > magnitude[b]; });

    const double angle = 2 * std::numbers::pi / n;
    RingLimit::Sector sector{.first_edge = 0, .faces = n};
    sector.lambda1 = values[order[1]].real();
    const std::vector<double> symmetric = left_eigenvector(m, sector.lambda1);
    // The mode grows towards the crease edge.
    double along = 0;
    const std::vector<double> weights = spread(symmetric, 1);
    for (int i = 0; i < n; ++i) along += weights[at.edge(i)] * std::cos(i * angle);
    sector.tangent1 = spread(symmetric, along < 0 ? -1 : 1);

    // Antisymmetric modes vanish on the crease edge, so the smooth rules' sine mode is theirs as well.
    sector.tangent2.assign(size, 0.0);
    if (at.quads) {
        sector.lambda2 = CatmullClark::mode_eigenvalue(angle);
        const double factor = CatmullClark::tangent_edge_factor(angle);
        for (int i = 0; i < n; ++i) {
            sector.tangent2[at.edge(i)] = n == 2 ? 0 : factor * std::sin(i * angle);
            sector.tangent2[at.face(i)] = std::sin(i * angle) + std::sin((i + 1) * angle);
        }
        if (n == 2) {
            sector.tangent2[at.face(0)] = 1;
            sector.tangent2[at.face(1)] = -1;
        }
    } else {
        sector.lambda2 = Loop::mode_eigenvalue(angle);
        for (int i = 0; n > 2 && i < n; ++i) sector.tangent2[at.edge(i)] = std::sin(i * angle);
    }
    const double third = count > 2 ? magnitude[order[2]] : 0.0;
    sector.has_tangent_plane = n > 2 && third < std::min(sector.lambda1, sector.lambda2);
    limit.sectors.push_back(std::move(sector));
    return limit;
}

}  // namespace tetrakis::detail
