#pragma once

#include "../base/ids.hpp"
#include "../forest/site.hpp"

#include <compare>
#include <cstdint>
#include <span>
#include <vector>

namespace tetrakis {

/// Address of a vertex of a dual scheme: a cell of the vertex quadtrees. The roots are the vertices of scheme level 1,
/// in their order there: first the corners of faces, then the points along boundaries and creases. So root h of a face
/// corner is the corner cell Q(h) of half-edge h with its axes. A vertex has four children, the children of its cell:
/// level l is scheme level l + 1.
///
/// A vertex on a crease has a cell on each side of the crease, and lies on the border of each. Children on that border
/// are again one vertex for both sides. The cell on the first side has the vertex's number; the other cells are
/// numbered after all vertices. A semi-sharp crease is treated like any other.
struct VertexCell {
    std::uint32_t root = 0;
    LatticePoint at;  ///< lower corner, 0 <= x, y < 2^level
    std::uint8_t level = 0;
    friend constexpr auto operator<=>(const VertexCell&, const VertexCell&) = default;
};

/// The roots of vertex quadtrees and their connections. Corners 0 to 3 of a cell are (0, 0), (N, 0), (N, N), (0, N).
/// Side s runs from corner s to corner s + 1; for the cell across it the direction is reversed.
struct VertexRoots {
    static constexpr std::uint32_t outside = 0xFFFF'FFFFu;

    /// Four per root: 4 * root + side of the root across each side; `outside` if the surface ends. On a crease: the
    /// side of the same vertex's cell across the crease.
    std::vector<std::uint32_t> link;
    std::vector<std::uint8_t> crease;  ///< per root: bit s is set if side s is on a crease
    std::vector<FaceId> face;          ///< per root: its control face
    std::vector<std::uint8_t> hole;    ///< per root: whether that face is not part of the surface
    /// Per root: the half-edge at side 0, in the mesh of the roots as quads.
    std::vector<std::uint32_t> net_halfedge;

    std::uint32_t count() const { return static_cast<std::uint32_t>(face.size()); }

    /// The cell of the same level across a side.
    struct Across {
        enum class Kind { neighbour, other_side_of_crease, outside } kind;
        VertexCell cell;
        int side;  ///< number of the common side in that cell
    };
    Across across(const VertexCell& cell, int side) const;

    /// The cells of a cell's vertex: this cell, then the cells on the other sides of creases.
    std::vector<VertexCell> sides(const VertexCell& cell) const;

    struct Corner {
        VertexCell cell;
        int corner;
        friend bool operator==(const Corner&, const Corner&) = default;
    };
    /// The cells that meet at a corner, counter-clockwise; if they close, starting with the given cell.
    struct Fan {
        std::vector<Corner> corners;
        bool closed = true;  ///< else the surface ends, or a crease lies, before the first and after the last cell

        /// Whether the level has a face there. It has none where the two ends of a crease of one edge meet.
        bool is_face() const { return closed && corners.size() > 2; }
    };
    Fan fan(const Corner& corner) const;
};

/// A cell as a site, for hierarchies: the root's number replaces the half-edge's, and the lower corner is the point.
inline Site cell_site(const VertexCell& cell) { return {HalfedgeId(cell.root), cell.at, cell.level}; }
std::vector<Site> cell_sites(std::span<const VertexCell> cells);
inline VertexCell site_cell(const Site& site) { return {site.root.value, site.at, site.level}; }

}  // namespace tetrakis
