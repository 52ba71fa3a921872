#pragma once

#include "../../hier/forest/site.hpp"
#include "../../hier/mesh/control_mesh.hpp"
#include "../../hier/trees/vertex_roots.hpp"
#include "../../schemes/core/scheme_table.hpp"
#include "../rules/limit_point.hpp"

#include <cstdint>
#include <memory>
#include <span>

namespace tetrakis {

/// What an evaluation had to raise.
struct LevelCost {
    std::uint64_t faces = 0;       ///< on all levels together, support included
    std::uint32_t most_faces = 0;  ///< on one level of one block of sites
};

/// Values of any scheme of the table at any vertices of any levels, without the rest of those levels: of each level it
/// raises the faces that lead to the wanted vertices and the rings around them that the masks reach, runs the scheme's
/// own rules on that part, and forgets it again. The control positions are those of uniform refinement, bit for bit.
///
/// Addresses: schemes that split faces, sites of their lattice (Site): quads, where lattice level l is scheme level
/// l + 1 (Catmull-Clark, Kobbelt, bilinear, 4-8, repeated averaging with an even number of steps), or triangles, where
/// it is scheme level l (Loop, Butterfly, midpoint). Dual schemes: cells of the vertex quadtrees (VertexCell).
///
/// It serves where rows do not repeat, and those levels that they begin below (detail::row_points()).
///
/// Results depend on the mesh, the scheme and the address alone, not on the batch, its order or the number of threads.
/// Holes take part in the rules like all other faces. Keeps a reference to the mesh. All calls are const and safe from
/// several threads. Memory: that of one block of addresses per thread (a few MiB), however deep they are.
/// Cost of a vertex where many are side by side in one call, in microseconds: some; with its limit ten, up to a hundred
/// where masks are wide. A vertex alone needs its neighbourhood on every level (some 50 faces each); with a limit, an
/// irregular one or one beside it 8 rings of faces on the last, and steps of these where tags, a boundary or a second
/// extraordinary point are near.
class PartialLevels {
  public:
    /// @throws Error  invalid_input: a mesh that the scheme cannot take; unsupported: a scheme without such addresses
    ///                (sqrt3, honeycomb), a dual scheme whose boundary recedes
    PartialLevels(const ControlMesh& mesh, const SchemeInfo& scheme, const RuleOptions& rules = {});
    PartialLevels(const ControlMesh&&, const SchemeInfo&, const RuleOptions& = {}) = delete;
    ~PartialLevels();
    PartialLevels(PartialLevels&&) noexcept;
    PartialLevels& operator=(PartialLevels&&) noexcept;

    FanLattice lattice() const;  ///< what addresses it takes: Site (triangles, quads) or VertexCell (dual)

    /// Positions in the net of the level that each address is written at: a site of a coarser level is followed to the
    /// level wanted by scaling its coordinates.
    /// @throws Error  invalid_input: spans of different length, an address outside its root
    void control_positions(std::span<const Site> sites, std::span<Vec3d> out, LevelCost* cost = nullptr) const;
    void control_positions(std::span<const VertexCell> cells, std::span<Vec3d> out, LevelCost* cost = nullptr) const;

    /// Limit positions, tangents and normals, by the scheme's masks at the lowest level that has the site. Dual: the
    /// limit of the point at the parameters of the vertex of the cell's own level.
    /// @throws Error  as control_positions(); unsupported: a vertex that the scheme has no limit mask for
    void limits(std::span<const Site> sites, std::span<LimitPoint> out, LevelCost* cost = nullptr) const;
    void limits(std::span<const VertexCell> cells, std::span<LimitPoint> out, LevelCost* cost = nullptr) const;
    /// The net about vertices, at the levels that the addresses are written at: position, mean normal of the faces
    /// around (by area), two directions that span the plane across it.
    void frames(std::span<const Site> sites, std::span<LimitPoint> out) const;
    void frames(std::span<const VertexCell> cells, std::span<LimitPoint> out) const;
    /// Limit positions alone, which those of limits() are.
    void positions(std::span<const Site> sites, std::span<Vec3d> positions) const;
    void positions(std::span<const VertexCell> cells, std::span<Vec3d> positions) const;

    /// Of a dual scheme. O(H) the first time.
    /// @throws Error  unsupported: vertices of level 1 that have no cells (none that are known)
    VertexRoots vertex_roots() const;

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

}  // namespace tetrakis
