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

/// A limit as combinations of a mesh's points; tangents t1 x t2 outwards, a pair for each side of a crease.
struct LimitRows {
    StencilRow limit;
    std::vector<std::array<StencilRow, 2>> tangents;
};

/// Finds limits of single vertices under a scheme, whatever is around them: by its masks on the mesh itself where the
/// surroundings of a vertex are those of a mask, else as many steps further down as it takes (of a part of the mesh).
/// Keeps the masks that it has found.
class LimitSearch {
  public:
    /// @param options  their runner lives longer
    LimitSearch(const SchemeInfo& scheme, const RuleOptions& options);
    ~LimitSearch();
    const SchemeInfo& scheme() const { return scheme_; }

    /// Rows of the vertices, empty where there is no mask. All have faces.
    std::vector<std::optional<LimitRows>> find(const RuleMesh& mesh, std::span<const int> vertices);

    /// The row of the middle of a dual mesh's face, by one of its half-edges.
    std::optional<LimitRows> at_face(const RuleMesh& mesh, int halfedge);

  private:
    class Finder;
    const SchemeInfo& scheme_;
    std::unique_ptr<Finder> finder_;
};

/// Rings of faces around a vertex that its limit depends on at most, where its sharpness runs out in time.
int rule_limit_rings(const SchemeInfo& scheme, const RuleOptions& options);

}  // namespace tetrakis::detail
