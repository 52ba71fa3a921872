#pragma once

#include "../../hier/base/ids.hpp"
#include "../../hier/base/memory.hpp"
#include "../../hier/base/parallel.hpp"
#include "../../hier/base/radix_sort.hpp"
#include "../../hier/base/spread_bits.hpp"
#include "../families/error_estimator.hpp"
#include "triangle_memory.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <limits>
#include <optional>
#include <queue>
#include <span>
#include <string>
#include <vector>

namespace tetrakis {

struct AdaptiveOptions {
    double tolerance = 0;  ///< leaves with a larger error are split
    std::uint64_t max_triangles =
        0;                        ///< 0: no limit; else the largest errors are split first until the limit is reached
    int min_level = 0;            ///< every leaf gets this quadtree level
    int max_level = k_max_level;  ///< no leaf is split beyond it
    std::uint64_t max_memory_bytes = 0;    ///< 0: no limit; else more triangles than fit are refused
    std::uint64_t base_bytes = 0;          ///< what is there already, for that limit
    std::uint64_t bytes_per_triangle = 0;  ///< what a triangle of the result takes, for that limit
};

/// Error-driven refinement of a hierarchy (README.md: positions and errors come through batch interfaces).
///
/// The error of a leaf depends on the leaf alone, so the result is the smallest conforming refinement in which no leaf
/// exceeds the tolerance: it does not depend on the order of splits. `Hierarchy` adapts a forest (hierarchy_view.hpp).
template <class Hierarchy>
class AdaptiveRefinement {
  public:
    AdaptiveRefinement(Hierarchy& hierarchy, const ErrorEstimator& estimator, const AdaptiveOptions& options,
                       const RunContext& context)
        : hierarchy_(hierarchy), estimator_(estimator), options_(options), context_(context) {}

    /// Refines until every leaf's error is within the tolerance (or its level at the maximum), or the budget is spent.
    void run() {
        std::vector<LeafId> fresh;
        check_memory(0);
        hierarchy_.initial_leaves(fresh);
        settle(fresh);
    }

    /// Splits these leaves and opens these fans whatever their error, then goes on as run(): for what a measurement
    /// found to be off. The budget holds here too.
    void split(std::span<const LeafId> marked, std::span<const FaceId> fans) {
        std::vector<LeafId> fresh;
        if (options_.max_triangles != 0) return settle_in_budget(fresh, marked, fans);
        check_memory(marked.size());
        if (!marked.empty()) hierarchy_.refine(marked, fresh);
        for (FaceId f : fans) hierarchy_.open(f, fresh);
        settle(fresh);
    }

    /// The error of a leaf, 0 for leaves that were never estimated (those of accepted fans).
    double error(LeafId leaf) const { return leaf.value < errors_.size() ? errors_[leaf.value] : 0.0; }
    ErrorBasis basis(LeafId leaf) const { return leaf.value < basis_.size() ? basis_[leaf.value] : ErrorBasis::bound; }
    bool budget_spent() const { return budget_spent_; }
    /// True when some leaf at the maximum level, or one that the budget left, exceeds the tolerance.
    bool left_over() const { return left_over_; }

  private:
    bool wants_split(LeafId leaf) const {
        if (is_first(leaf)) return true;
        return errors_[leaf.value] > options_.tolerance;
    }
    bool may_split(LeafId leaf) const {
        return hierarchy_.level(leaf) < options_.max_level || hierarchy_.must_split(leaf);
    }
    bool is_first(LeafId leaf) const {
        return hierarchy_.level(leaf) < options_.min_level || hierarchy_.must_split(leaf);
    }

    /// Along a space-filling curve, cell by cell: estimators keep what neighbours share.
    void sort_along_curve(std::vector<LeafId>& leaves) {
        order_.resize(leaves.size());
        // Root and place on the curve share 64 bits; leaves that these bits cannot tell apart keep their order.
        const int root_bits = std::bit_width(hierarchy_.root_bound());
        for_each_index(static_cast<std::uint32_t>(leaves.size()), [&](std::uint32_t i) {
            const CellTriangle t = hierarchy_.key(leaves[i]);
            // Halfway from the middle of an edge to the other corner: inside the triangle's cells at all levels.
            const int shift = k_max_level - t.level;
            const auto& c = t.corner;
            const std::uint64_t x = (std::uint64_t{c[0].x} + c[1].x + 2 * std::uint64_t{c[2].x}) << shift;
            const std::uint64_t y = (std::uint64_t{c[0].y} + c[1].y + 2 * std::uint64_t{c[2].y}) << shift;
            const std::uint64_t curve = detail::spread_bits(x) | detail::spread_bits(y) << 1;
            order_[i] = {std::uint64_t{t.root.value} << (64 - root_bits) | curve >> root_bits, leaves[i]};
        });
        radix_sort(order_, order_spare_, [](const Place& p) { return p.place; });
        for_each_index(static_cast<std::uint32_t>(leaves.size()), [&](std::uint32_t i) { leaves[i] = order_[i].leaf; });
    }

    void estimate(std::vector<LeafId>& leaves) {
        if (leaves.size() > 2) sort_along_curve(leaves);
        if (errors_.size() < hierarchy_.slots()) {
            errors_.resize_zeroed(hierarchy_.slots());
            basis_.resize_zeroed(hierarchy_.slots());
        }
        const std::uint32_t count = static_cast<std::uint32_t>(leaves.size());
        constexpr std::uint32_t k_block = 1u << 16;
        for (std::uint32_t begin = 0; begin < count; begin += k_block) {
            const std::uint32_t size = std::min(count - begin, k_block);
            gather(std::span(leaves).subspan(begin, size));
            values_.resize(triangles_.size());
            value_basis_.resize(triangles_.size());
            estimator_.estimate(triangles_, values_, value_basis_);
            for_each_index(size, [&](std::uint32_t i) {
                double error = 0;
                ErrorBasis basis = ErrorBasis::bound;
                for (std::uint32_t t = first_[i]; t < first_[i + 1]; ++t) {
                    error = std::max(error, values_[t]);
                    basis = std::max(basis, value_basis_[t]);
                }
                errors_[leaves[begin + i].value] = error;
                basis_[leaves[begin + i].value] = basis;
            });
            context_.report("refine", progress_);
        }
    }

    /// The triangles of some leaves, those of leaf i from first_[i] on: leaves with green triangles have up to three,
    /// and the largest error counts.
    void gather(std::span<const LeafId> leaves) {
        const auto count = static_cast<std::uint32_t>(leaves.size());
        parts_.resize(count);
        first_.resize(count + std::size_t{1});
        for_each_index(count, [&](std::uint32_t i) {
            first_[i + std::size_t{1}] = static_cast<std::uint32_t>(hierarchy_.triangles(leaves[i], parts_[i]));
        });
        first_[0] = 0;
        for (std::uint32_t i = 0; i < count; ++i) first_[i + std::size_t{1}] += first_[i];
        triangles_.resize(first_[count]);
        for_each_index(count, [&](std::uint32_t i) {
            std::copy_n(parts_[i].begin(), first_[i + std::size_t{1}] - first_[i], triangles_.begin() + first_[i]);
        });
    }

    void settle(std::vector<LeafId> fresh) {
        if (options_.max_triangles != 0) return settle_in_budget(fresh);
        std::vector<LeafId> marked;
        for (int pass = 1; !fresh.empty(); ++pass) {
            progress_ = 1.0 - 1.0 / pass;
            estimate(fresh);
            marked.clear();
            for (LeafId leaf : fresh) {
                if (!wants_split(leaf)) continue;
                if (may_split(leaf))
                    marked.push_back(leaf);
                else
                    left_over_ = true;
            }
            fresh.clear();
            if (marked.empty()) continue;
            check_memory(marked.size());
            hierarchy_.refine(marked, fresh);
        }
    }

    void check_memory(std::uint64_t splits) const {
        const std::uint64_t triangles = hierarchy_.triangle_count() + 2 * splits;
        detail::check_triangle_memory(triangles, options_.base_bytes + triangles * options_.bytes_per_triangle,
                                      options_.max_memory_bytes);
    }

    struct Candidate {
        double error;
        LeafId leaf;  // invalid: a fan
        FaceId fan;
        CellTriangle key;  // tells a leaf from a later one in the same slot, and settles ties
        bool operator<(const Candidate& o) const {
            if (error != o.error) return error < o.error;
            if (fan != o.fan) return o.fan < fan;
            return order(o.key) < order(key);
        }
        static std::array<std::uint32_t, 8> order(const CellTriangle& t) {
            return {t.root.value,  t.level,       t.corner[0].x, t.corner[0].y,
                    t.corner[1].x, t.corner[1].y, t.corner[2].x, t.corner[2].y};
        }
    };

    CellTriangle key(LeafId leaf) const { return hierarchy_.key(leaf); }

    /// @param marked, fans  to be split and opened first, whatever their error
    void settle_in_budget(std::vector<LeafId> fresh, std::span<const LeafId> marked = {},
                          std::span<const FaceId> fans = {}) {
        constexpr double k_first = std::numeric_limits<double>::infinity();
        std::priority_queue<Candidate> queue;
        const auto push = [&](const std::vector<LeafId>& leaves) {
            for (LeafId leaf : leaves) {
                if (!wants_split(leaf)) continue;
                if (!may_split(leaf)) {
                    left_over_ = true;
                    continue;
                }
                const double error = is_first(leaf) ? k_first : this->error(leaf);
                queue.push({error, leaf, FaceId{}, key(leaf)});
            }
        };
        for (LeafId leaf : marked) queue.push({k_first, leaf, FaceId{}, key(leaf)});
        for (FaceId face : fans) queue.push({k_first, LeafId{}, face, CellTriangle{}});
        estimate(fresh);
        push(fresh);
        hierarchy_.for_each_fan([&](FaceId face, double error) {
            if (error > options_.tolerance || options_.min_level > 0)
                queue.push({error, LeafId{}, face, CellTriangle{}});
        });
        const auto apply = [&](const Candidate& c) {
            fresh.clear();
            if (c.leaf.valid())
                hierarchy_.refine(std::span(&c.leaf, 1), fresh);
            else
                hierarchy_.open(c.fan, fresh);
        };
        // A split's closure is bounded by the depth times the few neighbours of a level; so far from the limit no
        // look-ahead is needed.
        constexpr std::uint64_t k_margin = 4096;
        std::optional<Hierarchy> checkpoint;
        std::vector<Candidate> since_checkpoint;
        std::uint64_t steps = 0;
        while (!queue.empty()) {
            const Candidate top = queue.top();
            queue.pop();
            if (top.leaf.valid()) {
                if (!hierarchy_.is_leaf(top.leaf) || Candidate::order(key(top.leaf)) != Candidate::order(top.key))
                    continue;
                if (error(top.leaf) != top.error && top.error != k_first) continue;
            }
            check_memory(1);
            if (!checkpoint && hierarchy_.triangle_count() + k_margin > options_.max_triangles)
                checkpoint.emplace(hierarchy_);
            apply(top);
            if (hierarchy_.triangle_count() > options_.max_triangles) {
                // Back to the last state within the budget.
                hierarchy_ = *checkpoint;
                for (const Candidate& done : since_checkpoint) apply(done);
                budget_spent_ = true;
                left_over_ |= top.error > options_.tolerance;
                return;
            }
            if (checkpoint) since_checkpoint.push_back(top);
            estimate(fresh);
            push(fresh);
            if (++steps % 4096 == 0)
                context_.report("refine", static_cast<double>(hierarchy_.triangle_count()) /
                                              static_cast<double>(options_.max_triangles));
        }
    }

    Hierarchy& hierarchy_;
    const ErrorEstimator& estimator_;
    AdaptiveOptions options_;
    const RunContext& context_;
    detail::PodArray<double> errors_;
    detail::PodArray<ErrorBasis> basis_;
    detail::PodArray<std::array<CellTriangle, 3>> parts_;  ///< of gather(): by leaf
    detail::PodArray<CellTriangle> triangles_;
    detail::PodArray<std::uint32_t> first_;
    struct Place {
        std::uint64_t place;
        LeafId leaf;
    };
    detail::PodArray<Place> order_, order_spare_;
    detail::PodArray<double> values_;
    detail::PodArray<ErrorBasis> value_basis_;
    double progress_ = 0;
    bool budget_spent_ = false, left_over_ = false;
};

}  // namespace tetrakis
