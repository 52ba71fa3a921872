#pragma once

#include "mesh_level.hpp"

#include <cstdint>

namespace tetrakis::detail {

/// Vertex numbers begin, begin + step, ...; the step itself grows by `turn`. Modulo 2^32, so they also go back.
struct VertexRun {
    std::uint32_t begin, step, turn;
    /// Vertex i.
    std::uint32_t at(std::uint32_t i) const {
        const auto turns = static_cast<std::uint32_t>(std::uint64_t{i} * (i == 0 ? 0 : i - 1) / 2);
        return begin + i * step + turns * turn;
    }
    /// Its first `count` >= 1 vertices, last first.
    [[gnu::always_inline]] VertexRun reversed(std::uint32_t count) const {
        return {at(count - 1), 0u - (step + (count - 2) * turn), turn};
    }
};
/// A line of vertices: its first, a run of inner ones, its last.
struct VertexLine {
    std::uint32_t first;
    VertexRun inner;
    std::uint32_t last;
    /// Vertex i of `count`.
    std::uint32_t at(std::uint32_t i, std::uint32_t count) const {
        return i == 0 ? first : i + 1 == count ? last : inner.at(i - 1);
    }
    /// The same of `count` vertices in all, last first.
    [[gnu::always_inline]] VertexLine reversed(std::uint32_t count) const {
        return {last, count < 3 ? inner : inner.reversed(count - 2), first};
    }
};
/// A root by its lines, in the directions of RootRows; triangles have no top.
struct VertexRoot {
    std::uint32_t inner;  ///< its first inner vertex
    VertexLine bottom, top, left, right;
    std::uint32_t segments;
    /// Quads: lattice point (x, y), on its sides or inside.
    std::uint32_t at(std::uint32_t x, std::uint32_t y) const {
        const std::uint32_t n = segments;
        if (y == 0) return bottom.at(x, n + 1);
        if (y == n) return top.at(x, n + 1);
        return x == 0 ? left.at(y, n + 1) : x == n ? right.at(y, n + 1) : inner + (y - 1) * (n - 1) + x - 1;
    }
};

constexpr int k_any_size = -1;

/// Where the points of one level of structured refinement are: corners | inner points of edges | inner points of faces.
/// The faces are those of a base level, each side cut into `segments` = N pieces:
///
/// * corners: the base level's vertices;
/// * edge e: its N - 1 inner points, along its first half-edge;
/// * quad or triangle f, a root: the lattice points (x, y) off its sides, row by row (y), with x from corner 0 to
/// corner
///   1 and y from corner 0 to the last corner: 0 < x, y < N for quads; 0 < x, y and x + y < N for triangles;
/// * another face with k sides, among quads: k roots, one per corner, of M = N / 2 segments a side, with x along the
///   first half of the side that starts there and y back along the second half of the side before. Its centre; the
///   M - 1 inner points of each spoke, from the middle of a side to the centre, in the order of the sides; the
///   (M - 1)^2 lattice points off the sides of each root. N is 2 at least.
///
/// Both for quads and for such faces that is 1 + k (M - 1) M inner points, k M^2 cells. So numbers are found by
/// arithmetic, and a vertex has one number for all roots that share it.
///
/// @tparam Size  the base's face_size where the compiler is to know it: 4, 3, or 0 for others among quads
template <int Size>
class RootLayoutOf {
  public:
    /// @param segments  pieces of a side of the base's faces; even where these are of several sizes
    RootLayoutOf(const MeshLevel& base, std::uint32_t segments)
        : base_(&base), segments_(segments), inner_(segments - 1), half_(segments / 2) {
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
    // The base's connectivity.
    int face_size() const { return Size == k_any_size ? base_->face_size : Size; }
    std::uint32_t next(std::uint32_t h) const { return base_->next(h, face_size()); }
    std::uint32_t prev(std::uint32_t h) const { return base_->prev(h, face_size()); }
    std::uint32_t face_of(std::uint32_t h) const { return base_->face_of(h, face_size()); }
    std::uint32_t first_halfedge(std::uint32_t f) const { return base_->first_halfedge(f, face_size()); }
    std::uint32_t size_of(std::uint32_t f) const { return base_->size_of(f, face_size()); }
    /// Whether roots are quads; else they are triangles.
    bool quads() const { return face_size() != 3; }
    /// Whether there are faces of other sizes than the roots'.
    bool mixed() const { return face_size() == 0; }
    /// Whether face f is a root.
    bool is_root(std::uint32_t f) const { return !mixed() || size_of(f) == 4; }
    std::uint32_t segments() const { return segments_; }
    /// Segments of the roots at the corners of other faces: M.
    std::uint32_t corner_segments() const { return half_; }
    std::uint32_t edge_points() const { return inner_; }
    std::uint32_t root_points() const {
        return quads() ? inner_ * inner_ : static_cast<std::uint32_t>(std::uint64_t{inner_} * (inner_ - 1) / 2);
    }
    std::uint32_t edge_begin(std::uint32_t e) const { return base_->vertex_count + e * inner_; }
    std::uint32_t face_begin(std::uint32_t f) const { return face_begin(f, mixed() ? first_halfedge(f) : 0); }
    std::uint32_t vertex_count() const { return face_begin(base_->face_count, base_->halfedge_count()); }
    /// The first of face f's cells: of its N^2, or its k M^2, one root after the other.
    std::uint64_t cell_begin(std::uint32_t f) const {
        return mixed() ? std::uint64_t{first_halfedge(f)} * half_ * half_ : std::uint64_t{f} * segments_ * segments_;
    }

    std::uint64_t cell_count() const {
        return mixed() ? std::uint64_t{base_->halfedge_count()} * half_ * half_ : cell_begin(base_->face_count);
    }
    /// The base's face that a cell is in.
    std::uint32_t face_of_cell(std::uint32_t cell) const {
        return mixed() ? face_of(cell / (half_ * half_)) : cell / (segments_ * segments_);
    }

    // The parts of a face that is no root; i counts its sides.
    std::uint32_t centre(std::uint32_t f) const { return face_begin(f); }
    std::uint32_t spoke_begin(std::uint32_t f, std::uint32_t i) const { return face_begin(f) + 1 + i * (half_ - 1); }
    std::uint32_t corner_begin(std::uint32_t f, std::uint32_t i) const {
        return face_begin(f) + 1 + (half_ - 1) * (size_of(f) + i * (half_ - 1));
    }

    /// Vertex j of side h, 0 <= j <= N, counted from where half-edge h starts.
    std::uint32_t along(std::uint32_t h, std::uint32_t j) const {
        if (j == 0) return base_->origin[h];
        if (j == segments_) return base_->origin[next(h)];
        const std::uint32_t side = base_->edge_side[h], begin = edge_begin(side >> 1);
        return (side & 1) == 0 ? begin + j - 1 : begin + inner_ - j;
    }
    std::uint32_t first_along(std::uint32_t h) const {
        if (inner_ == 0) return base_->origin[next(h)];
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
        if (!mixed()) return inner_ == 0 ? base_->origin[h ^ 2u] : face_begin(h / 4, 0) + beside_begin_[h & 3u];
        const std::uint32_t f = face_of(h), i = h - first_halfedge(f);
        if (is_root(f)) return face_begin(f) + beside_begin_[i];
        return half_ == 1 ? centre(f) : corner_begin(f, i);
    }

    /// The N + 1 vertices of side h, from where half-edge h starts.
    [[gnu::always_inline]] VertexLine side(std::uint32_t h) const {
        const std::uint32_t from = base_->origin[h], to = base_->origin[next(h)];
        return {from, inner_ == 0 ? VertexRun{from, 0, 0} : inner_along(h), to};
    }
    /// The root that face f is.
    [[gnu::always_inline]] VertexRoot root(std::uint32_t f) const {
        const std::uint32_t n = segments_, h = first_halfedge(f);
        if (!quads()) return {face_begin(f), side(h), {}, side(h + 2).reversed(n + 1), side(h + 1), n};
        return {face_begin(f), side(h), side(h + 2).reversed(n + 1), side(h + 3).reversed(n + 1), side(h + 1), n};
    }
    /// The root at corner i of a face that is none.
    VertexRoot corner_root(std::uint32_t f, std::uint32_t i) const {
        const std::uint32_t begin = first_halfedge(f), h = begin + i, before = begin + previous_side(f, i);
        const VertexLine bottom{base_->origin[h], inner_along(h), along(h, half_)};
        const VertexLine left{base_->origin[h], inner_along(before).reversed(inner_), along(before, half_)};
        return {corner_begin(f, i), bottom, spoke(f, previous_side(f, i)), left, spoke(f, i), half_};
    }
    /// The M + 1 vertices from the middle of side i to the centre of a face that is no root.
    VertexLine spoke(std::uint32_t f, std::uint32_t i) const {
        const std::uint32_t middle = along(first_halfedge(f) + i, half_);
        return {middle, {half_ == 1 ? middle : spoke_begin(f, i), 1, 0}, centre(f)};
    }
    /// The neighbours of the centre: on spoke i, and across a cell of the root at corner i.
    std::uint32_t before_centre(std::uint32_t f, std::uint32_t i) const {
        return half_ == 1 ? along(first_halfedge(f) + i, 1) : spoke_begin(f, i) + half_ - 2;
    }
    std::uint32_t diagonal_to_centre(std::uint32_t f, std::uint32_t i) const {
        return half_ == 1 ? base_->origin[first_halfedge(f) + i] : corner_begin(f, i + 1) - 1;
    }
    /// The lines beside spoke i, in its direction: within the root at corner i, and within the next.
    VertexLine left_of_spoke(std::uint32_t f, std::uint32_t i) const {
        const std::uint32_t h = first_halfedge(f) + i, before = previous_side(f, i), m = half_ - 1;
        const std::uint32_t first = along(h, m);
        if (m == 0) return {first, {first, 0, 0}, along(first_halfedge(f) + before, half_)};
        return {first, {corner_begin(f, i) + m - 1, m, 0}, spoke_begin(f, before) + m - 1};
    }
    VertexLine right_of_spoke(std::uint32_t f, std::uint32_t i) const {
        const std::uint32_t h = first_halfedge(f) + i, after = next_side(f, i), m = half_ - 1;
        const std::uint32_t first = along(h, half_ + 1);
        if (m == 0) return {first, {first, 0, 0}, along(first_halfedge(f) + after, half_)};
        return {first, {corner_begin(f, after) + m * (m - 1), 1, 0}, spoke_begin(f, after) + m - 1};
    }

    /// The N - 1 inner vertices of side h, from where half-edge h starts; N > 1.
    [[gnu::always_inline]] VertexRun inner_along(std::uint32_t h) const {
        const std::uint32_t side = base_->edge_side[h], begin = edge_begin(side >> 1);
        return (side & 1) == 0 ? VertexRun{begin, 1, 0} : VertexRun{begin + inner_ - 1, ~0u, 0};
    }
    /// The lattice line one step off side h of a root, in its direction: N + 1 vertices; triangles: N.
    [[gnu::always_inline]] VertexLine beside(std::uint32_t h) const {
        const std::uint32_t last = quads() ? segments_ : inner_;
        const std::uint32_t from = last_along(prev(h)), to = last == 0 ? from : first_along(next(h));
        return {from, last > 1 ? inner_beside(h) : VertexRun{from, 0, 0}, to};
    }
    /// Vertex j of the lattice line one step off side h of any face, its ends included: 0 <= j <= N; triangles: j < N.
    std::uint32_t beside(std::uint32_t h, std::uint32_t j) const {
        if (j == 0) return last_along(prev(h));
        if (j == (quads() ? segments_ : inner_)) return first_along(next(h));
        const std::uint32_t f = face_of(h);
        if (is_root(f)) return inner_beside(h).at(j - 1);
        const std::uint32_t i = h - first_halfedge(f);
        if (j == half_) return half_ == 1 ? centre(f) : spoke_begin(f, i);
        if (j < half_) return corner_begin(f, i) + j - 1;
        return corner_begin(f, next_side(f, i)) + (segments_ - j - 1) * (half_ - 1);
    }
    /// Calls visit(j, vertex) for 0 <= j <= N of the line that beside(h, j) gives, in a face that is no root.
    template <class Visit>
    void for_each_beside(std::uint32_t h, Visit&& visit) const {
        const std::uint32_t f = face_of(h), i = h - first_halfedge(f), after = next_side(f, i), m = half_ - 1;
        const std::uint32_t here = corner_begin(f, i), there = corner_begin(f, after) + m * m;
        visit(0u, last_along(first_halfedge(f) + previous_side(f, i)));
        for (std::uint32_t j = 1; j < half_; ++j) visit(j, here + j - 1);
        visit(half_, m == 0 ? centre(f) : spoke_begin(f, i));
        for (std::uint32_t j = 1; j < half_; ++j) visit(half_ + j, there - j * m);
        visit(segments_, first_along(first_halfedge(f) + after));
    }
    /// Place of the inner lattice point (x, y) among a triangle's own.
    std::uint32_t triangle_point(std::uint32_t x, std::uint32_t y) const {
        return (y - 1) * inner_ - (y - 1) * y / 2 + x - 1;
    }
    /// Lattice point (x, y) of face f, a root, on its sides or inside.
    std::uint32_t at(std::uint32_t f, std::uint32_t x, std::uint32_t y) const {
        const std::uint32_t h = first_halfedge(f);
        if (quads()) {
            if (y == 0) return along(h, x);
            if (x == segments_) return along(h + 1, y);
            if (y == segments_) return along(h + 2, segments_ - x);
            if (x == 0) return along(h + 3, segments_ - y);
            return face_begin(f) + (y - 1) * inner_ + x - 1;
        }
        if (y == 0) return along(h, x);
        if (x + y == segments_) return along(h + 1, y);
        if (x == 0) return along(h + 2, segments_ - y);
        return face_begin(f) + triangle_point(x, y);
    }

    std::uint32_t next_side(std::uint32_t f, std::uint32_t i) const { return i + 1 == size_of(f) ? 0 : i + 1; }
    std::uint32_t previous_side(std::uint32_t f, std::uint32_t i) const { return (i == 0 ? size_of(f) : i) - 1; }

  private:
    void set_side(int side, std::uint32_t begin, std::uint32_t step, std::uint32_t turn) {
        beside_begin_[side] = begin;
        beside_step_[side] = step;
        beside_turn_[side] = turn;
    }
    [[gnu::always_inline]] std::uint32_t face_begin(std::uint32_t f, std::uint32_t first_halfedge) const {
        const std::uint32_t begin = base_->vertex_count + base_->edge_count * inner_;
        return begin + (mixed() ? f + first_halfedge * (half_ - 1) * half_ : f * root_points());
    }
    /// The vertices inside h's root one step off side h, in its direction: N - 1; triangles: N - 2.
    [[gnu::always_inline]] VertexRun inner_beside(std::uint32_t h) const {
        const std::uint32_t f = face_of(h), i = h - first_halfedge(f);
        return {face_begin(f) + beside_begin_[i], beside_step_[i], quads() ? 0 : beside_turn_[i]};
    }

    const MeshLevel* base_;
    std::uint32_t segments_, inner_, half_;
    std::uint32_t beside_begin_[4], beside_step_[4], beside_turn_[4];
};

using RootLayout = RootLayoutOf<k_any_size>;

/// Calls work(layout) with one whose face size the compiler knows.
template <class Work>
void with_known_size(const RootLayout& at, Work&& work) {
    switch (at.face_size()) {
        case 3:
            return work(RootLayoutOf<3>(at.base(), at.segments()));
        case 4:
            return work(RootLayoutOf<4>(at.base(), at.segments()));
        default:
            return work(RootLayoutOf<0>(at.base(), at.segments()));
    }
}

}  // namespace tetrakis::detail
