#pragma once

#include "../base/ids.hpp"
#include "site.hpp"

#include <algorithm>
#include <array>
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
/// semi-sharp crease is one like all others here: from where it is smooth, cells on its border do not exist.
struct VertexCell {
    std::uint32_t root = 0;
    LatticePoint at;  ///< lower corner, 0 <= x, y < 2^level
    std::uint8_t level = 0;
    friend constexpr auto operator<=>(const VertexCell&, const VertexCell&) = default;
};

/// How a vertex is split where not all of its creases are as sharp any more as its cells know: some of their children
/// do not exist, and others lie beside each other in their place.
struct VertexJoint {
    /// A side of a child of one of the vertex' cells.
    struct Place {
        std::uint32_t cell;
        std::uint8_t child, side;
    };
    struct Child {
        bool exists = false;
        std::uint8_t crease = 0;                    ///< as VertexRoots::crease
        std::array<std::uint8_t, 4> smooth_from{};  ///< as VertexRoots::smooth_from
    };
    std::vector<VertexCell> cells;               ///< all of the vertex, of one level
    std::vector<std::array<Child, 4>> children;  ///< of each
    std::vector<std::array<Place, 2>> joined;    ///< sides of children beside each other
    /// A side of a child, and that of one that does not exist, in whose place it is.
    std::vector<std::array<Place, 2>> in_place;
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

    static constexpr std::uint8_t never = 0xFF;
    /// 4 per root: along a crease, the level from which on the vertices on it are split as smooth ones. A cell with one
    /// such side then has two children, and those of both sides lie beside each other.
    std::vector<std::uint8_t> smooth_from;
    std::vector<VertexJoint> joints;  ///< where creases end or meet: vertices that are split in yet other ways
    struct JointCell {
        VertexCell cell;
        std::uint32_t joint, place;  ///< number in `joints`, and there
    };
    std::vector<JointCell> joint_cells;  ///< by cell

    std::uint32_t count() const { return static_cast<std::uint32_t>(face.size()); }
    /// Whether all vertices have four children on each side of their creases.
    bool all_stay() const { return smooth_from.empty(); }
    const JointCell* find_joint(const VertexCell& cell) const {
        const auto found = std::lower_bound(joint_cells.begin(), joint_cells.end(), cell,
                                            [](const JointCell& j, const VertexCell& c) { return j.cell < c; });
        return found != joint_cells.end() && found->cell == cell ? &*found : nullptr;
    }
    /// The cell itself if it is one; else one beside it, of a child that exists where one on the way to it does not.
    VertexCell existing(const VertexCell& cell) const;
};

}  // namespace tetrakis
