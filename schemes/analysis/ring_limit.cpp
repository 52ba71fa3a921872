#include "ring_limit.hpp"

#include "../core/masks.hpp"
#include "spectrum.hpp"

#include <glm/geometric.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <stdexcept>

namespace tetrakis {

namespace {

using std::numbers::pi;

/// Indices of the ring's points in a row of weights.
struct RingLayout {
    bool quads;
    int edges, faces;

    RingLayout(SchemeKind scheme, const RingShape& shape)
        : quads(scheme == SchemeKind::catmull_clark), edges(shape.edge_count()), faces(shape.faces) {}

    int size() const { return 1 + edges + (quads ? faces : 0); }
    int edge(int i) const { return quads ? 1 + 2 * i : 1 + i; }
    int face(int i) const { return 2 + 2 * i; }
    /// Index of the point with a label of the fan that starts at edge `first_edge` of the ring.
    int point(FanLabel label, int first_edge) const {
        if (label.a == 0) return 0;
        const int i = first_edge + label.sector;
        return label.b == 0 ? edge(i % edges) : face(i % faces);
    }
    std::vector<double> weights(const ClosedMasks::Mask& mask, int first_edge) const {
        std::vector<double> result(size(), 0.0);
        for (const auto& [label, weight] : mask) result[point(label, first_edge)] += weight;
        return result;
    }
    std::vector<int> sharp_edges(const RingShape& shape) const {
        std::vector<int> result;
        for (int i = 0; i < edges; ++i)
            if ((shape.boundary && (i == 0 || i == edges - 1)) || (!shape.sharp.empty() && shape.sharp[i] != 0))
                result.push_back(i);
        return result;
    }
};

ClosedMasks closed_masks(SchemeKind scheme, const FanShape& shape) {
    return find_scheme(name(scheme))->closed_masks(shape, {});
}

/// Limit by the smooth rules; labels and the sector start at edge `first`.
RingLimit smooth_limit(SchemeKind scheme, const RingLayout& at, int first) {
    const int n = at.faces;
    ClosedMasks masks = closed_masks(scheme, {.faces = n});
    if (n == 2) {
        // Valence 2 has no closed forms of tangents: differences of opposite points take their place.
        masks.tangent1 = {{{0, 1, 0}, 1}, {{1, 1, 0}, -1}};
        if (at.quads) masks.tangent2 = {{{0, 1, 1}, 1}, {{1, 1, 1}, -1}};
    }
    return {at.weights(masks.limit, first),
            {{first, n, at.weights(masks.tangent1, first), at.weights(masks.tangent2, first)}}};
}

/// An interior vertex, no corner, with one sharp edge.
RingLimit dart_limit(SchemeKind scheme, const RingLayout& at, int sharp) {
    const int n = at.faces;
    // Antisymmetric modes vanish on the crease edge, so a dart has the same sine mode as the smooth rules.
    RingLimit limit = smooth_limit(scheme, at, sharp);
    SchemeInfo one_ring = *find_scheme(name(scheme));
    one_ring.rings = 1;
    const SpectralAnalysis analysis = analyse(one_ring, {.faces = n, .dart = true}, {});
    const std::vector<FanLabel>& labels = analysis.matrix.labels.all();
    RingLimit::Sector& s = limit.sectors[0];
    if (analysis.tangent1.empty())
        throw std::invalid_argument("so many edges around the end of a crease have no limit mask");
    // The sign is chosen so that the mode grows towards the crease edge.
    double along = 0;
    for (std::size_t i = 0; i < labels.size(); ++i)
        if (labels[i].a == 1 && labels[i].b == 0)
            along += analysis.tangent1[i] * std::cos(2 * pi * labels[i].sector / n);
    for (std::size_t i = 0; i < labels.size(); ++i) {
        const int point = at.point(labels[i], sharp);
        limit.position[point] = analysis.limit[i];
        s.tangent1[point] = along < 0 ? -analysis.tangent1[i] : analysis.tangent1[i];
    }
    return limit;
}

/// A sector of K faces from edge `first` on, at a crease, boundary or corner.
RingLimit::Sector sharp_sector(SchemeKind scheme, const RingLayout& at, bool corner, int first, int K) {
    ClosedMasks masks = closed_masks(scheme, {.faces = K, .boundary = true, .corner = corner});
    if (masks.tangent1.empty())  // a corner without a tangent plane: the plane that fits its edges
        for (int i = 0; i <= K; ++i) {
            const double x = std::cos(i * pi / K), y = std::sin(i * pi / K);
            masks.tangent1.insert(masks.tangent1.end(), {{{i, 1, 0}, x}, {{}, -x}});
            masks.tangent2.insert(masks.tangent2.end(), {{{i, 1, 0}, y}, {{}, -y}});
        }
    return {first, K, at.weights(masks.tangent1, first), at.weights(masks.tangent2, first)};
}

/// Tangents at a tagged corner with at most one sharp edge: a fixed point with one sector all around it.
RingLimit::Sector isolated_corner_sector(const RingLayout& at) {
    const int n = at.edges;
    ClosedMasks masks = ring_closed_masks(n, {});
    if (n == 2) masks.tangent1 = {{{0, 1, 0}, 1}, {{1, 1, 0}, -1}};
    return {0, at.faces, at.weights(masks.tangent1, 0), at.weights(masks.tangent2, 0)};
}

RingLimit compute(SchemeKind scheme, const RingShape& shape) {
    const RingLayout at(scheme, shape);
    const std::vector<int> sharp = at.sharp_edges(shape);
    const int count = static_cast<int>(sharp.size());
    const bool corner = shape.corner || count > 2;
    if (!corner && count == 0) return smooth_limit(scheme, at, 0);
    if (!corner && count == 1) return dart_limit(scheme, at, sharp[0]);
    RingLimit limit;
    limit.position.assign(at.size(), 0.0);
    limit.position[0] = corner ? 1 : k_crease_limit_mask.vertex;
    for (int i = 0; !corner && i < 2; ++i) limit.position[at.edge(sharp[i])] = k_crease_limit_mask.neighbour;
    if (count < 2) limit.sectors.push_back(isolated_corner_sector(at));
    const int sectors = count < 2 ? 0 : shape.boundary ? count - 1 : count;
    for (int i = 0; i < sectors; ++i) {
        const int from = sharp[i], faces = i + 1 < count ? sharp[i + 1] - from : sharp[0] + at.edges - from;
        limit.sectors.push_back(sharp_sector(scheme, at, corner, from, faces));
    }
    return limit;
}

}  // namespace

const RingLimit& ring_limit(SchemeKind scheme, const RingShape& shape) {
    if (shape.faces < 1) throw std::invalid_argument("a ring has at least one face");
    if (!shape.sharp.empty() && static_cast<int>(shape.sharp.size()) != shape.edge_count())
        throw std::invalid_argument("a ring has one sharpness flag per edge");
    // One cache per thread needs no lock.
    thread_local std::array<std::map<RingShape, RingLimit>, 2> cache;
    std::map<RingShape, RingLimit>& known = cache[static_cast<std::size_t>(scheme)];
    const auto at = known.find(shape);
    return at != known.end() ? at->second : known.try_emplace(shape, compute(scheme, shape)).first->second;
}

glm::dvec3 limit_normal(SchemeKind scheme, const RingShape& shape, const RingLimit& limit,
                        std::span<const glm::dvec3> ring) {
    // A cross product this much shorter than the product of its factors' sums of magnitudes is rounding error, not a
    // direction.
    constexpr double k_parallel = 1e-12;
    const auto apply = [&](const std::vector<double>& weights, double& size) {
        // Differences from the centre: the weights sum to zero, and a far origin must not cost digits.
        glm::dvec3 t(0);
        for (std::size_t i = 1; i < weights.size(); ++i) {
            const glm::dvec3 term = weights[i] * (ring[i] - ring[0]);
            t += term;
            size += std::abs(term.x) + std::abs(term.y) + std::abs(term.z);
        }
        return t;
    };
    glm::dvec3 mean(0);
    bool degenerate = false;
    for (const RingLimit::Sector& s : limit.sectors) {
        double size_a = 0, size_b = 0;
        const glm::dvec3 a = apply(s.tangent1, size_a), b = apply(s.tangent2, size_b), n = glm::cross(a, b);
        const double length = glm::length(n);
        if (!(length > k_parallel * size_a * size_b)) {
            degenerate = true;
            continue;
        }
        mean += n / length;
    }
    double length = glm::length(mean);
    if (length > k_parallel && !(degenerate && limit.sectors.size() == 1)) return mean / length;

    const RingLayout at(scheme, shape);
    mean = glm::dvec3(0);
    for (int i = 0; i < shape.faces; ++i) {
        const glm::dvec3 a = ring[at.edge(i)] - ring[0], b = ring[at.edge((i + 1) % at.edges)] - ring[0];
        mean += at.quads ? glm::cross(ring[at.face(i)] - ring[0], b - a) : glm::cross(a, b);
    }
    length = glm::length(mean);
    double scale = 0;
    for (const glm::dvec3& p : ring) scale = std::max(scale, glm::dot(p - ring[0], p - ring[0]));
    return length > k_parallel * scale ? mean / length : glm::dvec3(0);
}

}  // namespace tetrakis
