#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

namespace tetrakis::detail {

/// Connectivity of a mesh of quads or of triangles as flat arrays. Half-edges are face corners in face order; what
/// arithmetic gives (next, prev, face) is not stored.
struct MeshLevel {
    static constexpr std::uint32_t none = 0xFFFF'FFFFu;

    std::uint32_t face_size = 4;  ///< 3 or 4
    std::uint32_t vertex_count = 0, edge_count = 0, face_count = 0;

    std::vector<std::uint32_t> origin;           ///< H
    std::vector<std::uint32_t> twin;             ///< H; none on the boundary
    std::vector<std::uint32_t> edge_side;        ///< H; 2 e, plus 1 when h is not the edge's first half-edge
    std::vector<std::uint32_t> edge_halfedge;    ///< E; the edge's first half-edge
    std::vector<std::uint32_t> vertex_halfedge;  ///< V; outgoing; at a boundary the one without twin; none if isolated

    std::uint32_t halfedge_count() const { return static_cast<std::uint32_t>(origin.size()); }
    std::uint32_t face_of(std::uint32_t h) const { return face_size == 4 ? h / 4 : h / 3; }
    std::uint32_t next(std::uint32_t h) const {
        if (face_size == 4) return (h & ~3u) | ((h + 1) & 3u);
        return h % 3 == 2 ? h - 2 : h + 1;
    }
    std::uint32_t prev(std::uint32_t h) const {
        if (face_size == 4) return (h & ~3u) | ((h + 3) & 3u);
        return h % 3 == 0 ? h + 2 : h - 1;
    }
    std::uint32_t first_halfedge(std::uint32_t face) const { return face * face_size; }
    std::uint32_t edge(std::uint32_t h) const { return edge_side[h] >> 1; }
    /// Calls visit(h) for the half-edges that leave a vertex, counter-clockwise. Returns whether they close.
    template <class Visit>
    bool for_each_around(std::uint32_t vertex, const Visit& visit) const {
        const std::uint32_t first = vertex_halfedge[vertex];
        std::uint32_t h = first;
        while (h != none) {
            visit(h);
            h = twin[prev(h)];
            if (h == first) return true;
        }
        return false;
    }
};

/// The points on a line of a lattice: both ends, and numbers between them that have one second difference (modulo
/// 2^32).
struct PointLine {
    std::uint32_t count, first, last;
    std::uint32_t second = 0, step = 0, turn = 0;  ///< the second point; the next less that; the second difference

    /// Calls visit(i, number) for the points i in [begin, end) that the line has.
    template <class Visit>
    void for_each(std::uint32_t begin, std::uint32_t end, const Visit& visit) const {
        if (begin == 0 && end > 0) visit(0, first);
        const std::uint32_t from = std::max(begin, 1u), to = std::min(end, count - 1), past = from - 1;
        std::uint32_t v = second + past * step + past * (past - 1) / 2 * turn, by = step + past * turn;
        for (std::uint32_t i = from; i < to; ++i) {
            visit(i, v);
            v += by;
            by += turn;
        }
        if (begin < count && end >= count && count > 1) visit(count - 1, last);
    }
};

/// Where the points of one level of structured refinement are: corners | inner points of edges | inner points of faces.
/// The faces are those of a base level, all quads or all triangles, each side cut into `segments` = N pieces:
///
/// * corners: the base level's vertices;
/// * edge e: its N - 1 inner points, along its first half-edge;
/// * face f, a root: the lattice points (x, y) off its sides, row by row (y), with x from corner 0 to corner 1 and y
///   from corner 0 to the last corner: 0 < x, y < N for quads; 0 < x, y and x + y < N for triangles.
///
/// So numbers are found by arithmetic, and a vertex has one number for all roots that share it.
class RootLayout {
  public:
    RootLayout(const MeshLevel& base, std::uint32_t segments)
        : base_(&base),
          segments_(segments),
          inner_(segments - 1),
          root_points_(static_cast<std::uint32_t>(quads() ? std::uint64_t{inner_} * inner_
                                                          : std::uint64_t{inner_} * (inner_ - 1) / 2)),
          faces_begin_(edge_begin(base.edge_count)) {}

    const MeshLevel& base() const { return *base_; }
    bool quads() const { return base_->face_size == 4; }
    std::uint32_t segments() const { return segments_; }
    std::uint32_t root_points() const { return root_points_; }
    std::uint32_t edge_begin(std::uint32_t e) const { return base_->vertex_count + e * inner_; }
    std::uint32_t face_begin(std::uint32_t f) const { return faces_begin_ + f * root_points_; }
    std::uint32_t vertex_count() const { return face_begin(base_->face_count); }
    std::uint64_t cell_count() const { return std::uint64_t{base_->face_count} * segments_ * segments_; }

    /// Vertex j of side h, 0 <= j <= N, counted from where half-edge h starts.
    std::uint32_t along(std::uint32_t h, std::uint32_t j) const {
        if (j == 0) return base_->origin[h];
        if (j == segments_) return base_->origin[base_->next(h)];
        return inside_side(h, j);
    }
    /// Lattice point (x, y) of face f, on its sides or inside.
    std::uint32_t at(std::uint32_t f, std::uint32_t x, std::uint32_t y) const {
        if (quads()) {
            const std::uint32_t h = 4 * f;
            if (y == 0) return along(h, x);
            if (x == segments_) return along(h + 1, y);
            if (y == segments_) return along(h + 2, segments_ - x);
            if (x == 0) return along(h + 3, segments_ - y);
            return face_begin(f) + (y - 1) * inner_ + x - 1;
        }
        const std::uint32_t h = 3 * f;
        if (y == 0) return along(h, x);
        if (x + y == segments_) return along(h + 1, y);
        if (x == 0) return along(h + 2, segments_ - y);
        return face_begin(f) + (y - 1) * inner_ - (y - 1) * y / 2 + x - 1;
    }

    /// Side h, which runs as h does.
    PointLine side(std::uint32_t h) const {
        const std::uint32_t edge = base_->edge_side[h];
        const bool forwards = (edge & 1) == 0;
        return {segments_ + 1, base_->origin[h], base_->origin[base_->next(h)],
                edge_begin(edge >> 1) + (forwards ? 0 : inner_ - 1), forwards ? 1 : -1u};
    }
    /// The line b away from it.
    PointLine line(std::uint32_t h, std::uint32_t b) const {
        if (b == 0) return side(h);
        const std::uint32_t n = segments_, sides = quads() ? 4 : 3, f = quads() ? h / 4 : h / 3, side = h - sides * f,
                            next = side + 1 == sides ? h - side : h + 1, prev = side == 0 ? h + sides - 1 : h - 1;
        PointLine line{quads() ? n + 1 : n + 1 - b, 0, 0};
        if (b == n) {
            const PointLine back = this->side(quads() ? h ^ 2 : next);  // of triangles a point
            return {line.count, back.last, back.first, back.second + (inner_ - 1) * back.step, 0 - back.step};
        }
        line.first = inside_side(prev, n - b);
        line.last = inside_side(next, b);
        const std::uint32_t inside = face_begin(f);
        const auto row = [&](std::uint32_t y) { return inside + (y - 1) * inner_ - (quads() ? 0 : (y - 1) * y / 2); };
        if (side == 0) {
            line.second = row(b);
            line.step = 1;
        } else if (quads()) {
            line.second = side == 1 ? row(1) + n - b - 1 : side == 2 ? row(n - b) + n - 2 : row(n - 1) + b - 1;
            line.step = side == 1 ? inner_ : side == 2 ? -1u : 0 - inner_;
        } else {
            line.second = side == 1 ? row(1) + n - b - 2 : row(n - 1 - b) + b - 1;
            line.step = side == 1 ? inner_ - 2 : 0 - (b + 1);
            line.turn = -1u;
        }
        return line;
    }

  private:
    /// Vertex j of side h, 0 < j < N.
    std::uint32_t inside_side(std::uint32_t h, std::uint32_t j) const {
        const std::uint32_t side = base_->edge_side[h];
        return edge_begin(side >> 1) + ((side & 1) == 0 ? j - 1 : inner_ - j);
    }

    const MeshLevel* base_;
    std::uint32_t segments_, inner_, root_points_, faces_begin_;
};

}  // namespace tetrakis::detail
