#pragma once

#include "../../hier/base/vec.hpp"
#include "../../hier/mesh/control_mesh.hpp"
#include "../../hier/trees/vertex_forest.hpp"
#include "../../schemes/core/scheme_table.hpp"
#include "../attributes/uv_mesh.hpp"
#include "../points/level_source.hpp"

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace tetrakis {

/// UVs of the meshes that vertex quadtrees make: the same scheme on the charts, which are cut along their seams and go
/// on straight beyond them (detail::SeamExtension). Each cell of the surface has its own in its chart. A face across a
/// seam takes the UVs of one side, the one with the most of its corners, then the one of the lower control face; beyond
/// the seam those of the cells that the chart goes on with. Where all leaves are of one level these are the UVs of
/// refine() (but for a choice of sides that no rule makes, in some faces where a seam leaves a crease).
class DualCharts {
  public:
    /// @param mesh   must have UVs
    /// @param roots  of the surface, by the same scheme and rules
    /// @throws Error  unsupported: the charts do not have all the vertices that the surface has, as where a seam runs
    ///                along a crease that ends inside; invalid_input: the extended charts are no mesh
    DualCharts(const ControlMesh& mesh, const SchemeInfo& scheme, const RuleOptions& rules, const VertexRoots& roots,
               const RunContext& context = {});

    /// @param faces  of the forest, with their corners; a face across a seam comes to belong to the control face whose
    ///               UVs it has
    /// @param limit  of the limits; else of the net, each at its leaf's level
    /// @throws Error  unsupported: a chart does not go on beyond a seam as far as a face reaches, or there is no limit
    detail::FaceUvs uvs(const VertexForest& forest, DualFaces& faces, bool limit) const;

  private:
    class Follower;

    void find_roots(const VertexRoots& roots);

    std::unique_ptr<const ControlMesh> charts_;
    VertexRoots roots_;  ///< of the charts
    std::shared_ptr<const LevelSource> points_;
    std::vector<std::uint32_t> root_;  ///< of the charts, for each of the surface
};

namespace detail {

/// Cuts quads along the diagonal in the 4-8 pattern, larger faces into fans. Without `diagonal_at_first` and `corners`
/// afterwards.
/// @param face_uvs  if not null, cut alike: a number per face corner
void cut_into_triangles(DualFaces& faces, std::vector<std::uint32_t>* face_uvs = nullptr);

}  // namespace detail

}  // namespace tetrakis
