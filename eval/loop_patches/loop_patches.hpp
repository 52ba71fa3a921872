#pragma once

#include "../../hier/forest/site.hpp"
#include "../../hier/mesh/control_mesh.hpp"
#include "../surface/surface_point.hpp"
#include "loop_cell.hpp"

#include <atomic>
#include <memory>
#include <span>
#include <vector>

namespace tetrakis {

/// The patch tree of Loop (refine/README.md): exact evaluation of the limit surface anywhere. One tree per control
/// triangle, named by its first half-edge h0 = face_halfedge(f), with the parameters x, y >= 0, x + y <= 1: origin(h0)
/// = (0, 0), origin(h0 + 1) = (1, 0), origin(h0 + 2) = (0, 1). Leaves are quartic box splines, at regular boundaries
/// and creases too; trees grow lazily, towards irregular places only. Thread-safe; a result depends on its arguments
/// alone. Sources: Loop 1987; Stam 1998; Hoppe et al. 1994.
class LoopPatches {
  public:
    /// O(H): one Loop step. Keeps a reference to the mesh.
    /// @throws Error  invalid_input: a face is not a triangle; unsupported: corner angles; memory_limit where the
    /// context's limit would be exceeded
    explicit LoopPatches(const ControlMesh& mesh, const RunContext& context = {});
    explicit LoopPatches(const ControlMesh&&, const RunContext& = {}) = delete;
    ~LoopPatches();
    LoopPatches(const LoopPatches&) = delete;
    LoopPatches& operator=(const LoopPatches&) = delete;

    const ControlMesh& mesh() const { return mesh_; }

    /// The limit surface at (x, y) of a root. On creases and at corners derivatives and, inside crease edges, the
    /// normal are those of this root's side.
    SurfacePoint evaluate(HalfedgeId root, double x, double y) const { return evaluate(root, x, y, true); }
    /// The same without second derivatives, and the position alone.
    SurfacePoint frame(HalfedgeId root, double x, double y) const { return evaluate(root, x, y, false); }
    Vec3d position(HalfedgeId root, double x, double y) const;
    /// The limit position at a lattice point, level <= k_max_level; about the cost of one patch.
    Vec3d limit(HalfedgeId root, LatticePoint at, int level) const;
    /// limit() of many points.
    void limits(std::span<const Site> sites, std::span<Vec3d> out) const;
    /// Limit position, first derivatives and normal of a vertex: as evaluate(), but on an infinitely sharp edge with
    /// the mean of the normals of both sides.
    SurfacePoint vertex(HalfedgeId root, LatticePoint at, int level) const;

    /// Bytes held from the construction on (what grows later is small beside it).
    std::uint64_t memory_bytes() const;

    // The tree, for bounds.
    void root_cell(HalfedgeId root, detail::LoopCell& out) const;
    /// A quarter of a cell that is not regular; quarters count in the cell's frame: at its corners 0, 1, 2, [3] the
    /// centre.
    /// @param out  may be the cell itself
    void child(const detail::LoopCell& cell, int quarter, detail::LoopCell& out) const;
    /// Position at a point of a cell (in the cell's frame).
    Vec3d position(const detail::LoopCell& cell, const detail::Bary& at) const;
    /// Position at a corner of a cell.
    Vec3d corner(const detail::LoopCell& cell, int corner) const;

  private:
    enum class RootKind : std::uint8_t { regular, star0, star1, star2, split, generic };

    void first_step();
    void classify_roots();
    detail::CornerRing control_ring(std::uint32_t h) const;
    /// Of the half at the origin, level 1.
    float half_sharpness(std::uint32_t h) const;
    void corner_limits();
    Vec3d vertex_limit(VertexId v) const;
    SurfacePoint control_corner(std::uint32_t h) const;
    struct Descent;
    bool descend(Descent& down) const;
    SurfacePoint evaluate(HalfedgeId root, double x, double y, bool second) const;
    SurfacePoint corner_point(const Descent& down) const;
    const Vec3d& corner_limit(std::uint32_t h) const { return limits_[origin(h)]; }
    void gather_control(std::uint32_t h, int valence, Vec3d* out) const;
    void gather_first(std::uint32_t h, int valence, Vec3d* out) const;
    void gather_centre(std::uint32_t h, detail::Net12& out) const;
    const detail::LoopStarChain& star_root(std::uint32_t h, bool first_level) const;
    const detail::LoopNode& generic_root(std::uint32_t h) const;

    std::uint32_t twin(std::uint32_t h) const { return mesh_.twin(HalfedgeId(h)).value; }
    static std::uint32_t next(std::uint32_t h) { return h % 3 == 2 ? h - 2 : h + 1; }
    static std::uint32_t prev(std::uint32_t h) { return h % 3 == 0 ? h + 2 : h - 1; }
    std::uint32_t origin(std::uint32_t h) const { return mesh_.origin(HalfedgeId(h)).value; }
    const Vec3d& control(std::uint32_t h) const { return mesh_.positions()[origin(h)]; }
    const Vec3d& vertex_point(std::uint32_t h) const { return vertex_points_[origin(h)]; }
    const Vec3d& edge_point(std::uint32_t h) const { return edge_points_[mesh_.edge(HalfedgeId(h)).value]; }

    const ControlMesh& mesh_;
    std::vector<Vec3d> vertex_points_, edge_points_;  ///< level 1
    std::vector<Vec3d> limits_;                       ///< of the control vertices
    std::vector<std::uint8_t> smooth_;                ///< per vertex: interior, nothing sharp at it
    std::vector<RootKind> kind_;
    /// Per half-edge: the star at its origin (split and star roots), or, per root, the generic tree.
    union Grown {
        std::atomic<detail::LoopStarChain*> star;
        std::atomic<detail::LoopNode*> node;
        Grown() : star(nullptr) {}
    };
    mutable std::vector<Grown> grown_;
    mutable detail::RecordPool pool_;
};

}  // namespace tetrakis
