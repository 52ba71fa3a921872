#include "refined_points.hpp"

#include "../../hier/base/memory.hpp"
#include "../attributes/used_values.hpp"

namespace tetrakis::detail {

void RefinedPoints::make(const ControlMesh& mesh, bool normals, PolygonMesh& result) const {
    resize_large(result.positions, count);
    if (normals) resize_large(result.normals, count);
    refine(mesh.positions(), result.positions, result.normals);
}

void drop_unused_points(PolygonMesh& mesh, RefinedPoints* points) {
    if (points == nullptr) return drop_unused_vertices(mesh);
    drop_unused_vertices(mesh, &points->used);
    if (mesh.positions.size() == points->count) points->used = {};
}

}  // namespace tetrakis::detail
