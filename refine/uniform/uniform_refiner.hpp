#pragma once

#include "../../hier/base/run_context.hpp"
#include "../../hier/base/vec.hpp"
#include "../../hier/mesh/control_mesh.hpp"
#include "../../schemes/core/scheme_kind.hpp"
#include "../rules/polygon_mesh.hpp"

#include <memory>
#include <span>

namespace tetrakis {

struct UniformOptions {
    bool limit = false;    ///< put the vertices on the limit surface
    bool normals = false;  ///< limit normals (with or without `limit`)
    /// The same faces with points on the control mesh: bilinear in its quads (Catmull-Clark's faces), or at the
    /// midpoints of its triangles (Loop's). These are their own limit, and there are no normals: the other options do
    /// nothing.
    bool linear = false;
    /// Catmull-Clark: each level by the two half-steps of FactoredMesh, to rounding error the same points. A mesh with
    /// other faces than quads has its roots at the corners of all faces, and its vertices in their order.
    bool factored = false;
    /// refine_uniform() only: refined by the same masks into PolygonMesh::attributes.
    std::span<const VertexAttribute> attributes{};
    RunContext context{};
};

/// The last level of a uniform refinement.
template <class T>
struct UniformLevel {
    std::span<const Vec3<T>> positions, normals;  ///< normals: only where they are asked for
    std::span<const std::uint32_t> faces;         ///< face_size() vertex numbers each
};

/// Refines a control mesh everywhere, again and again: connectivity and tags are looked at once, then refine() turns
/// any control positions (an animated mesh) into those of the last level, in buffers that are kept.
///
/// The roots are the control faces, if these are quads (Loop: triangles), with N = 2^levels pieces per side; a face
/// with another number of sides has a root at each corner, with N / 2 pieces. Corners (x, y) of a root: (0, 0) at the
/// face's first corner (of a root at a corner: at that), x along the side that starts there, y back along the one that
/// ends there.
/// * Faces: root by root, row by row (y, then x); quads [(x, y), (x+1, y), (x+1, y+1), (x, y+1)]; Loop: [(x, y),
///   (x+1, y), (x, y+1)], each but a row's last followed by [(x+1, y), (x+1, y+1), (x, y+1)].
/// * Vertices: control vertices; the N - 1 inner ones of each control edge; the inner ones of each control face: of a
///   root row by row, else its centre, those between it and the middle of each side, and the inner ones of each root.
///   Holes and isolated vertices are left in.
///
/// float or double. One object serves one thread at a time; the work is parallel, and gives the same bytes for any
/// number of threads.
template <class T>
class UniformRefiner {
  public:
    /// @param mesh    Loop: triangles only. Outlives the refiner
    /// @param levels  >= 0; each level has four times as many faces; at least 1 for Catmull-Clark on a mesh with other
    ///                faces than quads
    /// @throws Error  invalid_input: the above, or Loop factored; unsupported: corner angles, more elements than 32
    /// bits
    ///                can count; memory_limit (with the numbers, before anything is allocated)
    UniformRefiner(const ControlMesh& mesh, SchemeKind scheme, int levels, const UniformOptions& options = {});
    UniformRefiner(const ControlMesh&&, SchemeKind, int, const UniformOptions& = {}) = delete;
    ~UniformRefiner();
    UniformRefiner(UniformRefiner&&) noexcept;
    UniformRefiner& operator=(UniformRefiner&&) noexcept;

    std::uint32_t vertex_count() const;
    std::uint32_t face_count() const;
    int face_size() const;  ///< 4, Loop 3
    /// The control face that a face comes from.
    std::uint32_t control_face(std::uint32_t face) const;

    /// Positions (on the limit surface where the options say so) and unit limit normals of the last level.
    /// @param control    as many as the control mesh has vertices
    /// @param positions  vertex_count() of them, to be written
    /// @param normals    vertex_count(), or empty: no normals (whatever the options say)
    /// @throws Error     invalid_input: a span of the wrong length; cancelled (what is written is then worth nothing)
    /// Cost: O(vertices); memory is allocated by the first call.
    void refine(std::span<const Vec3<T>> control, std::span<Vec3<T>> positions, std::span<Vec3<T>> normals);
    void refine(std::span<const Vec3<T>> control, std::span<Vec3<T>> positions) { refine(control, positions, {}); }

    /// The same in buffers that the refiner keeps, on huge pages where the system has them, with the normals that the
    /// options ask for and the faces. Valid until the next call.
    UniformLevel<T> refine(std::span<const Vec3<T>> control);

    /// The last level's face_size() * face_count() vertex numbers; they depend on no position.
    /// @throws Error  invalid_input: the wrong length; cancelled
    void faces(std::span<std::uint32_t> corners) const;

  private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace tetrakis
