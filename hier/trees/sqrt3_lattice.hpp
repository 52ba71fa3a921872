#pragma once

#include "../mesh/control_mesh.hpp"

#include <array>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

namespace tetrakis {

/// A vertex of sqrt(3) refinement: where and when it came about.
struct Sqrt3Vertex {
    enum class Kind : std::uint8_t {
        control,  ///< key: the control vertex
        centre,   ///< of a face, key, of the level before
        first,    ///< on the cut edge key of the level before, near its origin; key: its half-edge that is not in a
                  ///< hole, or the lesser one of both
        second,   ///< the same, near its target
    };
    std::uint64_t key = 0;
    std::uint8_t birth = 0;  ///< its first level
    Kind kind = Kind::control;
    friend constexpr auto operator<=>(const Sqrt3Vertex&, const Sqrt3Vertex&) = default;
};

/// A triangle of an adaptive sqrt(3) mesh.
struct Sqrt3Leaf {
    /// The face of a level itself; or, where `half`, the part of a split face over one of its half-edges, `face` being
    /// the half-edge's number: its edge is flipped when the face beyond is split, too.
    std::uint8_t level = 0;
    bool half = false;
    std::uint64_t face = 0;
    FaceId control_face;

    /// Per corner the finest level that the leaf knows of, and a half-edge that leaves the vertex there.
    int vertex_level(std::size_t corner) const { return half && corner == 2 ? level + 1 : level; }
    std::uint64_t leaving(std::size_t corner) const {
        if (!half || corner == 2) return 3 * face + corner;
        return corner == 0 ? face : face % 3 == 2 ? face - 2 : face + 1;
    }
};

/// Connectivity of all levels of sqrt(3) refinement, by numbers alone: nothing is stored for a level.
///
/// Level k is the mesh after k simple steps (insert a point in every face, flip every old edge), two of which are one
/// step of the scheme. The triangle that half-edge h of level k leaves at level k + 1 has the number h there, and the
/// half-edges 3 h to 3 h + 2: (origin of h, centre beyond h, centre of h's face). Where h is sharp, on the boundary or
/// a crease, the first of two steps keeps the edge, (origin, target, centre), the second cuts it in three and leaves
/// out the centre, (first, second, opposite corner). A crease is sharp for as many second steps as its sharpness lasts.
///
/// Two steps cut a smooth edge in three as well, and give the same triangles; so smooth edges can be kept like sharp
/// ones, to have triangles of all levels on one side of them: those between holes and other faces always are, others if
/// it is asked for. The points on a kept edge that is smooth are the centres of the triangles that flipping it gives.
///
/// So the mesh is as one that is cut open along sharp and kept edges: half-edges have twins across the others alone.
/// What lies beyond one of these is beyond().
///
/// Remembers twins that it has found, up to a bound: not to be shared by threads.
class Sqrt3Lattice {
  public:
    static constexpr std::uint64_t none = ~std::uint64_t{0};

    /// O(edges): where many are needed, copies of one.
    /// @param mesh  of triangles. Keeps a reference.
    /// @param kept  whether an edge is to be kept, or empty
    explicit Sqrt3Lattice(const ControlMesh& mesh, const std::function<bool(EdgeId)>& kept = {});
    explicit Sqrt3Lattice(const ControlMesh&&, const std::function<bool(EdgeId)>& = {}) = delete;

    /// Levels beyond which half-edges have no 64-bit numbers.
    static int max_level(const ControlMesh& mesh);

    static std::uint64_t face(std::uint64_t h) { return h / 3; }
    static std::uint64_t next(std::uint64_t h) { return h % 3 == 2 ? h - 2 : h + 1; }
    static std::uint64_t prev(std::uint64_t h) { return h % 3 == 0 ? h + 2 : h - 1; }
    /// None on an edge that is not flipped: the boundary, creases, kept edges.
    std::uint64_t twin(int level, std::uint64_t h);
    /// The other half-edge of a crease or kept edge; none on the boundary and on others.
    std::uint64_t beyond(int level, std::uint64_t h) {
        const Line line = this->line(level, h);
        return line.is_cut() ? line.beyond : none;
    }
    /// Infinite on the boundary, 0 on smooth edges.
    float sharpness(int level, std::uint64_t h);
    /// The face that can be split only together with this one, as the step cuts the edge between them; else none.
    std::uint64_t partner(int level, std::uint64_t f);
    /// Whether a face lies in a hole.
    bool is_hole(int level, std::uint64_t f) const { return holes_ && mesh_->is_hole(root(level, f)); }
    /// Which of the two faces of a cut edge names its points (Sqrt3Vertex).
    bool owns_cut(int level, std::uint64_t f, std::uint64_t beyond) const {
        const bool hole = is_hole(level, f), hole_beyond = is_hole(level, beyond);
        return hole != hole_beyond ? hole_beyond : f < beyond;
    }
    /// The control face that the number of a face comes from.
    static FaceId root(int level, std::uint64_t f) {
        for (; level > 0; --level) f /= 3;
        return FaceId(static_cast<std::uint32_t>(f));
    }

    const ControlMesh& mesh() const { return *mesh_; }
    /// Of the control mesh: whether an edge inside is not flipped; kept though it may be smooth.
    bool has_lines() const { return lines_; }
    bool has_kept() const { return kept_ != nullptr; }
    bool is_kept(EdgeId e) const { return kept_ && (*kept_)[e.value] != 0; }
    /// Those at corners of the boundary included.
    bool has_tagged_vertices() const { return tagged_; }

    Sqrt3Vertex origin(int level, std::uint64_t h);
    /// The point of the next level that stands over a half-edge in its face: the face's centre, or where an edge is cut
    /// the point next to the half-edge.
    Sqrt3Vertex apex(int level, std::uint64_t h);
    /// A half-edge of the level before, or after, that leaves the same vertex; none where it is not there yet.
    std::uint64_t before(int level, std::uint64_t h);
    std::uint64_t after(int level, std::uint64_t h);

    /// Of the twins that it remembers.
    std::uint64_t memory_bytes() const;

  private:
    /// The half-edge beyond one that is, or has been up to this level, on a crease or kept edge.
    struct Line {
        std::uint64_t beyond = none;
        float sharpness = 0;
        bool kept = false;
        bool is_cut() const { return sharpness > 0 || kept; }
    };

    bool cuts(int level) const { return !smooth_ && level % 2 != 0; }
    static constexpr std::size_t k_kept_twins = 32;  // of a level: those of the faces around a few vertices
    /// The edge of a face that the step at a level cuts; none if there is none.
    std::uint64_t cut_side(int level, std::uint64_t f);
    std::uint64_t find_twin(int level, std::uint64_t h);
    /// Of a face's half-edges.
    struct Twins {
        std::uint64_t face = none;
        std::array<std::uint64_t, 3> of{};
    };
    const Twins& twins(int level, std::uint64_t f);
    Line line(int level, std::uint64_t h);
    /// A new point of the cut edge of h, as Sqrt3Vertex names it.
    Sqrt3Vertex on_edge(int level, std::uint64_t h, Sqrt3Vertex::Kind kind);

    const ControlMesh* mesh_;
    std::shared_ptr<const std::vector<std::uint8_t>> kept_;  // per edge of the control mesh; none: no edge is
    bool smooth_ = true, lines_ = false, tagged_ = false, holes_ = false;
    std::vector<Twins> twins_;  // that have been found; k_kept_twins of each level
};

}  // namespace tetrakis

template <>
struct std::hash<tetrakis::Sqrt3Vertex> {
    std::size_t operator()(const tetrakis::Sqrt3Vertex& v) const noexcept {
        return static_cast<std::size_t>((v.key * 0x9E37'79B9'7F4A'7C15ull) ^
                                        (std::uint64_t{v.birth} << 57 | static_cast<std::uint64_t>(v.kind) << 55));
    }
};
