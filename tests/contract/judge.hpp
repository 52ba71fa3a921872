#pragma once

#include "../../eval/surface/triangle_mesh.hpp"
#include "../../eval/tessellate/tessellate.hpp"
#include "../../hier/mesh/control_mesh.hpp"
#include "../../refine/uniform/refine.hpp"
#include "../../schemes/core/scheme_table.hpp"
#include "../kit/nearest.hpp"
#include "../kit/scheme_meshes.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

// Independent judge of tessellations: distances in double precision to the limit points of refine(). It uses no code of
// the library's own error measurement.
namespace tetrakis::contract {

using test::NearestTriangle;

/// Judges by the limit points of one level of refine().
class LimitJudge {
  public:
    LimitJudge(const ControlMesh& mesh, const SchemeInfo& scheme, int level, const RuleOptions& rules = {}) {
        const RefineOptions limit{.rules = rules, .limit = true};
        const PolygonMesh fine = refine(mesh, scheme, level, limit), coarse = refine(mesh, scheme, level - 1, limit);
        points_ = fine.positions;
        surface_ = std::make_unique<NearestTriangle>(points_, test::triangles_of(fine).triangles);
        doubt_ = farthest(points_, NearestTriangle(coarse.positions, test::triangles_of(coarse).triangles));
    }

    /// Largest distance from the level's limit points to the mesh. The points lie on the surface, so the one-sided
    /// distance of the whole surface is never less.
    double limit_to_mesh(const TriangleMesh& mesh) const {
        return farthest(points_, NearestTriangle(mesh.positions, mesh.triangles));
    }
    /// From points on each triangle, its edges included, to the mesh of the level's limit points.
    double mesh_to_limit(const TriangleMesh& mesh) const {
        constexpr int k_intervals = 4;  // on each side of a triangle
        double most = 0;
        for (const auto& t : mesh.triangles) {
            const Vec3d &a = mesh.positions[t[0]], &b = mesh.positions[t[1]], &c = mesh.positions[t[2]];
            for (int i = 0; i <= k_intervals; ++i)
                for (int j = 0; i + j <= k_intervals; ++j) {
                    const double u = static_cast<double>(i) / k_intervals, v = static_cast<double>(j) / k_intervals;
                    most = std::max(most, surface_->distance((1 - u - v) * a + u * b + v * c));
                }
        }
        return most;
    }
    /// Estimated error of mesh_to_limit(): distance of the level's limit points from the mesh of the level before.
    double doubt() const { return doubt_; }

  private:
    static double farthest(const std::vector<Vec3d>& points, const NearestTriangle& from) {
        double most = 0;
        for (const Vec3d& p : points) most = std::max(most, from.distance(p));
        return most;
    }

    std::vector<Vec3d> points_;
    std::unique_ptr<NearestTriangle> surface_;
    double doubt_ = 0;
};

/// Level for a judge of this result: two above its deepest one, or one above if two would give very many faces.
inline int judging_level(const ControlMesh& mesh, const SchemeInfo& scheme, const Tessellation& result) {
    constexpr double k_most_faces = 400'000;
    const double faces =
        mesh.halfedge_count() * std::pow(scheme.refinement == Refinement::sqrt3 ? 9.0 : 4.0, result.deepest_level + 1);
    return result.deepest_level + (faces < k_most_faces ? 2 : 1);
}

}  // namespace tetrakis::contract
