#pragma once

#include "../base/ids.hpp"
#include "../forest/site.hpp"

#include <compare>
#include <cstdint>
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

    std::uint32_t count() const { return static_cast<std::uint32_t>(face.size()); }
};

}  // namespace tetrakis
