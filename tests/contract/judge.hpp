#pragma once

#include "../../eval/surface/triangle_mesh.hpp"
#include "../../eval/tessellate/tessellate.hpp"
#include "../../hier/mesh/control_mesh.hpp"
#include "../../refine/uniform/refine.hpp"
#include "../../schemes/core/scheme_table.hpp"
#include "nearest_triangle.hpp"

#include <memory>
#include <vector>

// What a tessellation is judged by: distances from scratch, in doubles, to points that refine() puts on the limit
// surface. Nothing of the library's own measuring is used.
namespace tetrakis::contract {

/// The limit surface as refine() gives it at one level.
class LimitJudge {
  public:
    LimitJudge(const ControlMesh& mesh, const SchemeInfo& scheme, int level, const RuleOptions& rules = {});

    /// From the level's limit points, which lie on the surface, to the mesh: never more than the actual distance.
    double limit_to_mesh(const TriangleMesh& mesh) const;
    /// From points on each triangle, its edges included, to the mesh of the level's limit points.
    double mesh_to_limit(const TriangleMesh& mesh) const;
    /// How far mesh_to_limit() may be off, about: by the distance of these points from the mesh of the level before,
    /// which is twice as coarse or more.
    double doubt() const { return doubt_; }
    std::size_t face_count() const { return face_count_; }

  private:
    std::vector<Vec3d> points_;
    std::unique_ptr<NearestTriangle> surface_;
    double doubt_ = 0;
    std::size_t face_count_ = 0;
};

/// A level for a judge of this result: two finer than its own, or one where that would be very many faces.
int judging_level(const ControlMesh& mesh, const SchemeInfo& scheme, const Tessellation& result);

}  // namespace tetrakis::contract
