#pragma once

#include "../core/rule_mesh.hpp"
#include "../core/scheme_table.hpp"
#include "../core/stencil_table.hpp"

#include <array>
#include <memory>
#include <optional>
#include <span>
#include <vector>

namespace tetrakis::detail {

/// Masks of the point in the middle of a fan: the scheme's formulas, else left eigenvectors. Limit weights sum to one,
/// and t1 x t2 points outwards. Empty: there is no limit mask; there is no tangent plane.
ClosedMasks limit_masks(const SchemeInfo& scheme, const FanShape& shape, const RuleOptions& options);

/// Limit and tangents as combinations of a mesh's points: one tangent pair per side of a crease, t1 x t2 outwards.
struct LimitRows {
    StencilRow limit;
    std::vector<std::array<StencilRow, 2>> tangents;
};

/// Finds limits of single vertices under a scheme. Where the surroundings of a vertex are those of one of the scheme's
/// masks, the mask is applied to the mesh itself. Elsewhere a part of the mesh is refined until a mask fits.
/// An object keeps the masks that it has computed.
class LimitSearch {
  public:
    /// @param options  `options.runner` must outlive this object
    LimitSearch(const SchemeInfo& scheme, const RuleOptions& options);
    ~LimitSearch();
    const SchemeInfo& scheme() const { return scheme_; }

    /// Rows of the vertices, empty where no mask is found. Each vertex must have a face.
    std::vector<std::optional<LimitRows>> find(const RuleMesh& mesh, std::span<const int> vertices);

    /// Rows of the middle of a dual mesh's face, which is named by one of its half-edges.
    std::optional<LimitRows> at_face(const RuleMesh& mesh, int halfedge);

  private:
    class Finder;
    const SchemeInfo& scheme_;
    std::unique_ptr<Finder> finder_;
};

/// Upper bound of the rings of faces around a vertex on which its limit depends, if LimitSearch finds a mask for it.
int rule_limit_rings(const SchemeInfo& scheme, const RuleOptions& options);

}  // namespace tetrakis::detail
