#pragma once

#include "cell_norms.hpp"

#include <memory>
#include <mutex>
#include <vector>

namespace tetrakis::detail {

/// The cells of a mesh that have norms. Each is looked for when it is first asked for, from any thread.
class NormedCells {
  public:
    /// On the first two levels norms are for regular cells alone: around the others nearly each has surroundings of its
    /// own, and a few cells two levels down cost far less than to find norms.
    /// @param mesh   of one level, with all that is within rings() + 1 rings of the cells that are asked for; lives
    ///               longer
    /// @param level  of the cells; less than 0: there are none yet
    NormedCells(const CellNormTable& norms, const RuleMesh& mesh, int level);

    struct Cell {
        const CellNorms* norms = nullptr;  ///< nullptr: extraordinary points are near each other, or tags semi-sharp
        int first = RuleMesh::none;        ///< half-edge that leaves the cell's first corner
        std::vector<int> points;           ///< vertices of the mesh: those of norms->point
    };
    /// @param halfedge  leaves the first corner, if nothing speaks for another; always the same for a face
    /// @param parts     scratch memory
    const Cell& at(int halfedge, MeshPartFinder& parts) const;

  private:
    struct Entry {
        std::once_flag once;
        Cell cell;
    };
    Cell find(int halfedge, MeshPartFinder& parts) const;

    const CellNormTable& norms_;
    const RuleMesh& mesh_;
    bool regular_only_;
    std::vector<int> near_;             ///< per vertex: the one extraordinary point near it, k_none or k_many
    std::unique_ptr<Entry[]> entries_;  ///< per face
};

}  // namespace tetrakis::detail
