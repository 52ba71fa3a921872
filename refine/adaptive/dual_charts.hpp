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

/// UVs of the meshes of vertex quadtrees, by the same scheme on the charts. These are cut along their seams and
/// continued straight across them (detail::SeamExtension). Each cell of the surface has a cell in its chart. A face
/// across a seam takes the UVs of one side: of the side with most of its corners, else of the lower control face. Its
/// other corners get UVs of the chart's continuation. If all leaves have one level, these are the UVs of refine(),
/// except in some faces where a seam leaves a crease and no rule chooses the side.
class DualCharts {
  public:
    /// @param mesh   must have UVs
    /// @param roots  roots of the surface, by the same scheme and rules
    /// @throws Error  unsupported: the charts lack vertices of the surface, for example if a seam runs along a crease
    ///                that ends inside; invalid_input: the extended charts are no mesh
    DualCharts(const ControlMesh& mesh, const SchemeInfo& scheme, const RuleOptions& rules, const VertexRoots& roots,
               const RunContext& context = {});

    /// @param faces  faces of the forest, with their corners; a face across a seam is assigned to the control face
    ///               whose UVs it gets
    /// @param limit  whether to take the limits; else the points of the net, each at its leaf's level
    /// @throws Error  unsupported: a chart's continuation is too short for a face, or a vertex has no limit
    detail::FaceUvs uvs(const VertexForest& forest, DualFaces& faces, bool limit) const;

  private:
    class Follower;

    void find_roots(const VertexRoots& roots);

    std::unique_ptr<const ControlMesh> charts_;
    VertexRoots roots_;  ///< roots of the charts
    std::shared_ptr<const LevelSource> points_;
    std::vector<std::uint32_t> root_;  ///< for each root of the surface, its root in the charts
};

namespace detail {

/// Cuts quads along their diagonal in the 4-8 pattern, larger faces into fans. Leaves `diagonal_at_first` and `corners`
/// without meaning.
/// @param face_uvs  one number per face corner, cut in the same way; may be null
void cut_into_triangles(DualFaces& faces, std::vector<std::uint32_t>* face_uvs = nullptr);

}  // namespace detail

}  // namespace tetrakis
