#pragma once

#include "../../schemes/core/sector_fan.hpp"
#include "../../schemes/core/stencil_table.hpp"

#include <array>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <vector>

namespace tetrakis::detail {

/// A limit as combinations of a mesh's points; tangents t1 x t2 outwards, a pair for each side of a crease.
struct LimitRows {
    StencilRow limit;
    std::vector<std::array<StencilRow, 2>> tangents;
};

/// The limits of the vertices about an extraordinary point (dual: a face) that has only regular mesh around it: one set
/// of masks per valence, as points of the fan around it.
class FanLimits {
  public:
    /// Rows of some vertices of a mesh, the long way.
    using FindRows = std::function<std::vector<std::optional<LimitRows>>(const RuleMesh&, std::span<const int>)>;

    /// @param reach  of the mask of regular vertices: who is farther than this from the point is one of them
    /// @param rings  that a limit depends on at most; and that the meshes of find() have around each vertex
    FanLimits(FanLattice lattice, int reach, int rings, FindRows rows);

    /// Fills the rows of those of the vertices that it finds beside such a point. A row depends on the surroundings of
    /// its vertex alone.
    /// @param regular  per vertex of the mesh: smooth, inside, and all its faces are those of the regular mesh
    void find(const RuleMesh& mesh, std::span<const unsigned char> regular, std::span<const int> vertices,
              std::span<std::optional<LimitRows>> rows);

  private:
    struct Masks {
        std::optional<FanLabels> labels;  ///< those that the masks weigh, and a ring more
        int near = 0;                     ///< the first labels, which have rows
        std::vector<std::optional<LimitRows>> rows;
    };
    const Masks& masks(int valence);
    std::vector<int> start(const RuleMesh& mesh, int centre) const;
    bool alone(const RuleMesh& mesh, std::span<const unsigned char> regular, std::span<const int> start,
               const FanLabels& labels, std::span<const int> fan) const;

    FanLattice lattice_;
    int reach_, rings_, size_, valence_;  // of the regular mesh's faces and vertices
    FindRows rows_;
    std::map<int, Masks> masks_;
};

}  // namespace tetrakis::detail
