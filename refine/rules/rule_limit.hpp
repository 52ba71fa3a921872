#pragma once

#include "../../hier/base/error.hpp"
#include "../../hier/base/vec.hpp"
#include "../../schemes/analysis/limit_search.hpp"
#include "../../schemes/core/scheme_table.hpp"
#include "limit_point.hpp"

#include <filesystem>
#include <span>
#include <string>
#include <vector>

namespace tetrakis::detail {

/// There is no limit mask for a vertex; who can do without limits may leave them out.
class NoLimit : public Error {
  public:
    NoLimit(const std::string& reason, const std::filesystem::path& file)
        : Error(ErrorCode::unsupported, reason + "; leave out the limit", file), reason_(reason) {}
    const std::string& reason() const { return reason_; }

  private:
    std::string reason_;
};

/// Limits of vertices of a mesh under a scheme, as combinations of its points.
struct RuleLimits {
    StencilTable positions;  ///< one row per vertex
    /// Tangents, t1 x t2 outwards: those of vertex v are rows [begin[v], begin[v + 1]), one for each side of a crease;
    /// none where the scheme has no mask for them or the vertex is a corner.
    StencilTable tangent1, tangent2;
    std::vector<int> begin{0};
    /// Vertices that have none, such as those beyond the end of the surface where boundaries recede: their position is
    /// their own point.
    std::vector<int> missing;
};

/// Of some vertices, one row, or range of tangents, for each in their order; a row does not depend on the others. By
/// the scheme's closed masks, else by the left eigenvectors of its local matrix, on the mesh itself where the
/// surroundings of a vertex are those of the mask, else as many steps further down as it takes (of a part of the mesh).
///
/// The limit of a vertex of a dual scheme is that of the face that it becomes: on a regular mesh the spline at the
/// vertex's own parameters.
/// @param may_miss  whether vertices may have no limit (RuleLimits::missing); else they throw
/// @throws std::invalid_argument  a vertex for which there is no mask: one of valence 2 inside a dual scheme's mesh,
///                                one where a crease of honeycomb refinement ends
RuleLimits rule_limits(LimitSearch& search, const RuleMesh& mesh, std::span<const int> vertices, bool may_miss = false);

/// The normal of a vertex without tangents (FaceNormals).
Vec3d face_normal_at(const RuleMesh& mesh, std::span<const Vec3d> net, int v);

/// The i-th of the limits' points, which is of vertex `v` of the mesh.
LimitPoint limit_point(const RuleLimits& limits, int i, const RuleMesh& mesh, std::span<const Vec3d> net, int v);
/// The unit normal of the i-th of the limits' vertices, which is `v` of the mesh: of its tangents, the mean of the
/// sides of a crease; where these say nothing, that of face_normal_at().
Vec3d limit_normal(const RuleLimits& limits, int i, const RuleMesh& mesh, std::span<const Vec3d> net, int v);

}  // namespace tetrakis::detail
