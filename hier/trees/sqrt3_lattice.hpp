#pragma once

#include "../forest/corner_cell.hpp"
#include "../forest/site.hpp"
#include "../mesh/control_mesh.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

namespace tetrakis {

/// A point in the plane of a control triangle, in barycentric coordinates: integers whose sum is the number of segments
/// of a side, 3^l in the lattice of level l. Across a side one of them is negative.
struct Sqrt3Point {
    TriangleWeights weight{};

    std::int64_t operator[](std::size_t k) const { return weight[k]; }
    std::int64_t& operator[](std::size_t k) { return weight[k]; }
    friend Sqrt3Point operator+(const Sqrt3Point& a, const Sqrt3Point& b) {
        return {{a[0] + b[0], a[1] + b[1], a[2] + b[2]}};
    }
    friend Sqrt3Point operator-(const Sqrt3Point& a, const Sqrt3Point& b) { return a + -1 * b; }
    friend Sqrt3Point operator*(std::int64_t x, const Sqrt3Point& a) { return {{x * a[0], x * a[1], x * a[2]}}; }
    friend Sqrt3Point operator/(const Sqrt3Point& a, std::int64_t x) { return {{a[0] / x, a[1] / x, a[2] / x}}; }
};

/// Level of the lattice that contains the vertices after `level` simple steps.
constexpr int sqrt3_lattice_level(int level) { return (level + 1) / 2; }

/// The canonical site of a point, at its first lattice level: on a control edge in the face with the smaller number, at
/// a control vertex in the face of ControlMesh::vertex_halfedge(). Coordinates are those of the triangle family.
/// @param point  in the plane of `face`, inside it or in a face beside it; a point of lattice level `lattice`
Site sqrt3_site(const ControlMesh& mesh, FaceId face, Sqrt3Point point, int lattice);
/// The first simple step that has the vertex at a canonical site.
int sqrt3_first_level(const Site& site);

/// Names a triangle of an adaptive sqrt(3) mesh: face number `face` of level `level`. If `half`, the part of this face
/// that exists before the face across its edge is split: a triangle over a side of a face of the previous level.
struct Sqrt3Triangle {
    std::uint8_t level = 0;
    bool half = false;
    std::uint64_t face = 0;

    /// The control face from whose number its number follows. O(level).
    FaceId control_face() const {
        std::uint64_t root = face;
        for (int k = level; k > 0; --k) root /= 3;
        return FaceId(static_cast<std::uint32_t>(root));
    }
    friend constexpr auto operator<=>(const Sqrt3Triangle&, const Sqrt3Triangle&) = default;
};

/// A face of a level, or a half triangle, by its corners in the plane of a control face.
struct Sqrt3Cell {
    FaceId root;
    std::uint8_t level = 0;  ///< number of simple steps; the corners are points of that level's lattice
    bool cut = false;        ///< whether the step of this level cuts the edge from corner 0 to corner 1
    std::array<Sqrt3Point, 3> corner{};

    int lattice() const { return sqrt3_lattice_level(level); }
};

/// Connectivity of all levels of sqrt(3) refinement, computed from numbers: nothing is stored for a level.
///
/// Level k is the mesh after k simple steps (insert a point in every face, flip every old edge); two of them are one
/// step of the scheme. Half-edge h of level k becomes a triangle of level k + 1 with number h and half-edges 3 h to 3 h
/// + 2: (origin of h, centre across h, centre of h's face). If h is sharp (boundary or crease), the first of two steps
/// keeps the edge: (origin, target, centre). The second cuts it in three and leaves out the centre: (first, second,
/// opposite corner). A crease is sharp for as many second steps as its sharpness lasts.
///
/// Two steps also cut a smooth edge in three and give the same triangles. So smooth edges can be treated like sharp
/// ones ("kept"), for triangles of all levels that do not cross them. Edges between holes and other faces always are,
/// others on request. The points on a kept smooth edge are the centres of the triangles that flipping it gives.
///
/// So the mesh is treated as cut open along sharp and kept edges: only the other half-edges have twins. beyond() gives
/// the half-edge on the other side of a sharp or kept edge.
///
/// Stores twins that it has found, up to a bound; so threads must not share it.
class Sqrt3Lattice {
  public:
    static constexpr std::uint64_t none = ~std::uint64_t{0};

    /// O(edges): to have many, copy one.
    /// @param mesh  triangle mesh. Keeps a reference.
    /// @param kept  whether an edge is to be kept; may be empty
    explicit Sqrt3Lattice(const ControlMesh& mesh, const std::function<bool(EdgeId)>& kept = {});
    explicit Sqrt3Lattice(const ControlMesh&&, const std::function<bool(EdgeId)>& = {}) = delete;

    /// The deepest level whose half-edges have 64-bit numbers.
    static int max_level(const ControlMesh& mesh);

    static std::uint64_t face(std::uint64_t h) { return h / 3; }
    static std::uint64_t next(std::uint64_t h) { return h % 3 == 2 ? h - 2 : h + 1; }
    static std::uint64_t prev(std::uint64_t h) { return h % 3 == 0 ? h + 2 : h - 1; }
    /// The twin of a half-edge; none on edges that are not flipped: boundary, creases, kept edges.
    std::uint64_t twin(int level, std::uint64_t h);
    /// The other half-edge of a crease or kept edge; none on the boundary and on all other edges.
    std::uint64_t beyond(int level, std::uint64_t h) {
        const Line line = this->line(level, h);
        return line.is_cut() ? line.beyond : none;
    }
    /// The edge of a face that the step at this level cuts; none if it cuts none.
    std::uint64_t cut_side(int level, std::uint64_t f);
    /// The face that must be split together with this one because the step cuts the edge between them; else none.
    std::uint64_t partner(int level, std::uint64_t f);
    /// Whether a face lies in a hole.
    bool is_hole(int level, std::uint64_t f) const {
        return holes_ && mesh_->is_hole(Sqrt3Triangle{static_cast<std::uint8_t>(level), false, f}.control_face());
    }
    /// Which of the two faces of a cut edge owns its points: the one outside of holes, else the smaller number.
    bool owns_cut(int level, std::uint64_t f, std::uint64_t beyond) const {
        const bool hole = is_hole(level, f), hole_beyond = is_hole(level, beyond);
        return hole != hole_beyond ? hole_beyond : f < beyond;
    }
    const ControlMesh& mesh() const { return *mesh_; }
    /// Whether an edge of the control mesh is never flipped, though it may be smooth.
    bool is_kept(EdgeId e) const { return kept_ && (*kept_)[e.value] != 0; }

    /// A face of a level. It lies in the root's triangle; at odd levels half of it may lie across a side. O(level).
    Sqrt3Cell cell(int level, std::uint64_t face) const;
    Sqrt3Cell cell(const Sqrt3Triangle& triangle) const;
    static Sqrt3Cell cell(FaceId control_face) {
        return {control_face, 0, false, {Sqrt3Point{{1, 0, 0}}, Sqrt3Point{{0, 1, 0}}, Sqrt3Point{{0, 0, 1}}}};
    }
    /// The half triangle over a side of a face; its level is the level of its apex.
    Sqrt3Cell half(const Sqrt3Cell& whole, std::size_t side) const;
    /// The face of the next level over a side of a face.
    Sqrt3Cell child(const Sqrt3Cell& cell, std::size_t side) const;
    /// The point of the next level over a side in its face, in the lattice of that level: the face's centre; or, if the
    /// face's edge is cut, the cut point next to the side (for the cut edge itself, the first one).
    static Sqrt3Point apex(const Sqrt3Cell& cell, std::size_t side);
    /// Whether a side of a cell lies on a control edge that is not flipped at a level.
    bool is_line(const Sqrt3Cell& cell, std::size_t side, int level) const;

    /// Bytes of the stored twins.
    std::uint64_t memory_bytes() const { return twins_.capacity() * sizeof(Twins); }

  private:
    /// The half-edge on the other side of a half-edge that is on a crease or kept edge, or was until this level.
    struct Line {
        std::uint64_t beyond = none;
        float sharpness = 0;
        bool kept = false;
        bool is_cut() const { return sharpness > 0 || kept; }
    };

    /// Moves a cell whose centre is across an edge of its root to the frame of the face there.
    Sqrt3Cell in_root(Sqrt3Cell cell) const;
    bool cuts(int level) const { return !smooth_ && level % 2 != 0; }
    static constexpr std::size_t k_kept_twins = 32;  // per level: the faces around a few vertices
    std::uint64_t find_twin(int level, std::uint64_t h);
    /// The twins of a face's half-edges.
    struct Twins {
        std::uint64_t face = none;
        std::array<std::uint64_t, 3> of{};
    };
    const Twins& twins(int level, std::uint64_t f);
    Line line(int level, std::uint64_t h);

    const ControlMesh* mesh_;
    std::shared_ptr<const std::vector<std::uint8_t>> kept_;  // per edge of the control mesh; null: no edge is kept
    bool smooth_ = true, lines_ = false, holes_ = false;
    std::vector<Twins> twins_;  // found twins; k_kept_twins of each level
};

}  // namespace tetrakis
