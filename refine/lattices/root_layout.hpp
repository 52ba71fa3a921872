#pragma once

#include "../../schemes/core/rule_mesh.hpp"

#include <cstdint>

namespace tetrakis::detail {

/// The next half-edge of a root, by arithmetic: reading it from the mesh takes a fifth of a coarse level's time.
constexpr std::uint32_t next_side(bool quads, std::uint32_t h) {
    if (quads) return (h & ~3u) | ((h + 1) & 3u);
    return h % 3 == 2 ? h - 2 : h + 1;
}

/// Where the points of one level of structured refinement are: corners | inner points of edges | inner points of faces.
/// The faces are those of a base level, all quads or all triangles, each side cut into `segments` = N pieces:
///
/// * corners: the base level's vertices;
/// * edge e: its N - 1 inner points, along its first half-edge;
/// * face f, a root: the lattice points (x, y) off its sides, row by row (y), with x from corner 0 to corner 1 and y
///   from corner 0 to the last corner: 0 < x, y < N for quads; 0 < x, y and x + y < N for triangles.
///
/// So numbers are computed, never searched for, and all roots that share a vertex give it the same number.
class RootLayout {
  public:
    RootLayout(const RuleMesh& base, std::uint32_t segments)
        : base_(&base),
          quads_(base.face_size(0) == 4),
          segments_(segments),
          inner_(segments - 1),
          root_points_(static_cast<std::uint32_t>(quads_ ? std::uint64_t{inner_} * inner_
                                                         : std::uint64_t{inner_} * (inner_ - 1) / 2)),
          vertices_(base.vertex_count()),
          faces_begin_(edge_begin(base.edge_count())) {}

    std::uint32_t segments() const { return segments_; }
    std::uint32_t root_points() const { return root_points_; }
    std::uint32_t edge_begin(std::uint32_t e) const { return vertices_ + e * inner_; }
    std::uint32_t face_begin(std::uint32_t f) const { return faces_begin_ + f * root_points_; }
    std::uint32_t vertex_count() const { return face_begin(base_->face_count()); }
    std::uint64_t cell_count() const { return static_cast<std::uint64_t>(base_->face_count()) * segments_ * segments_; }

    /// Vertex j of side h, 0 <= j <= N, counted from where half-edge h starts.
    std::uint32_t along(std::uint32_t h, std::uint32_t j) const {
        if (j == 0) return base_->origin(h);
        if (j == segments_) return base_->origin(next_side(quads_, h));
        return edge_begin(base_->edge(h)) + (base_->leads(h) ? j - 1 : inner_ - j);
    }
    /// Calls visit(j, vertex j) for all vertices of side h but the last, in their order.
    template <class Visit>
    void for_each_along(std::uint32_t h, const Visit& visit) const {
        visit(0, base_->origin(h));
        const std::uint32_t ahead = base_->leads(h) ? 1 : -1u;
        std::uint32_t v = edge_begin(base_->edge(h)) + (ahead == 1 ? 0 : inner_ - 1);
        for (std::uint32_t j = 1; j < segments_; ++j, v += ahead) visit(j, v);
    }
    /// Lattice point (x, y) of face f, on its sides or inside.
    std::uint32_t at(std::uint32_t f, std::uint32_t x, std::uint32_t y) const {
        if (quads_) {
            const std::uint32_t h = 4 * f;
            if (y == 0) return along(h, x);
            if (x == segments_) return along(h + 1, y);
            if (y == segments_) return along(h + 2, segments_ - x);
            if (x == 0) return along(h + 3, segments_ - y);
            return inside(f, x, y);
        }
        const std::uint32_t h = 3 * f;
        if (y == 0) return along(h, x);
        if (x + y == segments_) return along(h + 1, y);
        if (x == 0) return along(h + 2, segments_ - y);
        return inside(f, x, y);
    }
    /// The number of lattice point (x, y) inside face f, not on its sides.
    std::uint32_t inside(std::uint32_t f, std::uint32_t x, std::uint32_t y) const {
        return face_begin(f) + (y - 1) * inner_ - (quads_ ? 0 : (y - 1) * y / 2) + x - 1;
    }

  private:
    const RuleMesh* base_;
    bool quads_;
    std::uint32_t segments_, inner_, root_points_, vertices_, faces_begin_;
};

}  // namespace tetrakis::detail
