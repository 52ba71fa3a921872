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
    RootLayout(const MeshLevel& base, int levels) : base_(&base), segments_(1u << levels), inner_(segments_ - 1) {
        if (quads()) {
            const std::uint32_t last = inner_ - 1;
            set_side(0, 0, 1, 0);
            set_side(1, last, inner_, 0);
            set_side(2, inner_ * inner_ - 1, ~0u, 0);
            set_side(3, last * inner_, 0u - inner_, 0);
        } else {
            // Rows get shorter by one: so do the steps across them.
            set_side(0, 0, 1, 0);
            set_side(1, inner_ - 2, inner_ - 2, ~0u);
            set_side(2, root_points() - 1, 0u - 2, ~0u);
        }
    }

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
        return (side & 1) == 0 ? begin + j - 1 : begin + inner_ - j;
    }
    std::uint32_t first_along(std::uint32_t h) const {
        if (inner_ == 0) return base_->origin[base_->next(h)];
        const std::uint32_t side = base_->edge_side[h];
        return edge_begin(side >> 1) + ((side & 1) == 0 ? 0 : inner_ - 1);
    }
    std::uint32_t last_along(std::uint32_t h) const {
        if (inner_ == 0) return base_->origin[h];
        const std::uint32_t side = base_->edge_side[h];
        return edge_begin(side >> 1) + ((side & 1) == 0 ? inner_ - 1 : 0);
    }
    /// Quads: the lattice point one step along x and y from where half-edge h starts.
    std::uint32_t diagonal(std::uint32_t h) const {
        return inner_ == 0 ? base_->origin[h ^ 2u] : root_begin(h / 4) + beside_begin_[h & 3u];
    }

    /// Vertex numbers begin, begin + step, ...; the step itself grows by `turn`. Modulo 2^32, so they also go back.
    struct Run {
        std::uint32_t begin, step, turn;
        /// Its first `count` >= 1 vertices, last first.
        Run reversed(std::uint32_t count) const {
            const std::uint64_t last = count - 1;
            const auto turns = static_cast<std::uint32_t>(last * (last == 0 ? 0 : last - 1) / 2);
            return {begin + static_cast<std::uint32_t>(last) * step + turns * turn,
                    0u - (step + static_cast<std::uint32_t>(last - 1) * turn), turn};
        }
    };
    /// The N - 1 inner vertices of side h, from where half-edge h starts; N > 1.
    Run inner_along(std::uint32_t h) const {
        const std::uint32_t side = base_->edge_side[h], begin = edge_begin(side >> 1);
        return (side & 1) == 0 ? Run{begin, 1, 0} : Run{begin + inner_ - 1, ~0u, 0};
    }
    /// The vertices inside h's root one step off side h, in its direction: N - 1; triangles: N - 2.
    Run inner_beside(std::uint32_t h) const {
        if (quads()) return {root_begin(h / 4) + beside_begin_[h & 3u], beside_step_[h & 3u], 0};
        return {root_begin(h / 3) + beside_begin_[h % 3], beside_step_[h % 3], beside_turn_[h % 3]};
    }
    /// Vertex j of the lattice line one step off side h, its ends included: 0 <= j <= N; triangles: 0 <= j < N.
    std::uint32_t beside(std::uint32_t h, std::uint32_t j) const {
        if (j == 0) return last_along(base_->prev(h));
        if (j == (quads() ? segments_ : inner_)) return first_along(base_->next(h));
        const Run run = inner_beside(h);
        // j (j - 1) / 2 turns of the step lie before the next vertex.
        return run.begin + (j - 1) * run.step +
               static_cast<std::uint32_t>(std::uint64_t{j - 1} * (j < 2 ? 0 : j - 2) / 2) * run.turn;
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
    void set_side(int side, std::uint32_t begin, std::uint32_t step, std::uint32_t turn) {
        beside_begin_[side] = begin;
        beside_step_[side] = step;
        beside_turn_[side] = turn;
    }

    const MeshLevel* base_;
    std::uint32_t segments_, inner_;
    std::uint32_t beside_begin_[4], beside_step_[4], beside_turn_[4];
};

}  // namespace tetrakis::detail
