#include "catmull_clark.hpp"
#include "loop.hpp"
#include "ring_layout.hpp"

namespace tetrakis {

std::vector<double> ring_matrix(SchemeKind scheme, const RingShape& shape) {
    const detail::RingLayout at(scheme, shape);
    const int n = at.edges, faces = shape.faces, size = at.size();
    const bool quads = scheme == SchemeKind::catmull_clark;
    std::vector<double> matrix(static_cast<std::size_t>(size) * size, 0.0);
    const auto add = [&](int row, int column, double w) { matrix[static_cast<std::size_t>(row) * size + column] += w; };

    const std::vector<int> sharp = at.sharp_edges(shape);
    if (shape.corner || sharp.size() > 2) {
        add(0, 0, 1);
    } else if (sharp.size() == 2) {
        add(0, 0, k_crease_vertex_mask.vertex);
        for (const int i : sharp) add(0, at.edge(i), k_crease_vertex_mask.neighbour);
    } else {
        const RingMask mask = quads ? CatmullClark::vertex_mask_quads(n) : Loop::vertex_mask(n);
        add(0, 0, mask.vertex);
        for (int i = 0; i < n; ++i) add(0, at.edge(i), mask.edge);
        for (int i = 0; quads && i < faces; ++i) add(0, at.face(i), mask.face);
    }
    for (int i = 0; i < n; ++i) {
        const int row = at.edge(i);
        if (at.is_sharp(shape, i)) {
            add(row, 0, 0.5);
            add(row, row, 0.5);
            continue;
        }
        const double end = quads ? CatmullClark::edge_end_quads : Loop::edge_end;
        const double side = quads ? CatmullClark::edge_side_quads : Loop::edge_opposite;
        add(row, 0, end);
        add(row, row, end);
        // A smooth edge has a face on each side, so both neighbours exist.
        add(row, at.edge((i + n - 1) % n), side);
        add(row, at.edge((i + 1) % n), side);
        if (quads) {
            add(row, at.face((i + faces - 1) % faces), side);
            add(row, at.face(i), side);
        }
    }
    for (int i = 0; quads && i < faces; ++i) {
        const int row = at.face(i);
        for (const int column : {0, at.edge(i), at.edge((i + 1) % n), row}) add(row, column, 0.25);
    }
    return matrix;
}

}  // namespace tetrakis
