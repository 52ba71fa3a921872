#pragma once

#include "bicubic.hpp"
#include "patch_tree.hpp"

#include <cstdint>
#include <span>
#include <vector>

namespace tetrakis {

namespace detail {

/// Cells of Catmull-Clark. Leaves are bicubic patches, single-crease patches included (Niessner et al. 2012).
struct QuadShape {
    static constexpr int k_corners = 4;
    struct Patch {
        Net16 net;
        SideCrease crease{};
    };

    static Vec3d corner_point(const Patch& patch, int k) { return patch.net.at(k == 1 || k == 2, k >= 2); }
    static void set_corner_point(Patch& patch, int k, const Vec3d& p) { patch.net.set(k == 1 || k == 2, k >= 2, p); }
    static Vec3d position(const Patch& patch, const Vec2d& at) {
        return regular_position(patch.net, patch.crease, at.x, at.y);
    }
    /// Position and derivatives, without the normal.
    static SurfacePoint evaluate(const Patch& patch, const Vec2d& at, bool second);

    /// The half-edge that a point of a root lies on, and how far along, from 0 up to but not including 1; none inside.
    static std::pair<HalfedgeId, double> on_edge(const ControlMesh& mesh, HalfedgeId root, const Vec2d& at) {
        if (at.y == 0) return {root, at.x / 2};
        return {at.x == 0 ? mesh.prev(root) : HalfedgeId{}, 1 - at.y / 2};
    }
    /// The same point as a parameter of a root on the half-edge's side.
    static SurfaceParameter in_root(const ControlMesh& mesh, HalfedgeId h, double fraction) {
        if (fraction < 0.5) return {h, 2 * fraction, 0};
        return {mesh.next(h), 0, 2 - 2 * fraction};
    }

    /// The points around a corner outside the cell, counter-clockwise from (-1, 0) to (0, -1) as seen from the corner.
    /// With them, the smooth rules give on the cell's side what the ring's rules give, at this level and below, except
    /// for a crease of finite sharpness along one side. Empty if no such points exist. Beyond infinitely sharp sides,
    /// p_-1 = 2 p_0 - p_1 turns the B-spline rules into those of the boundary.
    static OuterPoints beyond(const CornerRing& ring);
};

using QuadNode = PatchNode<QuadShape>;

}  // namespace detail

/// Patch trees of Catmull-Clark (refine/README.md), one per corner cell, with its parameters in [0, 1]^2. Sources: Stam
/// 1998 (extraordinary points); Niessner et al. 2012 (single-crease patches), in closed form here.
class QuadPatches final : public PatchTree<detail::QuadShape> {
  public:
    /// O(H): one step of the scheme. Keeps a reference to the mesh.
    /// @throws Error unsupported: corner angles; memory_limit where the context's limit would be exceeded.
    explicit QuadPatches(const ControlMesh& mesh, const RunContext& context = {});
    explicit QuadPatches(const ControlMesh&&, const RunContext& = {}) = delete;

    /// Bytes of all data, those of the trees (forgettable_bytes()) included.
    std::uint64_t memory_bytes() const;

  private:
    void build_root(HalfedgeId root, detail::QuadNode& node) const override;
    detail::CornerRing ring(HalfedgeId h) const override {
        return detail::control_ring(mesh_, SchemeKind::catmull_clark, h, face_points());
    }
    Vec3d vertex_point(VertexId v) const { return first_[v.value]; }
    Vec3d edge_point(HalfedgeId h) const { return first_[mesh_.vertex_count() + mesh_.edge(h).value]; }
    Vec3d face_point(HalfedgeId h) const { return face_points()[mesh_.face(h).value]; }
    std::span<const Vec3d> face_points() const {
        return std::span(first_).subspan(mesh_.vertex_count() + mesh_.edge_count());
    }
    void first_step();
    void gather_star(HalfedgeId root, detail::QuadStar& star) const;
    detail::CellRings<4> root_rings(HalfedgeId root) const;

    std::vector<Vec3d> first_;          ///< level-1 points: vertices, edges, faces
    std::vector<std::uint8_t> smooth_;  ///< per vertex: whether it is interior with nothing sharp at level 1
};

}  // namespace tetrakis
