#pragma once

#include "../core/scheme_table.hpp"

#include <glm/vec3.hpp>

#include <compare>
#include <cstdint>
#include <span>
#include <vector>

namespace tetrakis {

/// The tagged one-ring of a vertex: K faces (quads for Catmull-Clark, triangles for Loop) and the edges e_0, e_1, ...
/// counter-clockwise as seen from outside. The tags are stationary: each edge is smooth or sharp on all levels.
struct RingShape {
    int faces = 0;          ///< K >= 1
    bool boundary = false;  ///< K + 1 edges, the first and last of them on the boundary; else K edges
    bool corner = false;    ///< the vertex itself is (infinitely) sharp
    std::vector<std::uint8_t>
        sharp{};  ///< per edge: 0 if smooth; boundary edges always count as sharp. May be empty: all 0

    int edge_count() const { return faces + (boundary ? 1 : 0); }
    friend auto operator<=>(const RingShape&, const RingShape&) = default;
};

/// Limit position and tangents of a vertex as weights on its ring. Weights are in the order [centre, e_0, f_0, e_1,
/// f_1, ...] for Catmull-Clark (f_i the corner opposite the centre, between e_i and e_(i+1); a boundary ends with e_K)
/// and [centre, e_0, e_1, ...] for Loop. Position weights sum to one, tangent weights to zero; the tangents' scale is
/// free.
///
/// In every sector, tangent1 x tangent2 points outward for counter-clockwise faces.
struct RingLimit {
    /// The faces between two consecutive sharp edges; the whole ring where there are fewer than two.
    struct Sector {
        int first_edge = 0, faces = 0;
        std::vector<double> tangent1{}, tangent2{};
    };
    std::vector<double> position{};
    std::vector<Sector> sectors{};  ///< counter-clockwise, from the first sharp edge

    const std::vector<double>& tangent1() const { return sectors.front().tangent1; }
    const std::vector<double>& tangent2() const { return sectors.front().tangent2; }
};

/// Limit data of a vertex, computed once per shape and thread; the reference stays valid until the thread ends.
///
/// Smooth vertices, creases and boundaries have the closed forms of the scheme's plain rules; darts take the left
/// eigenvectors of their ring matrix. At a crease or boundary, tangent1 is along it and tangent2 across (the sine mode
/// of the sector).
///
/// Cases without a tangent plane, and the tangents that are chosen there:
/// * a sector of more than 3 quads or 5 triangles beside a crease or boundary (plain rules: modes across it decay more
///   slowly than the mode along it). The tangents are the mode along and the first mode across, as for fewer faces;
/// * a sector of K quads (K > 1) or triangles (K > 2) at a corner: the sums of the ring's edges, weighted by cos and
///   sin (i pi / K), which span a fitted plane. With fewer faces the two sharp edges span the tangent plane;
/// * an interior vertex of valence 2: the differences of opposite points of its ring (Loop: tangent2 is zero).
///
/// @throws std::invalid_argument  faces < 1, or `sharp` has the wrong size
const RingLimit& ring_limit(SchemeKind scheme, const RingShape& shape);

/// Unit limit normal of a ring of points, in the order of the weights: the mean of the sectors' unit normals. Where the
/// tangents vanish or are parallel (points on a line, valence 2) the mean normal of the ring's faces; zero where that
/// vanishes too.
glm::dvec3 limit_normal(SchemeKind scheme, const RingShape& shape, const RingLimit& limit,
                        std::span<const glm::dvec3> ring);

}  // namespace tetrakis
