#pragma once

#include "../../hier/base/run_context.hpp"
#include "../../hier/trees/vertex_forest.hpp"
#include "../surface/triangle_mesh.hpp"

#include <array>
#include <functional>
#include <span>
#include <utility>
#include <vector>

namespace tetrakis::detail {

/// The triangle mesh of a vertex forest's leaves, with the triangles of the faces around each of its vertices.
struct DualTriangles {
    DualFaces faces;                          ///< triangles
    std::vector<std::uint32_t> around;        ///< per vertex, concatenated: triangles of the dual faces that it is in
    std::vector<std::uint32_t> around_begin;  ///< V + 1 numbers into `around`
    /// Per vertex its neighbours along the mesh's boundary; itself where there is none.
    std::vector<std::array<std::uint32_t, 2>> beside;

    /// All leaves with their vertices; a vertex on a crease has one leaf on each side.
    std::vector<DualFaces::LeafOfVertex> leaves() const;
    std::uint32_t vertex_count() const { return static_cast<std::uint32_t>(faces.cells.size()); }
    std::uint32_t triangle_count() const { return static_cast<std::uint32_t>(faces.control_faces.size()); }
    std::array<std::uint32_t, 3> triangle(std::uint32_t t) const {
        return {faces.face_vertices[3 * std::size_t{t}], faces.face_vertices[3 * std::size_t{t} + 1],
                faces.face_vertices[3 * std::size_t{t} + 2]};
    }
};
DualTriangles dual_triangles(const VertexForest& forest);

/// Appends the cells that a cell has `bits` levels down, row by row.
void add_cells_below(const VertexCell& cell, int bits, std::vector<VertexCell>& cells);

/// Errors of leaves, by samples: limit points of the cells two levels below each leaf show how far the surface is from
/// the mesh between vertices. They are computed on demand, in large batches, and cached.
class DualLeafErrors {
  public:
    static constexpr int k_bits = 2;  ///< levels from a leaf down to its samples

    /// limits(sites, points) finds the limit positions of cells, written as sites (cell_site()).
    using Limits = std::function<void(std::span<const Site>, std::span<Vec3d>)>;
    explicit DualLeafErrors(Limits limits) : limits_(std::move(limits)) {}

    /// Limit positions of the mesh's vertices.
    std::vector<Vec3d> positions(const VertexForest& forest, const DualTriangles& mesh,
                                 const std::function<void(double)>& report) const;
    /// Per leaf in `asked`: distance of the surface over its cell from the triangles around it, and along the boundary
    /// from the mesh's boundary.
    std::vector<double> errors(const VertexForest& forest, const DualTriangles& mesh, std::span<const Vec3d> positions,
                               std::span<const DualFaces::LeafOfVertex> asked,
                               const std::function<void(double)>& report);

  private:
    /// Limit positions of cells, block by block.
    void evaluate(std::span<const VertexCell> cells, std::span<Vec3d> points,
                  const std::function<void(double)>& report) const;

    static constexpr std::size_t k_below = std::size_t{1} << (2 * k_bits);  ///< cells below a leaf
    Limits limits_;
    std::vector<std::uint32_t> place_;  ///< by leaf slot: number of its block of k_below points in `points_`
    std::vector<Vec3d> points_;         ///< of the cells below leaves, row by row, k_below each
};

}  // namespace tetrakis::detail
