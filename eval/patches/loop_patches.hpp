#pragma once

#include "box_spline.hpp"
#include "patch_tree.hpp"

#include <cstdint>
#include <optional>
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

    /// The corner's neighbours outside the cell, counter-clockwise. With them, the smooth rules give on the cell's side
    /// what the ring's rules give, at this level and below. Empty if no such points exist. At a smooth corner they are
    /// the ring's own. At a boundary or crease with three triangles on the cell's side, missing ones are reflected: c +
    /// p_0 - p_1; at a corner with a single triangle, through the centre too.
    static std::vector<Vec3d> beyond(const CornerRing& ring);
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

    /// Limit position, first derivatives and normal of a vertex: as evaluate(), but on an infinitely sharp edge with
    /// the mean of the normals of both sides, and at a control vertex with the mean of its sectors'.
    SurfacePoint vertex(HalfedgeId root, LatticePoint at, int level) const;

  private:
    void build_root(HalfedgeId root, detail::LoopNode& node) const override;
    /// Star of a root with smooth corners, from an extraordinary one on if there is any; empty for other roots.
    /// @param turn  receives the number of the root's corner that is corner 0 of the star
    std::optional<detail::LoopStar> root_star(HalfedgeId root, int& turn) const;
    /// Ring of a corner of a root.
    detail::CornerRing root_ring(HalfedgeId root, std::uint32_t corner) const;
};

}  // namespace tetrakis
