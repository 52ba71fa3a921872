#pragma once

#include "tetrakis/hier/control_mesh.hpp"

#include <compare>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <unordered_map>
#include <vector>

namespace tetrakis {

/// A vertex of sqrt(3) refinement: where and when it came about.
struct Sqrt3Vertex {
    enum class Kind : std::uint8_t {
        control,  ///< key: the control vertex
        centre,   ///< of a face, key, of the level before
        first,    ///< on the sharp edge key of the level before (a crease: its lesser half-edge), near its origin
        second,   ///< the same, near its target
    };
    std::uint64_t key = 0;
    std::uint8_t birth = 0;  ///< its first level
    Kind kind = Kind::control;
    friend constexpr auto operator<=>(const Sqrt3Vertex&, const Sqrt3Vertex&) = default;
};

/// Connectivity of all levels of sqrt(3) refinement, by numbers alone: nothing is stored for a level.
///
/// Level k is the mesh after k simple steps (insert a point in every face, flip every old edge), two of which are one
/// step of the scheme. The triangle that half-edge h of level k leaves at level k + 1 has the number h there, and the
/// half-edges 3 h to 3 h + 2: (origin of h, centre beyond h, centre of h's face). Where h is sharp, on the boundary or
/// a crease, the first of two steps keeps the edge, (origin, target, centre), the second cuts it in three and leaves
/// out the centre, (first, second, opposite corner). A crease is sharp for as many second steps as its sharpness lasts.
///
/// So the mesh is as one that is cut open along its creases: half-edges have twins across smooth edges alone. What lies
/// beyond a crease is beyond().
///
/// Remembers twins that it has found, up to a bound, where the mesh has sharp edges: not to be shared by threads.
class Sqrt3Lattice {
  public:
    static constexpr std::uint64_t none = ~std::uint64_t{0};

    /// @param mesh  of triangles. Keeps a reference. O(edges): where many are needed, copies of one
    explicit Sqrt3Lattice(const ControlMesh& mesh);

    /// Levels beyond which half-edges have no 64-bit numbers.
    static int max_level(const ControlMesh& mesh);

    static std::uint64_t face(std::uint64_t h) { return h / 3; }
    static std::uint64_t next(std::uint64_t h) { return h % 3 == 2 ? h - 2 : h + 1; }
    static std::uint64_t prev(std::uint64_t h) { return h % 3 == 0 ? h + 2 : h - 1; }
    /// None on a sharp edge: the boundary, creases.
    std::uint64_t twin(int level, std::uint64_t h);
    /// The other half-edge of a crease; none on smooth edges and on the boundary.
    std::uint64_t beyond(int level, std::uint64_t h) {
        const Crease crease = this->crease(level, h);
        return crease.sharpness > 0 ? crease.beyond : none;
    }
    /// Infinite on the boundary, 0 on smooth edges.
    float sharpness(int level, std::uint64_t h);
    /// The face that can be split only together with this one, as the step cuts the crease between them; else none.
    std::uint64_t partner(int level, std::uint64_t f) {
        if (!creased_ || !cuts(level)) return none;
        const std::uint64_t h = beyond(level, 3 * f);
        return h == none ? none : face(h);
    }
    const ControlMesh& mesh() const { return *mesh_; }
    bool has_creases() const { return creased_; }
    /// Those at corners of the boundary included.
    bool has_tagged_vertices() const { return tagged_; }

    Sqrt3Vertex origin(int level, std::uint64_t h);
    /// The point of the next level that stands over a half-edge in its face: the face's centre, or where a sharp edge
    /// is cut the point next to the half-edge.
    Sqrt3Vertex apex(int level, std::uint64_t h);
    /// A half-edge of the level before, or after, that leaves the same vertex; none where it is not there yet.
    std::uint64_t before(int level, std::uint64_t h);
    std::uint64_t after(int level, std::uint64_t h);

  private:
    /// The half-edge beyond one that is, or has been up to this level, on a crease; and how sharp it still is.
    struct Crease {
        std::uint64_t beyond = none;
        float sharpness = 0;
    };

    bool cuts(int level) const { return !smooth_ && level % 2 != 0; }
    /// The sharp edge of a face at a level whose step cuts it; none if there is none.
    std::uint64_t cut_side(int level, std::uint64_t f);
    std::uint64_t find_twin(int level, std::uint64_t h);
    Crease crease(int level, std::uint64_t h);
    /// A new point of the cut edge of h, by the edge's lesser half-edge.
    Sqrt3Vertex on_edge(int level, std::uint64_t h, Sqrt3Vertex::Kind kind);

    const ControlMesh* mesh_;
    bool smooth_ = true, creased_ = false, tagged_ = false;
    std::vector<std::unordered_map<std::uint64_t, std::uint64_t>> twins_;  // per level
};

}  // namespace tetrakis

template <>
struct std::hash<tetrakis::Sqrt3Vertex> {
    std::size_t operator()(const tetrakis::Sqrt3Vertex& v) const noexcept {
        return static_cast<std::size_t>((v.key * 0x9E37'79B9'7F4A'7C15ull) ^
                                        (std::uint64_t{v.birth} << 57 | static_cast<std::uint64_t>(v.kind) << 55));
    }
};
