#pragma once

#include "../base/ids.hpp"
#include "tree_forest.hpp"
#include "vertex_roots.hpp"

#include <cstdint>
#include <utility>
#include <vector>

namespace tetrakis {

/// The mesh that a VertexForest's leaves are the vertices of, in (root, path) order: the same for the same set of
/// leaves.
struct DualFaces {
    /// A leaf that is a vertex.
    struct LeafOfVertex {
        std::uint32_t vertex;
        LeafId leaf;
    };

    /// A leaf where a face is: by a corner of its cell, or, in a coarser one, in the middle of a side.
    struct Corner {
        static constexpr std::uint8_t k_on_side = 4;  ///< and the number of the side

        LeafId leaf;  ///< on a crease that on the face's side
        std::uint8_t at;
    };

    std::vector<std::uint32_t> face_offsets{0};  ///< F + 1
    std::vector<std::uint32_t> face_vertices;    ///< numbers into `cells`, counter-clockwise
    std::vector<FaceId> control_faces;           ///< per face
    /// Per face whether a quad's diagonal in the 4-8 pattern starts at its first vertex (else at its second).
    std::vector<std::uint8_t> diagonal_at_first;
    std::vector<VertexCell> cells;  ///< per vertex; on creases, of the side with the lowest root
    std::vector<LeafId> leaves;     ///< per vertex; likewise
    std::vector<Corner> corners;    ///< per face corner, where asked for
    std::vector<LeafOfVertex>
        other_sides;  ///< of vertices on creases the leaves on other sides than that of `leaves`, in their order
};

enum class FaceCorners {
    vertices,  ///< DualFaces::face_vertices alone
    leaves,    ///< DualFaces::corners as well
};

/// The rule of a dual scheme's cells: child k keeps corner k. flags: the sides that lie along creases, as
/// VertexRoots::crease; a vertex there has a cell on each side.
struct DualCells {
    static constexpr int k_sides = 4;
    static constexpr const char* k_name = "cell";
    static constexpr bool k_midpoints = false, k_creases = true;
    struct Points {};

    /// A child meets the next one and the one before across the sides that face them.
    static constexpr std::pair<int, int> inside(int child, int side) {
        if (side == (child + 1) % 4) return {side, (side + 2) % 4};
        if (side == (child + 2) % 4) return {(child + 3) % 4, (side + 2) % 4};
        return {4, side};
    }
    static TreeFrame child_frame(const TreeFrame& parent, int child) {
        return {parent.root,
                {2 * parent.at.x + (child == 1 || child == 2 ? 1 : 0), 2 * parent.at.y + (child >= 2 ? 1 : 0)},
                static_cast<std::uint8_t>(parent.level + 1),
                // A child has two of its parent's sides.
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

/// Restricted quadtrees of vertices, for dual schemes: a vertex is a cell, and refining it puts its four children in
/// its place, all together.
///
/// The mesh is the dual of the cells: a vertex for each leaf, an edge for each side that two leaves share, a face for
/// each point where leaves meet. Four equal leaves make a quad; where a corner of two leaves lies on the side of a
/// coarser one, the face is a triangle. It never cracks, because nothing in it is cut: it only has other faces. A face
/// belongs to the control face that most of its leaves do (a coarser one counts twice), the first of several; those of
/// holes are left out.
///
/// Along a crease a vertex has a leaf on each side: these are split and merged together, so that both sides have the
/// same vertices there, and are one vertex of the mesh.
///
/// Storage: 19 bytes a leaf.
class VertexForest : public TreeForest<DualCells> {
  public:
    /// The roots as leaves. O(roots).
    explicit VertexForest(VertexRoots roots);

    const VertexRoots& roots() const { return rule_.roots; }
    VertexCell cell(LeafId leaf) const { return cell(frame(leaf.value)); }
    static VertexCell cell(const TreeFrame& frame) { return {frame.root, frame.at, frame.level}; }
    /// The same vertex' leaf on the other side of the crease along a side; invalid where none runs there.
    LeafId across_crease(LeafId leaf, int side) const {
        return is_crease(leaf.value, side) ? LeafId(beyond(leaf.value, side).slot) : LeafId{};
    }
    /// Of the leaves that are the same vertex, the one of the lowest root; the leaf itself away from creases.
    LeafId vertex_leaf(LeafId leaf) const;
    /// Appends the other leaves that are the same vertex: none away from creases.
    void add_other_sides(LeafId leaf, std::vector<LeafId>& leaves) const;
    /// Appends the leaves around a corner of a leaf, itself among them, counter-clockwise: the vertices of the face
    /// there. Nothing where the surface ends or a crease runs.
    void add_leaves_around(LeafId leaf, int corner, std::vector<LeafId>& leaves) const;
    /// O(leaves).
    DualFaces faces(FaceCorners corners = FaceCorners::vertices) const;

  private:
    /// The leaf at a corner of a cell.
    std::uint32_t leaf_at(std::uint32_t slot, int corner) const {
        while (is_split(slot)) slot = first_child(child_[slot]) + static_cast<std::uint32_t>(corner);
        return slot;
    }

    /// Counter-clockwise around the point at a leaf's corner, across the side that ends there.
    struct Turn {
        std::uint32_t slot;    ///< the next leaf that has a corner there; k_boundary where the surface ends
        int corner;            ///< that corner
        std::uint32_t coarse;  ///< the leaf between, in the middle of whose side the point is; k_boundary: none
        int coarse_side;       ///< that side
    };
    Turn turn(std::uint32_t slot, int corner) const;
};

extern template class TreeForest<DualCells>;

}  // namespace tetrakis
