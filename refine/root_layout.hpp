#pragma once

#include "tetrakis/refine/mesh_level.hpp"

#include <cstdint>

namespace tetrakis::detail {

/// Where the points of one level of structured refinement are: corners | inner points of edges | inner points of roots.
/// The roots are the faces of a base level of quads (or of triangles), each side cut into `segments` = N pieces:
///
/// * corners: the base level's vertices;
/// * edge e: its N - 1 inner points, along its first half-edge;
/// * root f: the lattice points (x, y) off its sides, row by row (y), with x from corner 0 to corner 1 and y from
///   corner 0 to the last corner: 0 < x, y < N for quads; 0 < x, y and x + y < N for triangles.
///
/// Numbers are found from this by arithmetic, and a vertex has one number for all roots that share it.
class RootLayout {
  public:
    RootLayout(const MeshLevel& base, int levels) : base_(&base), segments_(1u << levels), inner_(segments_ - 1) {}

    const MeshLevel& base() const { return *base_; }
    bool quads() const { return base_->face_size == 4; }
    std::uint32_t segments() const { return segments_; }
    std::uint32_t edge_points() const { return inner_; }
    std::uint32_t root_points() const {
        return quads() ? inner_ * inner_ : static_cast<std::uint32_t>(std::uint64_t{inner_} * (inner_ - 1) / 2);
    }
    std::uint32_t edge_begin(std::uint32_t e) const { return base_->vertex_count + e * inner_; }
    std::uint32_t root_begin(std::uint32_t f) const {
        return base_->vertex_count + base_->edge_count * inner_ + f * root_points();
    }
    std::uint32_t vertex_count() const { return root_begin(base_->face_count); }

    /// Vertex j of side h, 0 <= j <= N, counted from where half-edge h starts.
    std::uint32_t along(std::uint32_t h, std::uint32_t j) const {
        if (j == 0) return base_->origin[h];
        if (j == segments_) return base_->origin[base_->next(h)];
        const std::uint32_t side = base_->edge_side[h], begin = edge_begin(side >> 1);
        return (side & 1) == 0 ? begin + j - 1 : begin + segments_ - 1 - j;
    }
    /// Quads: vertex j of the lattice line beside side h, one step into the root, 0 <= j <= N.
    std::uint32_t beside_quad(std::uint32_t h, std::uint32_t j) const {
        if (j == 0) return along(base_->prev(h), segments_ - 1);
        if (j == segments_) return along(base_->next(h), 1);
        if (segments_ == 2) return root_begin(h / 4);
        const std::uint32_t begin = root_begin(h / 4), last = inner_ - 1;
        switch (h & 3u) {
            case 0:
                return begin + j - 1;
            case 1:
                return begin + (j - 1) * inner_ + last;
            case 2:
                return begin + last * inner_ + last - (j - 1);
            default:
                return begin + (last - (j - 1)) * inner_;
        }
    }
    /// Triangles: the same; this line has one vertex less, 0 <= j < N.
    std::uint32_t beside_triangle(std::uint32_t h, std::uint32_t j) const {
        if (j == 0) return along(base_->prev(h), inner_);
        if (j == inner_) return along(base_->next(h), 1);
        const std::uint32_t f = h / 3;
        switch (h % 3) {
            case 0:
                return root_begin(f) + triangle_point(j, 1);
            case 1:
                return root_begin(f) + triangle_point(inner_ - j, j);
            default:
                return root_begin(f) + triangle_point(1, inner_ - j);
        }
    }
    /// Place of the inner lattice point (x, y) among a triangle's own.
    std::uint32_t triangle_point(std::uint32_t x, std::uint32_t y) const {
        return (y - 1) * inner_ - (y - 1) * y / 2 + x - 1;
    }
    /// Lattice point (x, y) of root f, on its sides or inside.
    std::uint32_t at(std::uint32_t f, std::uint32_t x, std::uint32_t y) const {
        if (quads()) {
            if (y == 0) return along(4 * f, x);
            if (x == segments_) return along(4 * f + 1, y);
            if (y == segments_) return along(4 * f + 2, segments_ - x);
            if (x == 0) return along(4 * f + 3, segments_ - y);
            return root_begin(f) + (y - 1) * inner_ + x - 1;
        }
        if (y == 0) return along(3 * f, x);
        if (x + y == segments_) return along(3 * f + 1, y);
        if (x == 0) return along(3 * f + 2, segments_ - y);
        return root_begin(f) + triangle_point(x, y);
    }

  private:
    const MeshLevel* base_;
    std::uint32_t segments_, inner_;
};

}  // namespace tetrakis::detail
