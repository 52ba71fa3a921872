#pragma once

#include "../../hier/forest/site.hpp"
#include "../../hier/mesh/control_mesh.hpp"
#include "../../hier/trees/vertex_roots.hpp"
#include "../../schemes/core/sector_fan.hpp"

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace tetrakis::detail {

/// A point asked for at a level: by a cell that it is a corner of (dual: in the middle of), and its own place.
struct LevelQuery {
    std::uint32_t root = 0;
    LatticePoint cell, point;
    std::uint8_t level = 0;
};

/// Where its cell comes along the curve through the root's tree, whatever the level: children counter-clockwise, as
/// hierarchies have them.
std::uint64_t curve_place(const LevelQuery& query);

/// @param minimal  at the first level that has the point
/// @throws Error  invalid_input: the scheme is dual, or an address that is none; says which
std::vector<LevelQuery> site_queries(const ControlMesh& mesh, FanLattice lattice, std::span<const Site> sites,
                                     bool minimal);
/// @param roots  how many there are
/// @throws Error  invalid_input: the scheme is not dual, or an address that is none; says which
std::vector<LevelQuery> cell_queries(FanLattice lattice, std::size_t roots, std::span<const VertexCell> cells);

}  // namespace tetrakis::detail
