#pragma once

#include "../../hier/base/run_context.hpp"
#include "../../hier/mesh/control_mesh.hpp"
#include "../../hier/trees/vertex_forest.hpp"
#include "../../schemes/core/scheme_table.hpp"
#include "../points/level_source.hpp"
#include "../rules/polygon_mesh.hpp"

namespace tetrakis {

struct DualMeshOptions {
    bool limit = true;       ///< vertices on the limit surface; else each in the net of its own level
    bool normals = false;    ///< of the limit surface
    bool triangles = false;  ///< cut the faces: quads in the 4-8 pattern
    bool uvs = false;        ///< of the mesh's, where it has them: see DualCharts
    RunContext context{};
};

/// Adaptive refinement of a dual scheme (Doo-Sabin, midedge, biquartic, odd repeated averaging): vertex quadtrees, and
/// the scheme's points for their leaves. forest() is refined and coarsened; to_mesh() depends on the set of leaves
/// alone.
class AdaptiveDual {
  public:
    /// The scheme's level 1 as leaves. Keeps a reference to the mesh. O(H).
    /// @throws Error  as vertex_roots()
    AdaptiveDual(const ControlMesh& mesh, const SchemeInfo& scheme, const RuleOptions& rules = {});
    AdaptiveDual(const ControlMesh&&, const SchemeInfo&, const RuleOptions& = {}) = delete;

    VertexForest& forest() { return forest_; }
    const VertexForest& forest() const { return forest_; }
    const LevelSource& points() const { return *points_; }

    /// The leaves as a mesh without cracks: vertices are leaves, edges are the sides that two of them share, faces the
    /// points where they meet. Materials and groups are those of control faces.
    /// @throws Error  unsupported: a limit that the scheme has no mask for; as DualCharts
    PolygonMesh to_mesh(const DualMeshOptions& options = {}) const;

  private:
    const ControlMesh* mesh_;
    const SchemeInfo* scheme_;
    RuleOptions rules_;
    VertexForest forest_;
    std::shared_ptr<const LevelSource> points_;
};

namespace detail {

/// Cuts quads along the diagonal in the 4-8 pattern, larger faces into fans. Without `diagonal_at_first` and `corners`
/// afterwards.
/// @param face_uvs  if not null, cut alike: a number per face corner
void cut_into_triangles(DualFaces& faces, std::vector<std::uint32_t>* face_uvs = nullptr);

}  // namespace detail

}  // namespace tetrakis
