#pragma once

#include "../core/scheme_table.hpp"

#include <glm/vec3.hpp>

#include <compare>
#include <cstdint>
#include <span>
#include <vector>

namespace tetrakis {

/// What surrounds a vertex, as far as its rules go: K faces (quads for Catmull-Clark, triangles for Loop) and the edges
/// e_0, e_1, ... counter-clockwise as seen from outside. Stationary: each edge is smooth or sharp for ever.
struct RingShape {
    int faces = 0;          ///< K >= 1
    bool boundary = false;  ///< K + 1 edges, the first and last of them on the boundary; else K edges
    bool corner = false;    ///< the vertex itself is (infinitely) sharp
    std::vector<std::uint8_t>
        sharp{};  ///< per edge; at a boundary the ends count as sharp whatever they say. May be empty

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
/// Smooth vertices, creases and boundaries have closed forms, those of the scheme's plain rules; darts take the left
/// eigenvectors of their ring matrix. A crease or boundary: tangent1 along it, tangent2 across (the sine mode of the
/// sector).
///
/// No tangent plane, and what the tangents are then, by choice:
/// * a sector beside a crease or boundary with more than 3 quads or 5 triangles: the surface has none there (plain
///   rules; its across modes are slower than the one along). Along and first across, as for fewer faces;
/// * a sector of K quads (K > 1) or triangles (K > 2) at a corner: the ring's edges weighed by cos and sin (i pi / K),
///   i.e. the plane that fits them. With fewer faces the two sharp edges span the tangent plane;
/// * an interior vertex of valence 2: its two differences across (Loop: one of them is zero, the ring has no other).
///
/// @throws std::invalid_argument  faces < 1, or `sharp` has the wrong size
const RingLimit& ring_limit(SchemeKind scheme, const RingShape& shape);

/// Unit limit normal of a ring of points, in the order of the weights: the mean of the sectors' unit normals. Where the
/// tangents vanish or are parallel (points on a line, valence 2) the mean normal of the ring's faces; zero where that
/// vanishes too.
glm::dvec3 limit_normal(SchemeKind scheme, const RingShape& shape, const RingLimit& limit,
                        std::span<const glm::dvec3> ring);

}  // namespace tetrakis
