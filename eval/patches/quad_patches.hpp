#pragma once

#include "../../hier/forest/site.hpp"
#include "../../hier/mesh/control_mesh.hpp"
#include "../surface/surface_point.hpp"
#include "quad_node.hpp"

#include <atomic>
#include <cstdint>
#include <span>
#include <vector>

namespace tetrakis {

/// Patch tree of Catmull-Clark (refine/README.md): exact evaluation of the limit surface anywhere. One tree per corner
/// cell; leaves are regular bicubic patches, boundary and crease patches included; all grow where they are asked for,
/// below a root towards irregular places only, and can be forgotten again. Thread-safe but for that; a result depends
/// on its arguments alone. Sources: Stam 1998 (extraordinary points); Niessner et al. 2012 (single-crease patches), in
/// closed form here.
class QuadPatches {
  public:
    /// O(H): one step of the scheme. @throws Error unsupported: corner angles; memory_limit where the context's limit
    /// would be exceeded.
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

    const detail::QuadNode& root_node(HalfedgeId root) const {
        const detail::QuadNode* node = roots_[root.value].load(std::memory_order_acquire);
        return node ? *node : made_root(root);
    }

    /// Bytes of everything, of trees (forgettable_bytes()) as well.
    std::uint64_t memory_bytes() const;
    std::uint64_t forgettable_bytes() const { return tree_bytes_.load(std::memory_order_relaxed); }
    /// What trees may take before they should be forgotten: enough for all of an ordinary model's.
    std::uint64_t bytes_to_keep() const;
    /// Forgets all trees; nobody else may be reading, and nodes are no longer valid.
    void forget_trees() const;
    /// Forgets the tree of one root, which nobody else may be reading.
    void forget_tree(HalfedgeId root) const;
    /// How often something has been forgotten.
    std::uint64_t times_forgotten() const { return times_forgotten_.load(std::memory_order_relaxed); }

    /// The limit position at (x, y) of a cell of the tree.
    static Vec3d position(const detail::QuadNode& node, double x, double y);
    /// Limit of a cell's corner (0..3 in the order (0,0) (1,0) (1,1) (0,1)) at an irregular node: position, two
    /// tangents, normal.
    static SurfacePoint corner_limit(const detail::QuadNode& node, int corner);

  private:
    SurfacePoint evaluate(HalfedgeId root, double x, double y, bool second) const;
    const detail::QuadNode& made_root(HalfedgeId root) const;
    void build_root(HalfedgeId root, detail::QuadNode& node) const;
    Vec3d vertex_point(VertexId v) const { return first_[v.value]; }
    Vec3d edge_point(HalfedgeId h) const { return first_[mesh_.vertex_count() + mesh_.edge(h).value]; }
    Vec3d face_point(HalfedgeId h) const {
        return first_[mesh_.vertex_count() + mesh_.edge_count() + mesh_.face(h).value];
    }
    void first_step();
    void gather_star(HalfedgeId root, detail::QuadStar& star) const;
    detail::QuadRings root_rings(HalfedgeId root) const;

    const ControlMesh& mesh_;
    std::vector<Vec3d> first_;           ///< level-1 points: vertices, edges, faces
    std::vector<float> half_sharpness_;  ///< per half-edge, level 1: of the half at its origin
    std::vector<float> vertex_sharpness_;
    std::vector<std::uint8_t> smooth_;  ///< per vertex: interior, nothing sharp at level 1
    mutable detail::PoolVector<std::atomic<detail::QuadRoot*>> roots_;  ///< null until asked for
    mutable std::atomic<std::uint64_t> tree_bytes_{0};
    mutable std::atomic<std::uint64_t> times_forgotten_{0};
};

}  // namespace tetrakis
