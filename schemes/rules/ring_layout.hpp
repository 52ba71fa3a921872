#pragma once

#include "ring_limit.hpp"

namespace tetrakis::detail {

/// Where the ring's points are in a row of weights.
struct RingLayout {
    bool quads;
    int edges, faces;

    RingLayout(SchemeKind scheme, const RingShape& shape)
        : quads(scheme == SchemeKind::catmull_clark), edges(shape.edge_count()), faces(shape.faces) {}

    int size() const { return 1 + edges + (quads ? faces : 0); }
    int edge(int i) const { return quads ? 1 + 2 * i : 1 + i; }
    int face(int i) const { return 2 + 2 * i; }

    bool is_sharp(const RingShape& shape, int i) const {
        return (shape.boundary && (i == 0 || i == edges - 1)) || (!shape.sharp.empty() && shape.sharp[i] != 0);
    }
    std::vector<int> sharp_edges(const RingShape& shape) const {
        std::vector<int> result;
        for (int i = 0; i < edges; ++i)
            if (is_sharp(shape, i)) result.push_back(i);
        return result;
    }
};

/// Limit of a dart: an interior vertex, no corner, whose edge 0 alone is sharp. Left eigenvectors of the ring matrix.
RingLimit dart_limit(SchemeKind scheme, int valence);

}  // namespace tetrakis::detail
