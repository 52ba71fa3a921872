#include "judge.hpp"

#include "../kit/scheme_meshes.hpp"

#include <algorithm>
#include <cmath>

namespace tetrakis::contract {

namespace {

double farthest(const std::vector<Vec3d>& points, const NearestTriangle& from) {
    double most = 0;
    for (const Vec3d& p : points) most = std::max(most, from.distance(p));
    return most;
}

}  // namespace

LimitJudge::LimitJudge(const ControlMesh& mesh, const SchemeInfo& scheme, int level, const RuleOptions& rules) {
    const RefineOptions limit{.rules = rules, .limit = true};
    const PolygonMesh fine = refine(mesh, scheme, level, limit), coarse = refine(mesh, scheme, level - 1, limit);
    points_ = fine.positions;
    face_count_ = fine.face_count();
    surface_ = std::make_unique<NearestTriangle>(points_, test::triangles_of(fine).triangles);
    doubt_ = farthest(points_, NearestTriangle(coarse.positions, test::triangles_of(coarse).triangles));
}

double LimitJudge::limit_to_mesh(const TriangleMesh& mesh) const {
    return farthest(points_, NearestTriangle(mesh.positions, mesh.triangles));
}

double LimitJudge::mesh_to_limit(const TriangleMesh& mesh) const {
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

int judging_level(const ControlMesh& mesh, const SchemeInfo& scheme, const Tessellation& result) {
    constexpr double k_most_faces = 400'000;
    const double faces =
        mesh.halfedge_count() * std::pow(scheme.refinement == Refinement::sqrt3 ? 9.0 : 4.0, result.deepest_level + 1);
    return result.deepest_level + (faces < k_most_faces ? 2 : 1);
}

}  // namespace tetrakis::contract
