#pragma once

#include "cell_norms.hpp"

#include <memory>
#include <mutex>
#include <optional>
#include <vector>

namespace tetrakis::detail {

/// How far a limit surface may be from the mesh of a level over one of its cells (a triangle, or the bilinear patch of
/// a quad), by mask norms: the sum over the points around the cell of how far each is from where the cell's own corners
/// would have it, times a weight (CellNormTable).
///
/// "Where the corners would have it" is the affine or bilinear extension of the cell, where the rules around it
/// reproduce that (on a regular lattice, so the bound falls with the square of the cell), and else the first corner
/// (around an extraordinary point: it falls with the cell).
class CellRemainder {
  public:
    /// @param scheme   refines triangles or quads by face split
    /// @param options  must live as long
    CellRemainder(const SchemeInfo& scheme, const RuleOptions& options);

    /// Corners of a cell.
    int corners() const { return corners_; }
    /// Rings of faces around a cell that its norms depend on.
    int rings() const { return rings_; }

    /// Of a cell at the middle of a fan: its bound is at most `sum` times the farthest point around it from where the
    /// corners would have it: in their plane (quads: their bilinear patch) or, where not `linear`, at the first corner.
    struct Total {
        double sum;
        bool linear;
    };
    /// Nothing where there is no bound.
    std::optional<Total> total(const FanShape& shape) const;

    /// nullptr where there are none. From any thread.
    const CellNorms* find(const SurroundingsKey& key) const { return table_.find(key); }

  private:
    int corners_, rings_;
    CellNormTable table_;
};

/// The cells of a mesh that have norms. Each is looked for when it is first asked for, from any thread.
class NormedCells {
  public:
    /// @param mesh   of one level, with all that is within rings() + 1 rings of the cells that are asked for; lives
    ///               longer
    /// @param level  of the cells. On the first two, norms are for regular cells alone: around the others nearly each
    ///               has surroundings of its own, and a cell two levels down costs far less than to find norms.
    NormedCells(const CellRemainder& remainder, const RuleMesh& mesh, int level);

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

    const CellRemainder& remainder_;
    const RuleMesh& mesh_;
    bool regular_only_;
    std::vector<int> near_;             ///< per vertex: the one extraordinary point near it, k_none or k_many
    std::unique_ptr<Entry[]> entries_;  ///< per face
};

}  // namespace tetrakis::detail
