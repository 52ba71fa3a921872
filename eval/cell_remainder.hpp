#pragma once

#include "tetrakis/hier/vec.hpp"
#include "tetrakis/refine/level_walk.hpp"
#include "tetrakis/refine/mesh_part.hpp"
#include "tetrakis/schemes/scheme_table.hpp"

#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <shared_mutex>
#include <span>
#include <vector>

namespace tetrakis::detail {

/// How far a limit surface may be from the mesh of a level over one of its cells (a triangle, or the bilinear patch of
/// a quad), by mask norms: the sum over the points around the cell of how far each is from where the cell's own corners
/// would have it, times the largest size of the point's basis function over the cell.
///
/// "Where the corners would have it" is the affine or bilinear extension of the cell, where the rules around it
/// reproduce that (on a regular lattice, so the bound falls with the square of the cell), and else the first corner
/// (around an extraordinary point: it falls with the cell). The largest size is that on the vertices three levels
/// further down, and what is left below these: the same sum over each of the small cells. These equations between the
/// weights of all surroundings that come up are solved by iteration; that they converge is the proof that the steps
/// contract (the difference schemes of Dyn, Levin, Gregory 1990, with what surrounds the cell in the place of the
/// regular lattice).
class CellRemainder {
  public:
    /// @param scheme   refines triangles or quads by face split
    /// @param options  must live as long
    CellRemainder(const SchemeInfo& scheme, const RuleOptions& options);
    ~CellRemainder();

    /// Corners of a cell.
    int corners() const { return corners_; }
    /// Rings of faces around a cell that its bound depends on.
    int rings() const { return rings_; }

    /// Of a cell at the middle of a fan: its bound is at most `sum` times the farthest point around it from where the
    /// corners would have it: in their plane (quads: their bilinear patch) or, where not `linear`, at the first corner.
    struct Total {
        double sum;
        bool linear;
    };
    /// Nothing where there is no bound.
    std::optional<Total> total(const FanShape& shape) const;

    /// The weights of one kind of surroundings.
    struct Norms {
        std::vector<int> point;  ///< those with a weight, as the surroundings number them; the cell's corners are first
        std::vector<double> weight;
        std::vector<std::array<double, 4>> anchor;  ///< of the cell's corners: where they would have the point
    };
    /// A walk over half-edges to the regular lattice's points: face k is entered across the edge `turns` after the
    /// half-edge by which face `from` was.
    struct Walk {
        struct Face {
            int from, turns;
        };
        struct Point {
            int face, turns;
        };
        std::vector<Face> faces;
        std::vector<Point> points;
    };

    /// One level's mesh, for one thread.
    class Level {
      public:
        /// The mesh has all that is within rings() + 1 rings of the cells that are asked for.
        Level(const CellRemainder& remainder, const RuleMesh& mesh, std::span<const Vec3d> points,
              MeshPartFinder& parts);
        /// Of a cell, by the half-edge that leaves its corner 0; infinite where nothing is known: more than one
        /// extraordinary point is near, or something is semi-sharp.
        double operator()(int halfedge);

      private:
        double sum(const Norms& norms, int halfedge, std::span<const int> points) const;

        const CellRemainder& remainder_;
        const RuleMesh& mesh_;
        std::span<const Vec3d> points_;
        MeshPartFinder& parts_;
        std::vector<std::uint8_t> irregular_;  ///< within rings() - 1 rings of such a vertex
        std::vector<int> entry_, found_;
    };

  private:
    /// What is around a cell: its faces in the order of a walk, by their vertices, and what is sharp.
    using Key = std::vector<int>;
    struct Surroundings {
        Key key;
        std::vector<int> vertices;  ///< of the mesh, in the order in which the key numbers them
    };
    struct Draft;

    Key key_of(const FanShape& shape) const;
    std::optional<Surroundings> surroundings(const RuleMesh& mesh, int halfedge, MeshPartFinder& parts) const;
    /// nullptr where there are none.
    const Norms* norms(const Key& key) const;
    RuleMesh mesh_of(const Key& key) const;
    bool is_regular(const RuleMesh& mesh, int vertex) const;
    bool is_simple(const RuleMesh& mesh) const;
    Draft draft(const Key& key) const;
    void solve(std::map<Key, Draft>& drafts) const;
    Walk walk_of(const Key& key, const Norms& norms) const;

    const SchemeInfo& scheme_;
    const RuleOptions& options_;
    int corners_, rings_;
    mutable std::shared_mutex reading_;
    mutable std::mutex writing_;
    mutable std::map<Key, std::unique_ptr<const Norms>> known_;
    const Norms* regular_ = nullptr;
    Walk regular_walk_;
};

}  // namespace tetrakis::detail
