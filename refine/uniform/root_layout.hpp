#pragma once

#include "mesh_level.hpp"

#include <cstdint>

namespace tetrakis::detail {

/// Calls visit(i, number(i)) for each i < count of a line of RootLayout, whose inner numbers have one second
/// difference.
template <class Number, class Visit>
void for_each_on_line(std::uint32_t count, const Number& number, const Visit& visit) {
    if (count < 6) {
        for (std::uint32_t i = 0; i < count; ++i) visit(i, number(i));
        return;
    }
    visit(0, number(0));
    std::uint32_t v = number(1), step = number(2) - v;
    const std::uint32_t turn = number(3) - number(2) - step;
    for (std::uint32_t i = 1; i + 1 < count; ++i) {
        visit(i, v);
        v += step;
        step += turn;
    }
    visit(count - 1, number(count - 1));
}

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
        : base_(&base), segments_(segments), inner_(segments - 1) {}

    const MeshLevel& base() const { return *base_; }
    bool quads() const { return base_->face_size == 4; }
    std::uint32_t segments() const { return segments_; }
    std::uint32_t root_points() const {
        return quads() ? inner_ * inner_ : static_cast<std::uint32_t>(std::uint64_t{inner_} * (inner_ - 1) / 2);
    }
    std::uint32_t edge_begin(std::uint32_t e) const { return base_->vertex_count + e * inner_; }
    std::uint32_t face_begin(std::uint32_t f) const { return edge_begin(base_->edge_count) + f * root_points(); }
    std::uint32_t vertex_count() const { return face_begin(base_->face_count); }
    std::uint64_t cell_count() const { return std::uint64_t{base_->face_count} * segments_ * segments_; }

    /// Vertex j of side h, 0 <= j <= N, counted from where half-edge h starts.
    std::uint32_t along(std::uint32_t h, std::uint32_t j) const {
        if (j == 0) return base_->origin[h];
        if (j == segments_) return base_->origin[base_->next(h)];
        const std::uint32_t side = base_->edge_side[h], begin = edge_begin(side >> 1);
        return (side & 1) == 0 ? begin + j - 1 : begin + inner_ - j;
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

  private:
    const MeshLevel* base_;
    std::uint32_t segments_, inner_;
};

}  // namespace tetrakis::detail
