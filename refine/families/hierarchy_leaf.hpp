#pragma once

#include "../../hier/base/ids.hpp"
#include "../../hier/forest/site.hpp"
#include "../rules/polygon_mesh.hpp"

#include <array>
#include <compare>
#include <cstdint>
#include <vector>

namespace tetrakis {

/// Names a leaf of a Hierarchy: its slot, and a generation that differs for each leaf that the slot has held. A handle
/// is valid until its leaf is split or merged; then it is recognised as stale, even if the slot holds a new leaf.
struct LeafHandle {
    LeafId slot;
    std::uint32_t generation = 0;
    friend constexpr auto operator<=>(const LeafHandle&, const LeafHandle&) = default;
};

/// A node of a hierarchy's trees, leaf or not: its root's number (see the family) and its path. The path lists the
/// number of the child taken at each depth, HierarchyTree::path_bits each, the first one in the most significant bits.
/// Nodes compare by root, then path, a parent before its children.
struct HierarchyNode {
    std::uint32_t root = 0;
    std::uint64_t path = 0;
    std::uint8_t depth = 0;  ///< number of children taken from the root on
    friend constexpr auto operator<=>(const HierarchyNode&, const HierarchyNode&) = default;
};

/// The shape of a family's trees.
struct HierarchyTree {
    int child_count = 2;           ///< children of every split node
    int path_bits = 1;             ///< bits of a path for one child's number
    int max_depth = 0;             ///< no node is deeper; bits(max_depth) <= 64
    std::uint32_t root_bound = 0;  ///< roots are numbered below this; not every number need be a root
    /// Nodes of odd depth have a single child, which adds nothing to the path (family "sqrt3").
    bool halves = false;

    friend bool operator==(const HierarchyTree&, const HierarchyTree&) = default;
    /// Number of bits in the path of a node of this depth.
    int bits(int depth) const { return (halves ? (depth + 1) / 2 : depth) * path_bits; }
    int children_of(const HierarchyNode& node) const { return halves && node.depth % 2 != 0 ? 1 : child_count; }
    HierarchyNode child(const HierarchyNode& node, int k) const {
        const auto depth = static_cast<std::uint8_t>(node.depth + 1);
        if (children_of(node) == 1) return {node.root, node.path, depth};
        return {node.root, node.path | static_cast<std::uint64_t>(k) << (64 - bits(depth)), depth};
    }
    /// The node of `root` with this path, whose last child is in the least significant bits.
    HierarchyNode node(std::uint32_t root, std::uint64_t path, int depth) const {
        return {root, depth == 0 ? 0 : path << (64 - bits(depth)), static_cast<std::uint8_t>(depth)};
    }
    /// The node's path with its last child in the least significant bits.
    std::uint64_t low_path(const HierarchyNode& node) const {
        return node.depth == 0 ? 0 : node.path >> (64 - bits(node.depth));
    }
    /// The parent of a node that is no root.
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
    /// Whether root, depth and path are possible in this tree.
    bool is_valid(const HierarchyNode& node) const {
        if (node.root >= root_bound || node.depth > max_depth) return false;
        const int used = bits(node.depth);
        if (used < 64 && node.path << used != 0) return false;
        for (HierarchyNode n = node; n.depth > 0; n = parent(n))
            if (child_number(n) >= child_count) return false;
        return true;
    }
};

/// Public data of a node. Corners are counter-clockwise; side k runs from corner k to corner k + 1. A node of a dual
/// scheme is a vertex and its own only corner; its four sides are those of its cell (VertexCell).
struct NodeView {
    HierarchyNode node;
    FaceId face;             ///< the control face it belongs to
    std::uint8_t level = 0;  ///< the scheme's first level that has all corners as vertices
    std::uint8_t corner_count = 0;
    std::uint8_t side_count = 0;   ///< 0: as many as corners
    std::array<Site, 4> corner{};  ///< canonical sites

    int sides() const { return side_count != 0 ? side_count : corner_count; }
};

/// Public data of a leaf.
struct LeafView : NodeView {
    LeafHandle leaf;
    /// The vertices at the corners: numbers below Hierarchy::point_slots(). A vertex has the same number as long as it
    /// exists; then the number may be used for another vertex.
    std::array<PointId, 4> point{};
};

/// The leaves across one side of a leaf: none at the boundary and towards holes, two if they are finer.
struct LeafNeighbours {
    std::uint32_t count = 0;
    std::array<LeafHandle, 2> leaf{};
    const LeafHandle* begin() const { return leaf.data(); }
    const LeafHandle* end() const { return leaf.data() + count; }
};

/// A hierarchy's leaves as a mesh without cracks. All arrays but `leaves` and `points` have the same bytes for the same
/// set of leaves, whatever changes led to it and whatever the number of threads.
struct HierarchyMesh {
    PolygonMesh mesh;                ///< materials and groups are those of the control faces; no UVs
    std::vector<Site> sites;         ///< per vertex
    std::vector<FaceId> faces;       ///< per face: its control face
    std::vector<LeafHandle> leaves;  ///< per face; not in the order of Hierarchy::leaves()
    std::vector<PointId> points;     ///< per vertex: its number, as in LeafView::point
};

}  // namespace tetrakis
