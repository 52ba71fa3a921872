#pragma once

#include "../../hier/base/ids.hpp"
#include "../../hier/forest/site.hpp"
#include "../rules/polygon_mesh.hpp"

#include <array>
#include <compare>
#include <cstdint>
#include <vector>

namespace tetrakis {

/// A leaf of a Hierarchy: its slot, and how many leaves the slot held before. A handle stays valid until its leaf is
/// split or merged; after that it is recognised as stale, also when the slot has a new leaf.
struct LeafHandle {
    LeafId slot;
    std::uint32_t generation = 0;
    friend constexpr auto operator<=>(const LeafHandle&, const LeafHandle&) = default;
};

/// A node of a hierarchy's trees, leaf or not: the root's number (see the family), and the children taken from there,
/// HierarchyTree::path_bits each, the first in the most significant bits. Compares by root, then path, a parent
/// before its children.
struct HierarchyNode {
    std::uint32_t root = 0;
    std::uint64_t path = 0;
    std::uint8_t depth = 0;  ///< number of children taken
    friend constexpr auto operator<=>(const HierarchyNode&, const HierarchyNode&) = default;
};

/// The shape of a family's trees.
struct HierarchyTree {
    int child_count = 2;           ///< of every split node
    int path_bits = 1;             ///< that hold a child's number
    int max_depth = 0;             ///< no node is deeper; bits(max_depth) <= 64
    std::uint32_t root_bound = 0;  ///< roots are numbered below this; not all numbers need be roots
    /// Nodes of odd depth have a single child, which adds nothing to the path (family "sqrt3").
    bool halves = false;

    friend bool operator==(const HierarchyTree&, const HierarchyTree&) = default;
    /// Of the path that a node of this depth has.
    int bits(int depth) const { return (halves ? (depth + 1) / 2 : depth) * path_bits; }
    int children_of(const HierarchyNode& node) const { return halves && node.depth % 2 != 0 ? 1 : child_count; }
    HierarchyNode child(const HierarchyNode& node, int k) const {
        const auto depth = static_cast<std::uint8_t>(node.depth + 1);
        if (children_of(node) == 1) return {node.root, node.path, depth};
        return {node.root, node.path | static_cast<std::uint64_t>(k) << (64 - bits(depth)), depth};
    }
    /// The node of a root that has this path, the last child of it in the least significant bits.
    HierarchyNode node(std::uint32_t root, std::uint64_t path, int depth) const {
        return {root, depth == 0 ? 0 : path << (64 - bits(depth)), static_cast<std::uint8_t>(depth)};
    }
    /// Its path in the least significant bits.
    std::uint64_t low_path(const HierarchyNode& node) const {
        return node.depth == 0 ? 0 : node.path >> (64 - bits(node.depth));
    }
    /// Of a node that is no root.
    HierarchyNode parent(const HierarchyNode& node) const {
        const int kept = bits(node.depth - 1);
        return {node.root, kept == 0 ? 0 : node.path & ~std::uint64_t{0} << (64 - kept),
                static_cast<std::uint8_t>(node.depth - 1)};
    }
    /// Which child of its parent the node is.
    int child_number(const HierarchyNode& node) const {
        if (halves && node.depth % 2 == 0) return 0;
        return static_cast<int>(node.path >> (64 - bits(node.depth)) & ((1u << path_bits) - 1));
    }
    /// Whether `above` is a proper ancestor of `node`.
    bool is_ancestor(const HierarchyNode& above, const HierarchyNode& node) const {
        if (above.root != node.root || above.depth >= node.depth) return false;
        const int shared = bits(above.depth);
        return shared == 0 || (above.path ^ node.path) >> (64 - shared) == 0;
    }
    /// Whether the node's numbers are those of a node at all.
    bool is_valid(const HierarchyNode& node) const {
        if (node.root >= root_bound || node.depth > max_depth) return false;
        const int used = bits(node.depth);
        if (used < 64 && node.path << used != 0) return false;
        for (HierarchyNode n = node; n.depth > 0; n = parent(n))
            if (child_number(n) >= child_count) return false;
        return true;
    }
};

/// What can be seen of a node. Corners are counter-clockwise; side k runs from corner k to corner k + 1. A node of a
/// dual scheme is a vertex and its own only corner; its four sides are those of its cell (VertexCell).
struct NodeView {
    HierarchyNode node;
    FaceId face;             ///< the control face it belongs to
    std::uint8_t level = 0;  ///< the scheme's first level that has all corners as vertices
    std::uint8_t corner_count = 0;
    std::uint8_t side_count = 0;   ///< 0: one for each corner
    std::array<Site, 4> corner{};  ///< canonical sites

    int sides() const { return side_count != 0 ? side_count : corner_count; }
};

/// What can be seen of a leaf.
struct LeafView : NodeView {
    LeafHandle leaf;
    /// The corners' vertices: numbers below Hierarchy::point_slots() that a vertex keeps as long as it exists; numbers
    /// of vertices that are gone are used again.
    std::array<PointId, 4> point{};
};

/// The leaves across one side of a leaf: none at the boundary and towards holes, two where they are finer.
struct LeafNeighbours {
    std::uint32_t count = 0;
    std::array<LeafHandle, 2> leaf{};
    const LeafHandle* begin() const { return leaf.data(); }
    const LeafHandle* end() const { return leaf.data() + count; }
};

/// A hierarchy's leaves as a mesh without cracks. All but `leaves` and `points` has the same bytes for the same set of
/// leaves, whatever the history and the number of threads.
struct HierarchyMesh {
    PolygonMesh mesh;                ///< materials and groups are those of the control faces; no UVs
    std::vector<Site> sites;         ///< per vertex
    std::vector<FaceId> faces;       ///< per face: its control face
    std::vector<LeafHandle> leaves;  ///< per face; in an order of their own, not in that of Hierarchy::leaves()
    std::vector<PointId> points;     ///< per vertex: as LeafView::point
};

}  // namespace tetrakis
