#pragma once

#include "../../schemes/core/sector_fan.hpp"
#include "../../schemes/core/stencil_table.hpp"

#include <cstddef>
#include <optional>
#include <span>
#include <utility>
#include <vector>

namespace tetrakis::detail {

/// The limit of a scheme's regular vertices, whose surroundings are all alike: one mask for all of them, its points
/// found by a walk over the lattice. Regular is a smooth vertex inside, all of whose faces are quads (triangles), four
/// (six) of them; the mask holds where all vertices that it weighs are regular and all between.
class RegularLimit {
  public:
    /// A piece of the regular mesh, `rings` around its middle vertex.
    static RuleMesh lattice_mesh(FanLattice lattice, int rings);
    static int middle(int rings) { return 2 * rings * (rings + 1); }

    /// From the rows of the middle of lattice_mesh(lattice, rings), which they must not reach the rim of.
    /// @param tangents  none or two rows, t1 x t2 outwards
    RegularLimit(FanLattice lattice, int rings, const StencilRow& limit, std::span<const StencilRow> tangents);

    /// How far from the vertex the points are, in rings.
    int radius() const { return radius_; }

    /// The mesh of the calls that follow. O(half-edges).
    void look_at(const RuleMesh& mesh);
    /// Per vertex of that mesh.
    std::span<const unsigned char> regular() const { return regular_; }
    /// Walks around a vertex; whether it has the mask. limit() and tangents() are about this vertex then.
    bool found(const RuleMesh& mesh, int v);

    StencilRow limit() const { return row(limit_); }
    /// t1 x t2 points outwards; both may be missing.
    std::optional<std::pair<StencilRow, StencilRow>> tangents() const;

  private:
    struct Term {
        std::size_t place = 0;
        double weight = 0;
    };
    using Terms = std::vector<Term>;

    bool walk(const RuleMesh& mesh, int v, int radius);
    std::size_t place(int x, int y) const;
    bool inside(int x, int y, int radius) const;
    StencilRow row(const Terms& terms) const;

    int valence_, size_;  ///< of vertices and of faces
    int radius_ = 0, side_ = 0;
    Terms limit_, tangent1_, tangent2_;
    std::vector<unsigned char> regular_;  ///< per vertex of the mesh looked at
    std::vector<int> around_;             ///< vertices by place, as last walked
};

}  // namespace tetrakis::detail
