#pragma once

#include "tetrakis/eval/quad_node.hpp"
#include "tetrakis/eval/surface_point.hpp"
#include "tetrakis/hier/control_mesh.hpp"
#include "tetrakis/hier/site.hpp"

#include <memory>
#include <span>
#include <vector>

namespace tetrakis {

/// The patch tree of Catmull-Clark (DESIGN 3.3): exact evaluation of the limit surface anywhere. One tree per corner
/// cell; leaves are regular bicubic patches, boundary and crease patches included; it grows lazily, towards irregular
/// places only. Thread-safe; a result depends on its arguments alone. Sources: Stam 1998 (extraordinary points);
/// Niessner et al. 2012 (single-crease patches), in closed form here.
class QuadPatches {
  public:
    /// O(H). @throws Error unsupported: corner angles; memory_limit where the context's limit would be exceeded.
    explicit QuadPatches(const ControlMesh& mesh, const RunContext& context = {});
    explicit QuadPatches(const ControlMesh&&, const RunContext& = {}) = delete;
    ~QuadPatches();

    const ControlMesh& mesh() const { return mesh_; }

    /// The limit surface at parameters (x, y) in [0, 1]^2 of the corner cell of `root` (derivatives by x and y).
    SurfacePoint evaluate(HalfedgeId root, double x, double y) const { return evaluate(root, x, y, true); }
    /// The same without second derivatives: cheaper, and the same bits.
    SurfacePoint frame(HalfedgeId root, double x, double y) const { return evaluate(root, x, y, false); }
    /// The limit position at a lattice point of the cell, level <= k_max_level; about the cost of one patch.
    Vec3d limit(HalfedgeId root, LatticePoint at, int level) const;
    /// limit() of many points.
    void limits(std::span<const Site> sites, std::span<Vec3d> out) const;

    /// Limit position and normal of a vertex: as evaluate(), but on an infinitely sharp edge with the mean of the
    /// normals on both sides, and at a control vertex of such edges with the mean over its corner cells.
    SurfacePoint vertex(HalfedgeId root, LatticePoint at, int level) const;

    const detail::QuadNode& root_node(HalfedgeId root) const { return roots_[root.value]; }
    /// Bytes of the roots (the grown parts are small beside them).
    std::uint64_t memory_bytes() const { return roots_.size() * sizeof(detail::QuadNode); }

    /// The limit position at (x, y) of a cell of the tree.
    static Vec3d position(const detail::QuadNode& node, double x, double y);
    /// Limit of a cell's corner (0..3 in the order (0,0) (1,0) (1,1) (0,1)) at an irregular node: position, two
    /// tangents, normal.
    static SurfacePoint corner_limit(const detail::QuadNode& node, int corner);

  private:
    SurfacePoint evaluate(HalfedgeId root, double x, double y, bool second) const;
    void build_root(HalfedgeId root);
    Vec3d vertex_point(VertexId v) const { return first_[v.value]; }
    Vec3d edge_point(HalfedgeId h) const { return first_[mesh_.vertex_count() + mesh_.edge(h).value]; }
    Vec3d face_point(HalfedgeId h) const {
        return first_[mesh_.vertex_count() + mesh_.edge_count() + mesh_.face(h).value];
    }
    void first_step(const RunContext& context);
    void gather_around(HalfedgeId root, detail::Net16& net) const;
    detail::QuadLocalMesh local_mesh(HalfedgeId root, std::pmr::memory_resource* memory) const;

    const ControlMesh& mesh_;
    std::vector<Vec3d> first_;           ///< level-1 points: vertices, edges, faces (scratch of the construction)
    std::vector<float> half_sharpness_;  ///< per half-edge, level 1: of the half at its origin
    std::vector<float> vertex_sharpness_;
    std::vector<std::uint8_t> smooth_;  ///< per vertex: interior, nothing sharp at level 1
    detail::PoolVector<detail::QuadNode> roots_;
};

}  // namespace tetrakis
