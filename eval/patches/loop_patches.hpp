#pragma once

#include "box_spline.hpp"
#include "patch_tree.hpp"

#include <cstdint>
#include <vector>

namespace tetrakis {

namespace detail {

/// Cells of Loop, with corners (0, 0), (1, 0), (0, 1). Leaves are quartic box splines, at regular boundaries and
/// creases too. Quarters: [0..2] at the corners, [3] the centre, whose corners lie opposite the cell's.
struct LoopShape {
    static constexpr int k_corners = 3;
    using Patch = Net12;

    static const Vec3d& corner_point(const Net12& net, int k) { return net[static_cast<std::size_t>(k)]; }
    static void set_corner_point(Net12& net, int k, const Vec3d& p) { net[static_cast<std::size_t>(k)] = p; }
    static Vec3d position(const Net12& net, const Vec2d& at) {
        return is_cell_corner(at) ? box_spline_corner(net, quarter_of(at, 3)) : box_spline_position(net, bary(at));
    }
    /// Position and derivatives, without the normal.
    static SurfacePoint evaluate(const Net12& net, const Vec2d& at, bool second);

    /// As for quads.
    static std::pair<HalfedgeId, double> on_edge(const ControlMesh& mesh, HalfedgeId root, const Vec2d& at) {
        if (at.y == 0 && at.x < 1) return {root, at.x};
        if (at.x == 0) return {mesh.prev(root), 1 - at.y};
        return {at.x + at.y == 1 ? mesh.next(root) : HalfedgeId{}, at.y};
    }
    static SurfaceParameter in_root(const ControlMesh& mesh, HalfedgeId h, double fraction) {
        const HalfedgeId root = mesh.face_halfedge(mesh.face(h));
        const auto k = static_cast<int>(h.value - root.value);
        const Vec2d at = (1 - fraction) * cell_corner(k, 3) + fraction * cell_corner((k + 1) % 3, 3);
        return {root, at.x, at.y};
    }

    /// The corner's neighbours outside the cell, counter-clockwise. With them, the smooth rules give on the cell's side
    /// what the ring's rules give, at this level and below. Empty if no such points exist. At a smooth corner they are
    /// the ring's own. At a boundary or crease with three triangles on the cell's side, missing ones are reflected: c +
    /// p_0 - p_1; at a corner with a single triangle, through the centre too.
    static OuterPoints beyond(const CornerRing& ring);
};

using LoopNode = PatchNode<LoopShape>;

}  // namespace detail

/// Patch trees of Loop (refine/README.md). One per control triangle, named by its first half-edge h0 =
/// face_halfedge(f), with the parameters x, y >= 0, x + y <= 1: origin(h0) = (0, 0), origin(h0 + 1) = (1, 0),
/// origin(h0 + 2) = (0, 1). Sources: Loop 1987; Stam 1998; Hoppe et al. 1994.
class LoopPatches final : public PatchTree<detail::LoopShape> {
  public:
    /// O(H). Keeps a reference to the mesh.
    /// @throws Error  invalid_input: a face is not a triangle; unsupported: corner angles; memory_limit where the
    /// context's limit would be exceeded
    explicit LoopPatches(const ControlMesh& mesh, const RunContext& context = {});
    explicit LoopPatches(const ControlMesh&&, const RunContext& = {}) = delete;

  private:
    void build_root(HalfedgeId root, detail::LoopNode& node) const override;
    detail::CornerRing ring(HalfedgeId h) const override { return detail::control_ring(mesh_, SchemeKind::loop, h); }
};

}  // namespace tetrakis
