#pragma once

#include "../base/ids.hpp"
#include "../forest/site.hpp"

#include <compare>
#include <cstdint>
#include <span>
#include <vector>

namespace tetrakis {

/// Address of a vertex of a dual scheme: a cell of the vertex quadtrees. The roots are the vertices of scheme level 1,
/// by their numbers there: first the corners of faces, so that root h is the corner cell Q(h) of half-edge h with its
/// axes, then the points along boundaries and creases. Each vertex has four children, those of its cell: level l is
/// scheme level l + 1.
///
/// A vertex on a crease has a cell for each side of it, of which it is on the border; the children on that border are
/// again one vertex each for both sides. The first side has the vertex' number, the others come after all vertices. A
/// semi-sharp crease is one like all others.
struct VertexCell {
    std::uint32_t root = 0;
    LatticePoint at;  ///< lower corner, 0 <= x, y < 2^level
    std::uint8_t level = 0;
    friend constexpr auto operator<=>(const VertexCell&, const VertexCell&) = default;
};

/// The roots of vertex quadtrees and how they lie beside each other. Corners 0 to 3 of a cell are (0, 0), (N, 0),
/// (N, N), (0, N); side s runs from corner s to corner s + 1, and the cell beyond it sees it run the other way.
struct VertexRoots {
    static constexpr std::uint32_t outside = 0xFFFF'FFFFu;

    /// 4 per root: 4 * root + side beyond a side; outside where the surface ends. Along a crease: the side of the same
    /// vertex' cell on the crease's other side.
    std::vector<std::uint32_t> link;
    std::vector<std::uint8_t> crease;  ///< per root: bit s is set where side s lies along a crease
    std::vector<FaceId> face;          ///< per root: the control face that it belongs to
    std::vector<std::uint8_t> hole;    ///< per root: whether that is not part of the surface
    /// Per root: the half-edge that side 0 lies along, in the mesh of the roots as quads.
    std::vector<std::uint32_t> net_halfedge;

    std::uint32_t count() const { return static_cast<std::uint32_t>(face.size()); }

    /// A cell of the same level beyond a side.
    struct Across {
        enum class Kind { neighbour, other_side_of_crease, outside } kind;
        VertexCell cell;
        int side;  ///< the common one, seen from there
    };
    Across across(const VertexCell& cell, int side) const;

    /// The cells of a cell's vertex: itself, then those on the other sides of creases.
    std::vector<VertexCell> sides(const VertexCell& cell) const;

    struct Corner {
        VertexCell cell;
        int corner;
        friend bool operator==(const Corner&, const Corner&) = default;
    };
    /// The cells that meet at a corner of one, counter-clockwise; from this one on if they close.
    struct Fan {
        std::vector<Corner> corners;
        bool closed = true;  ///< else the surface ends or a crease runs before the first and after the last

        /// Whether the level has a face there: where the two ends of a crease of one edge meet, it has none.
        bool is_face() const { return closed && corners.size() > 2; }
    };
    Fan fan(const Corner& corner) const;
};

/// A cell written as a site, for hierarchies: the root's number in place of a half-edge's, and the lower corner.
inline Site cell_site(const VertexCell& cell) { return {HalfedgeId(cell.root), cell.at, cell.level}; }
std::vector<Site> cell_sites(std::span<const VertexCell> cells);
inline VertexCell site_cell(const Site& site) { return {site.root.value, site.at, site.level}; }

}  // namespace tetrakis
