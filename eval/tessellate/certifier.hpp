#pragma once

#include "../../hier/base/run_context.hpp"
#include "../../refine/adaptive/adaptive_refinement.hpp"
#include "../triangles/mesh_sliding.hpp"
#include "../triangles/point_triangle.hpp"
#include "exported_mesh.hpp"
#include "fan_error.hpp"
#include "leaf_estimator.hpp"
#include "patch_batches.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

namespace tetrakis::detail {

/// Bounds the distance between a finished mesh and the limit surface, both ways.
template <class Family>
class Certifier {
  public:
    using Refinement = AdaptiveRefinement<typename Family::Hierarchy>;
    /// Where the triangles come from.
    struct Origins {
        const ExportedMesh<Family>& exported;
        std::function<CellTriangle(std::uint32_t)> cell;  ///< of a leaf's triangle
    };

    /// @param refinement    knows the errors of leaves by `estimator`, which aimed at `tolerance`
    /// @param fan_error     where there may be faces without a centre
    /// @param fan_errors    of these by face
    Certifier(const TriangleMesh& mesh, Origins origins, const LeafEstimator<Family>& estimator,
              const Refinement& refinement, const std::optional<FanError>& fan_error,
              std::span<const FanError::Estimate> fan_errors, double tolerance, const RunContext& context)
        : mesh_(mesh),
          origins_(std::move(origins)),
          exported_(origins_.exported),
          estimator_(estimator),
          refinement_(refinement),
          fan_error_(fan_error),
          fan_errors_(fan_errors),
          tolerance_(tolerance),
          context_(context),
          count_(static_cast<std::uint32_t>(mesh.triangles.size())),
          largest_((count_ + k_block - 1) / k_block, 0.0) {}

    /// Tight to a twentieth, but for bounds of the certified estimator within its tolerance, which count as they are.
    double run() {
        if (count_ == 0) return 0;
        guess();
        if (all_known_) return std::ranges::max(largest_);
        floor_ = by_bounds() ? tolerance_ : 0.0;
        for (double e : largest_) floor_ = std::max(floor_, e);
        std::ranges::fill(largest_, 0.0);
        if (!all_known_) granted_.emplace(mesh_.triangles, mesh_.positions);
        // First those that nothing is known of; what is known may be loose, where all of it matters.
        pass(0.2, 0.9, [&](std::uint32_t t, double floor) {
            const LeafId leaf = exported_.leaves[t];
            return known(t) > 0 ? 0.0 : bound(t, floor, !leaf.valid() || refinement_.basis(leaf) == ErrorBasis::bound);
        });
        pass(0.9, 1, [&](std::uint32_t t, double floor) {
            const double error = known(t);
            return error <= floor ? error : bound(t, floor, true);
        });
        return std::ranges::max(largest_);
    }

  private:
    static constexpr std::uint32_t k_block = 64;
    static constexpr std::uint32_t k_rounds = 8;
    /// Of the triangles only one in so many is sampled for a first guess: it need not be the largest.
    static constexpr std::uint32_t k_stride = 8;

    bool by_bounds() const { return estimator_.kind() == EstimatorKind::certified; }

    /// The bound that the estimator has for a triangle already, or 0. It has one for errors within the tolerance that
    /// it has not marked. The first triangle of a fan stands for all of it.
    double known(std::uint32_t t) const {
        const LeafId leaf = exported_.leaves[t];
        if (!leaf.valid()) {
            const FanError::Estimate& fan = fan_errors_[exported_.faces[t].value];
            return exported_.part[t] == 0 && fan.basis == ErrorBasis::bound && fan.error <= tolerance_ ? fan.error : 0;
        }
        if (refinement_.basis(leaf) == ErrorBasis::samples) return 0;
        const double error = refinement_.error(leaf);
        return error <= tolerance_ ? error : 0;
    }

    template <class ErrorOf>
    void over_block(std::uint32_t block, const ErrorOf& error_of) {
        for (std::uint32_t t = block * k_block; t < std::min((block + 1) * k_block, count_); ++t)
            largest_[block] = std::max(largest_[block], error_of(t, std::max(floor_, largest_[block])));
    }

    /// A first guess at the largest error, which settles most triangles at first sight.
    void guess() {
        all_known_ = by_bounds();
        for_each_batch(&estimator_.patches(), static_cast<std::uint32_t>(largest_.size()), 4, context_, "certify", 0,
                       0.2, [&](std::uint32_t block) {
                           over_block(block, [&](std::uint32_t t, double) {
                               const LeafId leaf = exported_.leaves[t];
                               const bool fan = !leaf.valid();
                               if (fan && exported_.part[t] != 0) return 0.0;
                               if (!by_bounds()) {
                                   if (fan) {
                                       const FanError::Estimate& e = fan_errors_[exported_.faces[t].value];
                                       return e.basis == ErrorBasis::samples ? e.error : 0.0;
                                   }
                                   return t % k_stride == 0 ? sampled(t) : 0.0;
                               }
                               const double error = known(t);
                               if (error > 0) return error;
                               all_known_.store(false, std::memory_order_relaxed);
                               return fan ? 0.0 : refinement_.error(leaf);
                           });
                       });
    }

    /// Across the triangle: how far the surface slides is no error.
    double sampled(std::uint32_t t) const {
        const QuickError quick = estimator_.bounder().quick_error(origins_.cell(t));
        const PlaneMeasure plane(quick.corners);
        return plane.flat() ? std::abs(glm::dot(plane.normal(), quick.middle)) : glm::length(quick.middle);
    }

    /// In rounds, of every k_rounds-th block each: what one finds settles most triangles of the next, and so does what
    /// is found in a block.
    template <class ErrorOf>
    void pass(double from, double to, const ErrorOf& error_of) {
        const auto blocks = static_cast<std::uint32_t>(largest_.size());
        for (std::uint32_t round = 0; round < std::min(k_rounds, blocks); ++round) {
            const double begin = from + (to - from) * round / k_rounds,
                         end = from + (to - from) * (round + 1) / k_rounds;
            for_each_batch(&estimator_.patches(), (blocks - round + k_rounds - 1) / k_rounds, 1, context_, "certify",
                           begin, end, [&](std::uint32_t i) { over_block(i * k_rounds + round, error_of); });
            for (std::uint32_t block = round; block < blocks; block += k_rounds)
                floor_ = std::max(floor_, largest_[block]);
        }
    }

    /// The error with the neighbours unfolded or without, whichever is less.
    /// @param still  whether to try without them first
    double bound(std::uint32_t t, double floor, bool still) const {
        if (!exported_.leaves[t].valid())
            return exported_.part[t] == 0 ? fan_error_->certified(exported_.faces[t], floor, false) : 0;
        const CellTriangle leaf = origins_.cell(t);
        const EdgeSliding sliding = granted_->of(t, estimator_.soft_edges(leaf));
        auto& bounder = estimator_.bounder();
        if (!sliding.any()) return bounder.certified_error(leaf, floor);
        const double first = bounder.certified_error(leaf, floor, still ? EdgeSliding{} : sliding);
        return first <= floor ? first
                              : std::min(first, bounder.certified_error(leaf, floor, still ? sliding : EdgeSliding{}));
    }

    const TriangleMesh& mesh_;
    Origins origins_;
    const ExportedMesh<Family>& exported_;
    const LeafEstimator<Family>& estimator_;
    const Refinement& refinement_;
    const std::optional<FanError>& fan_error_;
    std::span<const FanError::Estimate> fan_errors_;
    double tolerance_;
    const RunContext& context_;
    std::uint32_t count_;
    std::vector<double> largest_;  ///< by block of triangles
    double floor_ = 0;
    std::atomic<bool> all_known_ = false;
    std::optional<MeshSliding> granted_;
};

}  // namespace tetrakis::detail
