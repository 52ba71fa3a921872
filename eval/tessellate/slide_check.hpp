#pragma once

#include "../bounds/edge_slack.hpp"
#include "../bounds/mesh_slack.hpp"
#include "exported_mesh.hpp"
#include "leaf_estimator.hpp"
#include "mesh_change.hpp"
#include "patch_batches.hpp"

#include <algorithm>
#include <cstdint>
#include <optional>
#include <vector>

namespace tetrakis::detail {

/// Checks what the certified estimator has assumed of the neighbours of leaves that slide (assumed_slack), mesh by mesh
/// while these are refined.
template <class Family>
class SlideCheck {
  public:
    SlideCheck(const LeafEstimator<Family>& estimator, double tolerance, const RunContext& context)
        : estimator_(estimator), tolerance_(tolerance), context_(context) {}

    /// Looks at a mesh, and of a later one only at what has changed.
    /// @param slides  slides(t): whether triangle t is within the tolerance only if it may slide
    /// @param cell    cell(t): its CellTriangle
    /// @return  by triangle, a certified bound on its error in this mesh; 0 where its neighbours grant what was
    /// assumed, and the estimator's bound holds; above the tolerance where it has to be split
    template <class Slides, class Cell>
    const std::vector<double>& bounds(const TriangleMesh& mesh, const MeshChange& change, Slides&& slides,
                                      Cell&& cell) {
        const std::optional<MeshSlack> before = std::move(granted_);
        const std::vector<double> bound_before = std::move(bound_);
        granted_.emplace(mesh.triangles, mesh.positions);
        const auto count = static_cast<std::uint32_t>(mesh.triangles.size());
        bound_.assign(count, 0);
        constexpr std::uint32_t k_grain = 64;
        for_each_batch(&estimator_.patches(), count, k_grain, context_, "refine", 0.9, 1, [&](std::uint32_t t) {
            if (!slides(t)) return;
            if (before && unchanged(*before, change, t)) {
                bound_[t] = bound_before[change.triangle[t]];
                return;
            }
            bound_[t] = bound(mesh, t, cell(t));
        });
        return bound_;
    }

  private:
    double bound(const TriangleMesh& mesh, std::uint32_t t, const CellTriangle& leaf) const {
        constexpr double k_loose = 1e-6;
        const auto soft = estimator_.soft_edges(leaf);
        const auto& v = mesh.triangles[t];
        const EdgeSlack assumed = assumed_slack({mesh.positions[v[0]], mesh.positions[v[1]], mesh.positions[v[2]]},
                                                tolerance_, soft, k_loose);
        if (assumed.any() && granted_->grants(t, assumed)) return 0;
        auto& bounder = estimator_.bounder();
        const double sliding =
            bounder.leaf_error(leaf, tolerance_, LeafSlack::known(granted_->of(t, soft), true)).upper;
        // One of a leaf's several triangles may do without.
        return sliding <= tolerance_ ? sliding : std::min(sliding, bounder.leaf_error(leaf, tolerance_).upper);
    }
    /// Whether a triangle and those across its edges are the same as in the mesh before.
    bool unchanged(const MeshSlack& before, const MeshChange& change, std::uint32_t t) const {
        const std::uint32_t s = change.triangle[t];
        if (s == MeshChange::k_new) return false;
        for (std::size_t k = 0; k < 3; ++k) {
            const std::uint32_t now = granted_->across(t, k), then = before.across(s, k);
            if (now == MeshSlack::k_none ? then != MeshSlack::k_none : change.triangle[now] != then) return false;
        }
        return true;
    }

    const LeafEstimator<Family>& estimator_;
    double tolerance_;
    const RunContext& context_;
    std::optional<MeshSlack> granted_;
    std::vector<double> bound_;
};

}  // namespace tetrakis::detail
