#pragma once

#include "../../hier/base/memory.hpp"
#include "../../hier/base/run_context.hpp"
#include "../../schemes/core/rule_mesh.hpp"
#include "root_layout.hpp"

#include <algorithm>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>

namespace tetrakis::detail {

/// The place in a lattice that is (a, b) seen from one of its sides: a along it, b away from it.
/// @param n  the last place along a side
template <class Place, class Int>
Place turned_place(bool quads, Int n, std::uint32_t side, Int a, Int b) {
    if (side == 0) return {a, b};
    if (!quads) return side == 1 ? Place{n - a - b, a} : Place{b, n - a - b};
    return side == 1 ? Place{n - b, a} : side == 2 ? Place{n - a, n - b} : Place{b, n - a};
}

/// A place in the lattice of a root. The level is known from the context, and may have more points than 32 bits number.
struct RootPlace {
    std::uint32_t root = 0, x = 0, y = 0;
    friend constexpr auto operator<=>(const RootPlace&, const RootPlace&) = default;
};

/// Lattice coordinates of a place inside or outside a root.
struct FarPlace {
    std::int64_t x, y;
};

/// Numbers of the points and faces of all levels below a mesh of roots, all quads or all triangles. They are computed
/// from the coordinates in a root's lattice.
///
/// For schemes that cut faces into lattices, the roots are the faces of a level; points are in the order of RootLayout.
/// For dual schemes, the roots are the quads of a face split, one per half-edge, and one beyond each boundary side and
/// corner. Points are the cells of their lattices: root by root, row by row. A crease is a boundary of each of its
/// sides, so a point on it has a place on each; at a dart one more root lies between the sides.
class RootLattices {
  public:
    static constexpr std::uint32_t none = 0xFFFF'FFFFu;  ///< RuleMesh::none
    struct Place {
        std::uint32_t x, y;
    };
    /// A point seen from a corner: place (a, b), counted from the corner, in the lattice of the root that is `turn`
    /// roots further counter-clockwise around the corner.
    struct Seen {
        std::int16_t turn, a, b;
        auto operator<=>(const Seen&) const = default;
    };

    /// Roots that are the faces of a level.
    /// @param control_face  the control face of each face of the mesh, for faces()
    static RootLattices of_faces(const RuleMesh& mesh, std::vector<std::uint32_t> control_face = {});
    /// Roots that are quads at the face corners of a level.
    /// @param creases       whether the scheme has a rule for creases
    /// @param control_face  the control face of each face corner, by half-edge, for faces()
    static RootLattices of_corners(const RuleMesh& mesh, bool creases, std::vector<std::uint32_t> control_face = {});
    /// Whether all roots are quads or all are triangles, and no root has a vertex or an edge twice.
    bool has_simple_roots() const;

    bool in_cells() const { return in_cells_; }
    /// The roots.
    const RuleMesh& base() const { return base_; }
    std::uint32_t root_count() const { return base_.face_count(); }
    std::uint32_t root_of(std::uint32_t h) const { return sides_ == 4 ? h / 4 : h / 3; }
    std::uint32_t halfedge_count() const { return base_.halfedge_count(); }
    /// The half-edge that leaves the origin of h next, counter-clockwise; `none` if a boundary is between them.
    std::uint32_t turned(std::uint32_t h) const {
        const std::uint32_t first = sides_ * root_of(h);
        return base_.twin(h == first ? first + sides_ - 1 : h - 1);
    }
    RootLayout layout(std::uint32_t segments) const { return {base_, segments}; }
    std::uint32_t place_count(const RootLayout& at) const {
        return in_cells_ ? static_cast<std::uint32_t>(at.cell_count()) : at.vertex_count();
    }
    /// Numbers of the points of a level, by place; a point may have several places.
    struct Numbers {
        std::uint32_t count;         ///< of points
        std::uint32_t first_shared;  ///< lower places have the numbers of their points
        std::vector<std::uint32_t> number;

        std::uint32_t of(std::uint32_t place) const {
            return place < first_shared ? place : number[place - first_shared];
        }
    };
    Numbers point_numbers(const RootLayout& at) const;
    bool shares_points() const { return !glued_.empty(); }
    /// Pairs of half-edges of roots beyond the two sides of a crease. Cells along both are the same points, in opposite
    /// order.
    std::span<const std::pair<std::uint32_t, std::uint32_t>> glued() const { return glued_; }
    std::uint32_t control_face(std::uint32_t root) const { return base_face_[root]; }
    /// Vertices to which creases shrink from their darts. Either three roots are around one, and the cells of the first
    /// and the last are glued; or two, those of the darts at both ends of a crease of one edge.
    const std::vector<std::uint32_t>& crease_ends() const { return crease_ends_; }

    /// The vertex of `mesh` at each place of a level; empty if the faces do not form the lattices.
    /// @param halfedge  for each half-edge of a root its child at its origin; in cells, for each root the half-edge of
    ///                  its last cell that stays in its face (the roots beyond the boundary have none)
    std::optional<std::vector<int>> vertices(const RootLayout& at, const RuleMesh& mesh,
                                             std::span<const int> halfedge) const {
        return in_cells_ ? cells(at, mesh, halfedge) : lattice(at, mesh, halfedge);
    }

    /// Faces of a level, and the control face that each belongs to. Meshes with the same faces give face corners in the
    /// same order.
    struct Faces {
        std::vector<std::uint32_t> offsets, vertices;
        PodArray<std::uint32_t> control;  ///< one for every `each` consecutive faces
        std::uint32_t each = 1;
        std::uint32_t control_face(std::uint32_t face) const { return control[face / each]; }
    };
    /// @param only  the roots whose faces are wanted; null: all roots. Ignored in cells
    Faces faces(std::uint32_t segments, const RunContext& context,
                const std::vector<std::uint32_t>* only = nullptr) const;
    /// Calls visit(root) for each root that contains the point with this number. Not for roots in cells.
    template <class Visit>
    void for_each_root_of(const RootLayout& at, std::uint32_t number, const Visit& visit) const {
        if (number >= at.face_begin(0)) return visit((number - at.face_begin(0)) / at.root_points());
        const auto visit_root = [&](int h) { visit(base_.face(h)); };
        if (number < at.edge_begin(0)) {
            base_.for_each_leaving(number, visit_root);
            return;
        }
        const int h = base_.edge_halfedge((number - at.edge_begin(0)) / (at.segments() - 1));
        visit_root(h);
        if (base_.twin(h) != RuleMesh::none) visit_root(base_.twin(h));
    }

    // Lattices seen from half-edge h: a along it, b away from it; n is the last place.
    std::uint32_t side_count() const { return sides_; }
    std::uint32_t last_place(std::uint32_t segments) const { return in_cells_ ? segments - 1 : segments; }
    std::uint32_t last_place(const RootLayout& at) const { return last_place(at.segments()); }
    Place turned(std::uint32_t n, std::uint32_t side, std::uint32_t a, std::uint32_t b) const {
        return turned_place<Place>(sides_ == 4, n, side, a, b);
    }
    /// The coordinates (a, b) of a root's place as seen from one of its sides.
    Place seen_from(std::uint32_t n, std::uint32_t side, const Place& p) const {
        return turned(n, side == 0 ? 0 : side_count() - side, p.x, p.y);
    }
    std::uint32_t number(const RootLayout& at, std::uint32_t h, std::uint32_t a, std::uint32_t b) const {
        const std::uint32_t f = root_of(h);
        return number_at(at, f, turned(last_place(at), h - sides_ * f, a, b));
    }
    std::uint32_t number_at(const RootLayout& at, std::uint32_t f, const Place& p) const {
        const std::uint32_t n = at.segments();
        return in_cells_ ? (f * n + p.y) * n + p.x : at.at(f, p.x, p.y);
    }
    /// Place (a, b) of the lattice seen from half-edge h.
    RootPlace place_seen(std::uint32_t segments, std::uint32_t h, std::uint32_t a, std::uint32_t b) const {
        const std::uint32_t f = root_of(h);
        const Place p = turned(last_place(segments), h - sides_ * f, a, b);
        return {f, p.x, p.y};
    }
    /// Whether a place is inside the root, not on a side.
    bool is_inside(std::uint32_t segments, std::uint32_t x, std::uint32_t y) const {
        return x > 0 && y > 0 && (sides_ == 4 ? std::max(x, y) < segments : x + y < segments);
    }
    /// The canonical place of a point, of which each root around it has one: in the root of the first half-edge of its
    /// edge or vertex.
    RootPlace own_place(std::uint32_t segments, const RootPlace& at) const;
    /// The neighbours of a place, counter-clockwise; not in cells. On quads, edge neighbours and diagonal ones
    /// alternate. A boundary vertex begins and ends with its neighbours along the boundary.
    struct Around {
        std::vector<RootPlace> places;
        bool closed = true;
    };
    Around around(std::uint32_t segments, const RootPlace& at) const;
    /// The own place of the point at (x, y), inside a root or beyond its sides. The lattice continues there into the
    /// neighbouring roots.
    RootPlace place_beyond(std::uint32_t segments, std::uint32_t root, std::int64_t x, std::int64_t y) const;
    /// Calls visit(a, number) for the places (a, b), begin <= a < end, of the line b away from side h.
    template <class Visit>
    void for_each_on_line(const RootLayout& at, std::uint32_t h, std::uint32_t b, std::uint32_t begin,
                          std::uint32_t end, const Visit& visit) const {
        const bool quads = sides_ == 4;
        const std::uint32_t f = root_of(h), side = h - sides_ * f, n = last_place(at), last = n - (quads ? 0 : b),
                            from = std::max(begin, 1u);
        const bool inside = !in_cells_ && b > 0 && b < n;  // except at both ends
        const auto number = [&](std::uint32_t a) { return number_at(at, f, turned(n, side, a, b)); };
        const auto between = [&](std::uint32_t a) {
            const Place p = turned(n, side, a, b);
            return inside ? at.inside(f, p.x, p.y) : number_at(at, f, p);
        };
        if (begin == 0 && end > 0) visit(0, number(0));
        if (from < std::min(end, last)) {
            // Between both ends the second difference of the numbers is constant (modulo 2^32); on quads it is zero.
            std::uint32_t v = between(from), step = between(from + 1) - v;
            const std::uint32_t turn = quads ? 0 : between(from + 2) - v - 2 * step;
            for (std::uint32_t a = from; a < std::min(end, last); ++a) {
                visit(a, v);
                v += step;
                step += turn;
            }
        }
        if (from <= last && last < end) visit(last, number(last));
    }

  private:
    RootLattices(RuleMesh base, std::uint32_t own_roots, std::vector<std::uint32_t> control_face)
        : sides_(base.face_size(0)),
          own_roots_(own_roots),
          base_(std::move(base)),
          base_face_(std::move(control_face)) {}
    std::optional<std::vector<int>> lattice(const RootLayout& at, const RuleMesh& mesh,
                                            std::span<const int> corner_halfedge) const;
    std::optional<std::vector<int>> cells(const RootLayout& at, const RuleMesh& mesh,
                                          std::span<const int> last_halfedge) const;
    Faces cell_faces(const RootLayout& at) const;

    bool in_cells_ = false;
    std::uint32_t sides_ = 4;
    std::uint32_t own_roots_ = 0;  ///< number of roots in the mesh; in cells, later ones lie beyond the boundary
    RuleMesh base_;
    std::vector<std::uint32_t> base_face_;  ///< control face of each root
    std::vector<std::pair<std::uint32_t, std::uint32_t>> glued_;
    std::vector<std::uint32_t> crease_ends_;
};

}  // namespace tetrakis::detail
