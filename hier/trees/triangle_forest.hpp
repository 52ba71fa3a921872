#pragma once

#include "../forest/corner_cell.hpp"
#include "../forest/exported_triangles.hpp"
#include "../forest/site.hpp"
#include "../mesh/control_mesh.hpp"
#include "tree_forest.hpp"

#include <array>
#include <cstdint>
#include <utility>

namespace tetrakis {

/// The output triangles of a leaf: the leaf itself if no edge has a hanging midpoint, else its conforming (green)
/// subdivision. With three hanging midpoints these are the four triangles of its split.
struct GreenTriangles {
    int count = 0;  ///< 1 to 4
    std::array<CellTriangle, 4> cell;
};

/// The rule of red triangles: child k < 3 has corner k of its parent, and child 3 is the middle one, whose corner k is
/// opposite corner k. So edge k (from corner k to corner k + 1) of every triangle is parallel to side k of its root.
struct RedTriangles {
    static constexpr int k_sides = 3;
    static constexpr const char* k_name = "triangle";
    static constexpr bool k_midpoints = true, k_creases = false;
    using Points = std::array<std::uint32_t, 6>;
    // The next and the previous corner or edge of a triangle.
    static constexpr std::array<int, 3> k_next = {1, 2, 0}, k_previous = {2, 0, 1};

    /// @throws Error  unsupported: a face is not a triangle
    explicit RedTriangles(const ControlMesh& mesh);

    /// The middle child's edge e is the inner edge of the child at the corner that e does not touch.
    static constexpr std::pair<int, int> inside(int child, int edge) {
        if (child == 3) return {k_previous[static_cast<std::size_t>(edge)], edge};
        return {edge == k_next[static_cast<std::size_t>(child)] ? 3 : 4, edge};
    }
    /// flags: 1 if the triangle is reversed, so that its corners 1 and 2 lie at -x and -y from corner 0.
    static TreeFrame child_frame(const TreeFrame& parent, int child) {
        const std::uint32_t step = parent.flags != 0 ? ~std::uint32_t{0} : 1;
        return {parent.root,
                {2 * parent.at.x + (child == 1 || child == 3 ? step : 0),
                 2 * parent.at.y + (child == 2 || child == 3 ? step : 0)},
                static_cast<std::uint8_t>(parent.level + 1),
                static_cast<std::uint8_t>(child == 3 ? parent.flags ^ 1 : parent.flags)};
    }
    static std::array<std::uint32_t, 3> child_corners(const Points& p, int child) {
        switch (child) {
            case 0:
                return {p[0], p[3], p[5]};
            case 1:
                return {p[3], p[1], p[4]};
            case 2:
                return {p[5], p[4], p[2]};
            default:
                return {p[4], p[5], p[3]};
        }
    }
    std::uint32_t root_count() const { return mesh->face_count(); }
    bool has_root(std::uint32_t face) const { return !mesh->is_hole(FaceId(face)); }
    static TreeFrame root_frame(std::uint32_t face) { return {face, {0, 0}, 0, 0}; }
    std::uint32_t root_link(std::uint32_t face, int edge) const {
        const std::uint32_t twin = mesh->twin(HalfedgeId(3 * face + static_cast<std::uint32_t>(edge))).value;
        return twin != HalfedgeId::none && has_root(twin / 3) ? 4 * (twin / 3) + twin % 3 : 0xFFFF'FFFFu;
    }
    std::array<std::uint32_t, 3> root_corners(std::uint32_t face) const {
        const std::uint32_t h = 3 * face;
        return {mesh->origin(HalfedgeId(h)).value, mesh->origin(HalfedgeId(h + 1)).value,
                mesh->origin(HalfedgeId(h + 2)).value};
    }
    Site midpoint_site(const TreeFrame& frame, int edge) const;
    static std::uint64_t memory_bytes() { return 0; }

    const ControlMesh* mesh;
};

/// Restricted triangle quadtrees over a triangle mesh, with conforming (red-green) closure; one root per face.
///
/// A leaf beside split neighbours has hanging midpoints; the output has two or three green triangles for it. With three
/// hanging midpoints it has the four triangles of the leaf's split; that split only changes what can be refined next.
/// So four siblings can be merged if no leaf beside their parent is two levels finer. Faces that are holes have no
/// leaves; edges towards them act as boundary.
///
/// Storage: 25 bytes a leaf, and a site of 16 bytes per point. Points are reused after a merge; until then, handles of
/// leaves and points that are gone are recognised.
class TriangleForest : public TreeForest<RedTriangles> {
  public:
    /// One leaf per face that is no hole. Keeps a reference to the mesh. O(H).
    /// @throws Error  unsupported: a face is not a triangle (triangulate() makes such a mesh)
    explicit TriangleForest(const ControlMesh& mesh);
    explicit TriangleForest(const ControlMesh&&) = delete;

    const ControlMesh& mesh() const { return *rule_.mesh; }
    FaceId face(LeafId leaf) const { return FaceId(root_of(leaf.value)); }
    CellTriangle triangle(LeafId leaf) const { return triangle(frame(leaf.value)); }
    static CellTriangle triangle(const TreeFrame& frame);
    std::array<PointId, 3> points(LeafId leaf) const;
    /// The midpoints that hang on edges 0, 1, 2 of a leaf; invalid if there is none.
    std::array<PointId, 3> hanging_points(LeafId leaf) const;
    /// The output triangles of a leaf. With hanging points, their lattice level is one above the leaf's.
    GreenTriangles green_triangles(LeafId leaf) const;

    /// Points are numbered below this; the control vertices come first, by their numbers.
    std::uint32_t point_slots() const { return static_cast<std::uint32_t>(sites_.size()); }
    bool is_point(PointId point) const { return point.value < sites_.size() && sites_[point.value].root.valid(); }
    std::uint32_t point_count() const { return point_count_; }
    /// The canonical site of a point; its root is invalid if the point does not exist.
    const Site& point_site(PointId point) const { return sites_[point.value]; }
    /// The canonical site of a leaf's corner, found from its address.
    Site corner_site(LeafId leaf, int corner) const {
        const CellTriangle t = triangle(leaf);
        return canonical_triangle_site(mesh(), {t.root, t.corner[static_cast<std::size_t>(corner)], t.level});
    }

    /// The output mesh. O(leaves).
    ExportedTriangles exported() const;

  private:
    unsigned hanging_mask(std::uint32_t slot) const;
};

extern template class TreeForest<RedTriangles>;

}  // namespace tetrakis
