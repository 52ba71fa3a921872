#include "adaptive_dual.hpp"

#include "../../hier/base/parallel.hpp"
#include "../points/row_points.hpp"
#include "../points/vertex_links.hpp"
#include "../points/written_positions.hpp"
#include "../rules/triangle_cut.hpp"
#include "dual_charts.hpp"

#include <algorithm>
#include <cstddef>
#include <utility>

namespace tetrakis {

AdaptiveDual::AdaptiveDual(const ControlMesh& mesh, const SchemeInfo& scheme, const RuleOptions& rules)
    : mesh_(&mesh),
      scheme_(&scheme),
      rules_(rules),
      forest_(vertex_roots(mesh, scheme, rules)),
      points_(detail::row_points(mesh, scheme, rules, &forest_.roots(), {}, false)) {}

void detail::cut_into_triangles(DualFaces& faces, std::vector<std::uint32_t>* face_uvs) {
    const TriangleCut cut = cut_polygons(faces.face_offsets, faces.diagonal_at_first);
    faces.face_offsets = cut.offsets();
    cut.spread_corners(faces.face_vertices);
    cut.spread(faces.control_faces);
    faces.corners.clear();
    if (face_uvs != nullptr) cut.spread_corners(*face_uvs);
}

PolygonMesh AdaptiveDual::to_mesh(const DualMeshOptions& options) const {
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

}  // namespace tetrakis
