#pragma once

#include "../../hier/base/parallel.hpp"
#include "../../hier/trees/vertex_forest.hpp"
#include "../../refine/adaptive/dual_charts.hpp"
#include "../../refine/points/row_points.hpp"
#include "../../refine/points/vertex_links.hpp"
#include "../../refine/points/written_positions.hpp"
#include "../../refine/rules/polygon_mesh.hpp"

#include <utility>

// Vertex quadtrees without the handles of a Hierarchy: tests look at their forest.
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
    AdaptiveDual(const ControlMesh& mesh, const SchemeInfo& scheme, const RuleOptions& rules = {})
        : mesh_(&mesh),
          scheme_(&scheme),
          rules_(rules),
          forest_(vertex_roots(mesh, scheme, rules)),
          points_(detail::row_points(mesh, scheme, rules, &forest_.roots(), {}, false)) {}
    AdaptiveDual(const ControlMesh&&, const SchemeInfo&, const RuleOptions& = {}) = delete;

    VertexForest& forest() { return forest_; }
    const VertexForest& forest() const { return forest_; }
    const LevelSource& points() const { return *points_; }

    /// The leaves as a mesh without cracks: vertices are leaves, edges are the sides that two of them share, faces the
    /// points where they meet. Materials and groups are those of control faces.
    /// @throws Error  unsupported: a limit that the scheme has no mask for; as DualCharts
    PolygonMesh to_mesh(const DualMeshOptions& options = {}) const {
        const bool with_uvs = options.uvs && mesh_->has_uvs();
        DualFaces faces = forest_.faces(with_uvs ? FaceCorners::leaves : FaceCorners::vertices);
        PolygonMesh mesh;
        mesh.positions.resize(faces.cells.size());
        with_threads(options.context, [&] {
            if (with_uvs) {
                auto [uvs, face_uvs] =
                    DualCharts(*mesh_, *scheme_, rules_, forest_.roots()).uvs(forest_, faces, options.limit);
                mesh.uvs = std::move(uvs);
                mesh.face_uvs = std::move(face_uvs);
            }
            const std::vector<Site> sites = cell_sites(faces.cells);
            if (options.limit)
                points_->limit_positions(sites, mesh.positions);
            else
                written_positions(*points_, sites, mesh.positions);
            if (!options.normals) return;
            mesh.normals.resize(sites.size());
            points_->normals(sites, mesh.normals);
        });
        if (options.triangles) detail::cut_into_triangles(faces, with_uvs ? &mesh.face_uvs : nullptr);
        const ControlMeshData& data = mesh_->data();
        for (const FaceId f : faces.control_faces) {
            if (!data.face_material.empty()) mesh.face_material.push_back(data.face_material[f.value]);
            if (!data.face_group.empty()) mesh.face_group.push_back(data.face_group[f.value]);
        }
        mesh.face_offsets = std::move(faces.face_offsets);
        mesh.face_vertices = std::move(faces.face_vertices);
        mesh.materials = data.materials;
        mesh.groups = data.groups;
        return mesh;
    }

  private:
    const ControlMesh* mesh_;
    const SchemeInfo* scheme_;
    RuleOptions rules_;
    VertexForest forest_;
    std::shared_ptr<const LevelSource> points_;
};

}  // namespace tetrakis
