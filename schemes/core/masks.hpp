#pragma once

#include "fan_labels.hpp"

#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

namespace tetrakis {

/// Weights of one rotation-symmetric rule on the one-ring of a vertex; for valence n, vertex + n (edge + face) = 1.
struct RingMask {
    double vertex = 0;  ///< the vertex itself
    double edge = 0;    ///< each edge neighbour
    double face = 0;    ///< each opposite corner (quads) or new face point, as the rule says

    friend RingMask operator+(RingMask a, const RingMask& b) {
        return {a.vertex + b.vertex, a.edge + b.edge, a.face + b.face};
    }
    friend RingMask operator*(double w, const RingMask& a) { return {w * a.vertex, w * a.edge, w * a.face}; }
    friend bool operator==(const RingMask&, const RingMask&) = default;
};

/// Weights along a crease or boundary: the vertex itself and each of its two neighbours on the crease.
struct CreaseMask {
    double vertex = 0, neighbour = 0;
};

/// Crease and boundary rules that all schemes here share: the cubic B-spline's. Source: Hoppe et al. 1994 (Loop),
/// DeRose, Kass, Truong 1998 (Catmull-Clark).
inline constexpr CreaseMask k_crease_vertex_mask{3.0 / 4, 1.0 / 8};
inline constexpr CreaseMask k_crease_limit_mask{2.0 / 3, 1.0 / 6};

/// Limit and tangent masks as formulas, for the schemes and shapes where there are any; an empty mask has no formula.
/// Limit weights sum to one, tangent weights to zero; the tangents' scale is free, and at a boundary the first one is
/// along it.
struct ClosedMasks {
    using Mask = std::vector<std::pair<FanLabel, double>>;
    Mask limit{}, tangent1{}, tangent2{};
};

/// Masks of a vertex on a crease or boundary that follows the first rays of sectors 0 and `last`: the limit, and the
/// tangent along the crease.
inline ClosedMasks crease_closed_masks(int last) {
    const FanLabel ahead{0, 1, 0}, behind{last, 1, 0};
    return {.limit = {{{}, k_crease_limit_mask.vertex},
                      {ahead, k_crease_limit_mask.neighbour},
                      {behind, k_crease_limit_mask.neighbour}},
            .tangent1 = {{ahead, 1}, {behind, -1}}};
}

/// Masks of a corner of K faces, a fixed point. Tangents are the two sharp edges, if they span the tangent plane.
inline ClosedMasks corner_closed_masks(int K, bool edges_span_the_plane) {
    if (!edges_span_the_plane) return {.limit = {{{}, 1}}};
    return {.limit = {{{}, 1}}, .tangent1 = {{{}, -1}, {{0, 1, 0}, 1}}, .tangent2 = {{{}, -1}, {{K, 1, 0}, 1}}};
}

/// Weights across a crease or boundary in the sine mode of the K faces on this side, theta = pi / K: of the vertex, of
/// its neighbours on the crease, and of ring edge i, times sin(i theta).
struct AcrossMask {
    double vertex = -2, end = 1, inner = 0;  ///< of a single face

    /// For rules that are the crease rules along it. The columns of the ends (weight b) and of the vertex (weight c) of
    /// the ring matrix read (lambda - 1/2) b - c / 8 = end_column, -b + (lambda - 3/4) c = vertex_column.
    static AcrossMask solve(double lambda, double end_column, double vertex_column, double inner) {
        const double determinant = (lambda - 0.5) * (lambda - 0.75) - 0.125;
        return {.vertex = ((lambda - 0.5) * vertex_column + end_column) / determinant,
                .end = (end_column * (lambda - 0.75) + vertex_column / 8) / determinant,
                .inner = inner};
    }
    ClosedMasks::Mask mask(int K) const {
        ClosedMasks::Mask result{{{}, vertex}};
        for (int i = 0; i <= K; ++i)
            result.emplace_back(FanLabel{i, 1, 0}, i == 0 || i == K ? end : inner * std::sin(i * std::numbers::pi / K));
        return result;
    }
};

/// Masks of a vertex of n triangles or quads, on its neighbours and opposite corners. Tangents are the cosines and
/// sines of their angles.
/// @param edge, face  their weights in the tangents; `face` is for both edges beside it, and 0 for triangles
inline ClosedMasks ring_closed_masks(int n, const RingMask& limit, double edge = 1, double face = 0) {
    ClosedMasks masks{.limit = {{{}, limit.vertex}}};
    for (int i = 0; i < n; ++i) {
        const double angle = 2 * std::numbers::pi * i / n, next = 2 * std::numbers::pi * (i + 1) / n;
        const auto add = [&](int b, double position, double x, double y) {
            masks.limit.emplace_back(FanLabel{i, 1, b}, position);
            if (n < 3) return;
            masks.tangent1.emplace_back(FanLabel{i, 1, b}, x);
            masks.tangent2.emplace_back(FanLabel{i, 1, b}, y);
        };
        add(0, limit.edge, edge * std::cos(angle), edge * std::sin(angle));
        if (face != 0)
            add(1, limit.face, face * (std::cos(angle) + std::cos(next)), face * (std::sin(angle) + std::sin(next)));
    }
    return masks;
}

}  // namespace tetrakis
