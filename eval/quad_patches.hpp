#pragma once

#include "tetrakis/eval/bicubic.hpp"
#include "tetrakis/eval/cell_facts.hpp"
#include "tetrakis/eval/quad_local_mesh.hpp"
#include "tetrakis/eval/quad_star.hpp"
#include "tetrakis/eval/surface_point.hpp"
#include "tetrakis/hier/control_mesh.hpp"
#include "tetrakis/hier/site.hpp"

#include <atomic>
#include <memory>
#include <vector>

namespace tetrakis {

namespace detail {

struct QuadQuarters;

/// One cell of a patch tree. Regular cells are leaves: one bicubic patch (or a single-crease patch); the others grow
/// four children on demand.
struct QuadNode {
    enum class Kind : std::uint8_t { regular, star, generic };
    Kind kind = Kind::regular;
    std::uint8_t turn = 0;  ///< star: the corner of the cell that is extraordinary
    std::uint8_t depth = 0;
    SideCrease crease;
    std::atomic<QuadQuarters*> quarters{nullptr};
    Net16 net;
    const QuadStar* star = nullptr;    ///< its own, or one of its parent's quarters
    const CellFacts* facts = nullptr;  ///< of smooth regular cells below a root
    std::array<Vec3d, 4> corner;       ///< limit positions, where the parent has told them (of irregular cells)
    bool has_corners = false;
    std::unique_ptr<QuadStar> own_star;
    std::unique_ptr<QuadLocalMesh> local;

    QuadNode() = default;
    QuadNode(const QuadNode&) = delete;
    QuadNode& operator=(const QuadNode&) = delete;
    ~QuadNode();
    /// The four quarters, index 2 * qy + qx, grown at the first call; every thread would build the same bits.
    const QuadNode* grown() const;
    /// Limit positions at (column / 2, row / 2), number 3 * row + column, of an irregular cell; grows it.
    const std::array<Vec3d, 9>& points() const;
    /// Becomes a star cell.
    void adopt(std::unique_ptr<QuadStar> from);
};

/// What a node grows, in one block.
struct QuadQuarters {
    std::array<QuadNode, 4> cell;
    std::array<CellFacts, 4> facts;
    std::array<Vec3d, 9> point;  ///< QuadNode::points()
    QuadStar star;               ///< of the one quarter that is a star, where the parent is one
};

/// Corner k of a cell as a number of its nine points, and the middle of the side from corner k to k + 1.
constexpr int k_corner_point[4] = {0, 2, 8, 6};
constexpr int k_side_point[4] = {1, 5, 7, 3};
constexpr int k_centre_point = 4;

/// Turns a local mesh into the simplest node that represents it exactly.
void classify(QuadLocalMesh mesh, QuadNode& node);

}  // namespace detail

/// The patch tree of Catmull-Clark (DESIGN 3.3): exact evaluation of the limit surface anywhere. One tree per corner
/// cell; leaves are regular bicubic patches, boundary and crease patches included; it grows lazily, towards irregular
/// places only. Thread-safe; a result depends on its arguments alone. Sources: Stam 1998 (extraordinary points);
/// Niessner et al. 2012 (single-crease patches), in closed form here.
class QuadPatches {
  public:
    /// O(H). @throws Error memory_limit where the context's limit would be exceeded.
    explicit QuadPatches(const ControlMesh& mesh, const RunContext& context = {});
    ~QuadPatches();

    const ControlMesh& mesh() const { return mesh_; }

    /// The limit surface at parameters (x, y) in [0, 1]^2 of the corner cell of `root` (derivatives by x and y).
    SurfacePoint evaluate(HalfedgeId root, double x, double y) const { return evaluate(root, x, y, true); }
    /// The same without second derivatives: cheaper, and the same bits.
    SurfacePoint frame(HalfedgeId root, double x, double y) const { return evaluate(root, x, y, false); }
    /// The limit position at a lattice point of the cell, level <= k_max_level; about the cost of one patch.
    Vec3d limit(HalfedgeId root, LatticePoint at, int level) const;

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
    detail::QuadLocalMesh local_mesh(HalfedgeId root) const;

    const ControlMesh& mesh_;
    std::vector<Vec3d> first_;           ///< level-1 points: vertices, edges, faces (scratch of the construction)
    std::vector<float> half_sharpness_;  ///< per half-edge, level 1: of the half at its origin
    std::vector<float> vertex_sharpness_;
    std::vector<std::uint8_t> smooth_;  ///< per vertex: interior, nothing sharp at level 1
    std::vector<detail::QuadNode> roots_;
};

}  // namespace tetrakis
