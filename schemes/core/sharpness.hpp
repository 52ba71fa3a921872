#pragma once

#include <limits>
#include <span>

namespace tetrakis {

/// The rule that a vertex follows, by its sharpness and its number of sharp edges. Source: Hoppe et al. 1994; DeRose,
/// Kass, Truong 1998, section 3.
enum class VertexRule {
    smooth,  ///< no sharp edge
    dart,    ///< one; refined by the smooth rule
    crease,  ///< two
    corner,  ///< three or more, or the vertex itself is sharp
};

/// Sharpness > 0, infinity included.
inline bool is_sharp(float sharpness) { return sharpness > 0.0f; }
/// Sharp now, but not for ever.
inline bool is_semi_sharp(float sharpness) {
    return sharpness > 0.0f && sharpness < std::numeric_limits<float>::infinity();
}

/// @param edge_sharpness  of the edges around the vertex, in any order; boundary edges are infinitely sharp
VertexRule vertex_rule(std::span<const float> edge_sharpness, float vertex_sharpness);

/// Sharpness one level further down, for vertices and (uniform creasing) edges: infinity stays, else max(s - 1, 0).
float child_sharpness(float sharpness);

/// Chaikin creasing: sharpness of the half of an edge at one of its end vertices, max(3/4 s + 1/4 m - 1, 0). m is the
/// mean sharpness of the other semi-sharp edges there, or s if there are none. Infinite sharpness stays, and is not in
/// m. Source: DeRose, Kass, Truong 1998, section 3, in the order of single-precision operations that the results of
/// OpenSubdiv 3.5 show.
/// @param sharpness     the edge's own
/// @param edges_at_end  sharpness of all edges at that end vertex, the edge itself included, counter-clockwise from the
///                      vertex' first edge (the order only rounds)
float child_sharpness_chaikin(float sharpness, std::span<const float> edges_at_end);

/// A vertex rule as a mixture of three: weight `smooth` for the smooth mask, `corner` for keeping the vertex,
/// `crease` for the crease mask along the ring's edges a and b. The three weights sum to one.
/// There is never more than one crease: a child's sharp edges are some of its parent's.
struct VertexBlend {
    double smooth = 1, corner = 0;
    struct Crease {
        double weight = 0;
        int a = -1, b = -1;  ///< positions of the two sharp edges in the spans given, a < b
    } crease{};
};

/// The rule that moves a vertex from one level to the next. Where the rule changes between parent and child, the two
/// are blended: w parent + (1 - w) child, w = min(1, mean of the sharpnesses that vanish); the behaviour of
/// OpenSubdiv 3.5.
/// @param edge_sharpness, vertex_sharpness              around the vertex, at the parent's level
/// @param child_edge_sharpness, child_vertex_sharpness  the same one level further down, at this vertex' end of each
/// edge
VertexBlend vertex_blend(std::span<const float> edge_sharpness, float vertex_sharpness,
                         std::span<const float> child_edge_sharpness, float child_vertex_sharpness);

/// Weight w of the crease mask (the midpoint) in the rule of the vertex on an edge; the smooth mask has weight 1 - w.
/// If a half of the edge becomes smooth, w is the sharpness. Chaikin creasing can smooth a half of an edge with a
/// sharpness between 1 and 4/3; then w > 1, as in OpenSubdiv 3.5 (tested against it).
/// @param sharpness          of the edge
/// @param child_a, child_b   of its halves; when both are sharp the edge is still a full crease, w = 1
double edge_crease_weight(float sharpness, float child_a, float child_b);

}  // namespace tetrakis
