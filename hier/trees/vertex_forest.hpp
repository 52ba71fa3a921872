#pragma once

#include "../base/ids.hpp"
#include "tree_forest.hpp"
#include "vertex_roots.hpp"

#include <cstdint>
#include <utility>
#include <vector>

namespace tetrakis {

/// The mesh whose vertices are the leaves of a VertexForest, in (root, path) order. It depends on the set of leaves
/// alone.
struct DualFaces {
    /// A vertex and one of its leaves.
    struct LeafOfVertex {
        std::uint32_t vertex;
        LeafId leaf;
    };

    /// A leaf at a face: the face is at a corner of its cell or, if the leaf is coarser, in the middle of a side.
    struct Corner {
        static constexpr std::uint8_t k_on_side = 4;  ///< plus the number of the side

        LeafId leaf;  ///< on a crease, the leaf on the face's side
        std::uint8_t at;
    };

    std::vector<std::uint32_t> face_offsets{0};  ///< F + 1
    std::vector<std::uint32_t> face_vertices;    ///< numbers into `cells`, counter-clockwise
    std::vector<FaceId> control_faces;           ///< per face
    /// Per face: whether a quad's diagonal in the 4-8 pattern starts at its first vertex (else at its second).
    std::vector<std::uint8_t> diagonal_at_first;
    std::vector<VertexCell> cells;  ///< per vertex; on a crease, the cell on the side with the lowest root
    std::vector<LeafId> leaves;     ///< per vertex; on a crease as for `cells`
    std::vector<Corner> corners;    ///< per face corner, if asked for
    std::vector<LeafOfVertex>
        other_sides;  ///< for vertices on creases: the leaves that are not in `leaves`, in the order of leaves
};

enum class FaceCorners {
    vertices,  ///< DualFaces::face_vertices alone
    leaves,    ///< DualFaces::corners as well
};

/// The rule of a dual scheme's cells: child k has corner k of its parent. flags: the sides on creases, as in
/// VertexRoots::crease; a vertex there has a cell on each side of the crease.
struct DualCells {
    static constexpr int k_sides = 4;
    static constexpr const char* k_name = "cell";
    static constexpr bool k_midpoints = false, k_creases = true;
    struct Points {};

    /// A child touches the next and the previous child across the sides between them.
    static constexpr std::pair<int, int> inside(int child, int side) {
        if (side == (child + 1) % 4) return {side, (side + 2) % 4};
        if (side == (child + 2) % 4) return {(child + 3) % 4, (side + 2) % 4};
        return {4, side};
    }
    static TreeFrame child_frame(const TreeFrame& parent, int child) {
        return {parent.root,
                {2 * parent.at.x + (child == 1 || child == 2 ? 1 : 0), 2 * parent.at.y + (child >= 2 ? 1 : 0)},
                static_cast<std::uint8_t>(parent.level + 1),
                // A child lies at two of its parent's sides.
                static_cast<std::uint8_t>(parent.flags & (1u << child | 1u << (child + 3) % 4))};
    }
    std::uint32_t root_count() const { return roots.count(); }
    static bool has_root(std::uint32_t) { return true; }
    TreeFrame root_frame(std::uint32_t root) const { return {root, {0, 0}, 0, roots.crease[root]}; }
    std::uint32_t root_link(std::uint32_t root, int side) const {
        return roots.link[4 * std::size_t{root} + static_cast<std::size_t>(side)];
    }
    std::uint64_t memory_bytes() const {
        return (roots.link.capacity() + roots.net_halfedge.capacity()) * sizeof(std::uint32_t) +
               roots.face.capacity() * sizeof(FaceId) + roots.crease.capacity() + roots.hole.capacity();
    }

    VertexRoots roots;
};

/// Restricted quadtrees of vertices, for dual schemes: a vertex is a cell, and refining it replaces it by its four
/// children.
///
/// The mesh is the dual of the cells: a vertex for each leaf, an edge for each side that two leaves share, a face for
/// each point where leaves meet. Four equal leaves make a quad; if a corner of two leaves lies on the side of a coarser
/// one, the face is a triangle. There are no cracks and no cuts, only other faces. A face belongs to the control face
/// of most of its leaves (a coarser one counts twice), or the lowest such face of several. Faces of holes are left out.
///
/// On a crease a vertex has a leaf on each side. These leaves are one vertex of the mesh, and are split and merged
/// together, so both sides have the same vertices there.
///
/// Storage: 19 bytes a leaf.
class VertexForest : public TreeForest<DualCells> {
  public:
    /// Starts with the roots as leaves. O(roots).
    explicit VertexForest(VertexRoots roots);

    const VertexRoots& roots() const { return rule_.roots; }
    VertexCell cell(LeafId leaf) const { return cell(frame(leaf.value)); }
    static VertexCell cell(const TreeFrame& frame) { return {frame.root, frame.at, frame.level}; }
    /// The leaf of the same vertex across a side that is on a crease; invalid if the side is on none.
    LeafId across_crease(LeafId leaf, int side) const {
        return is_crease(leaf.value, side) ? LeafId(beyond(leaf.value, side).slot) : LeafId{};
    }
    /// The leaf with the lowest root among the leaves of the same vertex; the leaf itself if it is on no crease.
    LeafId vertex_leaf(LeafId leaf) const;
    /// Appends the other leaves of the same vertex: none if the leaf is on no crease.
    void add_other_sides(LeafId leaf, std::vector<LeafId>& leaves) const;
    /// Appends the leaves around a corner of a leaf, this leaf included, counter-clockwise: the vertices of the face
    /// there. Appends nothing if the surface ends or a crease lies there.
    void add_leaves_around(LeafId leaf, int corner, std::vector<LeafId>& leaves) const;
    /// The output mesh. O(leaves).
    DualFaces faces(FaceCorners corners = FaceCorners::vertices) const;

  private:
    /// The leaf at a corner of a node's cell.
    std::uint32_t leaf_at(std::uint32_t slot, int corner) const {
        while (is_split(slot)) slot = first_child(child_[slot]) + static_cast<std::uint32_t>(corner);
        return slot;
    }

    /// One step counter-clockwise around the point at a leaf's corner, across the side that ends there.
    struct Turn {
        std::uint32_t slot;    ///< the next leaf with a corner at the point; k_boundary if the surface ends
        int corner;            ///< that corner
        std::uint32_t coarse;  ///< a leaf passed on the way, with the point in the middle of a side; k_boundary: none
        int coarse_side;       ///< that side
    };
    Turn turn(std::uint32_t slot, int corner) const;
};

extern template class TreeForest<DualCells>;

}  // namespace tetrakis
