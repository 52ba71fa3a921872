#pragma once

#include "../../hier/base/run_context.hpp"
#include "../../hier/mesh/control_mesh.hpp"
#include "../../schemes/core/scheme_table.hpp"
#include "../attributes/followed_uvs.hpp"
#include "../attributes/seam_extension.hpp"
#include "repeated_rows.hpp"

#include <memory>
#include <optional>

namespace tetrakis::detail {

/// Texture coordinates beside RepeatedRows: the charts, refined in the same way.
class RepeatedCharts {
  public:
    /// Nothing where charts have no such rows, or cannot be followed where the mesh recedes.
    /// @param mesh     has UVs
    /// @param surface  what is refined: the mesh, or with_missing_ring() of it where its boundary recedes
    /// @param demand   of the mesh
    /// @throws Error  as RepeatedRows::make()
    static std::optional<RepeatedCharts> make(const ControlMesh& mesh, const ControlMesh& surface,
                                              const SchemeInfo& scheme, int levels, const RuleOptions& rules,
                                              const RepeatedRows::Demand& demand, const RunContext& context);

    /// Whether charts go on beyond their seams: some of their points then belong to no face.
    bool extended() const { return extended_; }

    /// UVs at the corners of the surface's faces; those that are missing are no numbers. Nothing where the charts have
    /// not all that the surface has.
    /// @param rows   of the surface
    /// @param faces  of its last level
    std::optional<FollowedUvs> refine(const RepeatedRows& rows, const RepeatedRows::Faces& faces,
                                      const RunContext& context);

  private:
    RepeatedCharts() = default;
    ChartCorners corners();

    const ControlMesh* surface_ = nullptr;
    const SchemeInfo* scheme_ = nullptr;
    RuleOptions rules_{};  ///< of the surface
    bool dual_ = false, extended_ = false;
    SeamExtension extension_{};
    std::unique_ptr<const ControlMesh> charts_{};
    std::size_t own_ = 0;    ///< half-edges of the mesh, which the surface has, too
    std::size_t known_ = 0;  ///< points of the charts that are not missing
    std::unique_ptr<const RepeatedRows> rows_{};
};

}  // namespace tetrakis::detail
