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

/// A vertex has no limit mask. A caller that can do without limits may catch this and leave them out.
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
    /// Tangents with t1 x t2 outwards. Vertex v has rows [begin[v], begin[v + 1]), one for each side of a crease; it
    /// has none at a corner, or if the scheme has no tangent mask for it.
    StencilTable tangent1, tangent2;
    std::vector<int> begin{0};
    /// Vertices without a limit, such as vertices outside of the surface where boundaries recede. Their row is the
    /// vertex's own point.
    std::vector<int> missing;
};

/// Limit and tangent rows of the given vertices, in their order; no row depends on the other vertices. Rows come from
/// the scheme's closed masks, else from left eigenvectors of its local subdivision matrix. If a mask does not fit the
/// mesh around a vertex yet, a part of the mesh is first refined by as many steps as the mask needs.
///
/// For a dual scheme, the limit of a vertex is the limit of the face that the vertex becomes; on a regular mesh that is
/// the spline at the vertex's own parameters.
/// @param may_miss  whether vertices may have no limit (see RuleLimits::missing); else such a vertex throws
/// @throws std::invalid_argument  a vertex has no mask: one of valence 2 inside a dual scheme's mesh, or one where a
///                                crease of honeycomb refinement ends
RuleLimits rule_limits(LimitSearch& search, const RuleMesh& mesh, std::span<const int> vertices, bool may_miss = false);

/// The normal of a vertex without tangents (FaceNormals).
Vec3d face_normal_at(const RuleMesh& mesh, std::span<const Vec3d> net, int v);

/// The limit point of vertex `v` of the mesh, which is vertex number `i` of the limits.
LimitPoint limit_point(const RuleLimits& limits, int i, const RuleMesh& mesh, std::span<const Vec3d> net, int v);
/// The unit normal of vertex `v` of the mesh, which is vertex number `i` of the limits: from its tangents, at a crease
/// the mean of both sides; face_normal_at() if they give no direction.
Vec3d limit_normal(const RuleLimits& limits, int i, const RuleMesh& mesh, std::span<const Vec3d> net, int v);

}  // namespace tetrakis::detail
