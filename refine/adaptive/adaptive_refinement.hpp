#pragma once

#include "../../hier/base/error.hpp"
#include "../../hier/base/ids.hpp"
#include "../../hier/base/memory.hpp"
#include "../../hier/base/run_context.hpp"
#include "../families/error_estimator.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <vector>

namespace tetrakis {

namespace detail {

/// @param triangles  number of triangles that the mesh will have at least
/// @param bytes      bytes of these triangles
/// @param limit      in bytes; 0: no limit
/// @throws Error     memory_limit: the triangles need more than the limit
inline void check_triangle_memory(std::uint64_t triangles, std::uint64_t bytes, std::uint64_t limit) {
    check_memory("more than " + std::to_string(triangles) + " triangles are wanted, which need", bytes, limit,
                 "use a larger tolerance, or allow more");
}

/// @throws Error  unsupported: the minimum level of all leaves takes more than `triangles` triangles
[[noreturn]] inline void refuse_least_level(std::uint64_t triangles) {
    throw Error(ErrorCode::unsupported, "the minimum level takes more than the " + std::to_string(triangles) +
                                            " triangles allowed; allow more, or lower the minimum level");
}

}  // namespace detail

struct AdaptiveOptions {
    double tolerance = 0;  ///< leaves with a larger error are split
    std::uint64_t max_triangles =
        0;                        ///< 0: no limit; else the largest errors are split first until the limit is reached
    int min_level = 0;            ///< every leaf is split down to this quadtree level
    int max_level = k_max_level;  ///< leaves of this level are not split, except if must_split()
    std::uint64_t max_memory_bytes = 0;    ///< 0: no limit; else more triangles than fit are refused
    std::uint64_t base_bytes = 0;          ///< bytes that are in use already, counted for that limit
    std::uint64_t bytes_per_triangle = 0;  ///< bytes per triangle of the result, counted for that limit
};

/// Error-driven refinement of a hierarchy (README.md: positions and errors come through batch interfaces).
///
/// The error of a leaf depends on the leaf alone. So the result is the smallest conforming refinement without a leaf
/// over the tolerance, whatever the order of splits. `Hierarchy` adapts a forest (hierarchy_view.hpp).
template <class Hierarchy>
class AdaptiveRefinement {
  public:
    AdaptiveRefinement(Hierarchy& hierarchy, const ErrorEstimator& estimator, const AdaptiveOptions& options,
                       const RunContext& context)
        : hierarchy_(hierarchy), estimator_(estimator), options_(options), context_(context) {}

    /// Refines until each leaf is within the tolerance or at the maximum level, or until the budget is spent.
    void run() {
        std::vector<LeafId> fresh;
        check_memory(0);
        hierarchy_.initial_leaves(fresh);
        settle(fresh);
    }

    /// Splits these leaves and opens these fans whatever their error, then continues as run(); for parts of the mesh
    /// that a measurement found to be over the tolerance. The budget limits these splits, too.
    void split(std::span<const LeafId> marked, std::span<const FaceId> fans) {
        std::vector<LeafId> fresh;
        if (options_.max_triangles != 0) return settle_in_budget(fresh, marked, fans);
        check_memory(marked.size());
        if (!marked.empty()) hierarchy_.refine(marked, fresh);
        for (FaceId f : fans) hierarchy_.open(f, fresh);
        settle(fresh);
    }

    /// The error of a leaf; 0 for a leaf that was never estimated (in an accepted fan).
    double error(LeafId leaf) const { return leaf.value < errors_.size() ? errors_[leaf.value] : 0.0; }
    ErrorBasis basis(LeafId leaf) const { return leaf.value < basis_.size() ? basis_[leaf.value] : ErrorBasis::bound; }
    bool budget_spent() const { return budget_spent_; }
    /// Whether a leaf exceeds the tolerance that was not split because of the maximum level or the budget.
    bool left_over() const { return left_over_; }
    /// Seconds spent in the estimator so far.
    double estimate_seconds() const { return estimate_seconds_; }

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

    /// Sets each leaf's error to the largest one of its triangles; a leaf with green triangles has up to three.
    void estimate(std::span<const LeafId> leaves) {
        if (errors_.size() < hierarchy_.slots()) {
            errors_.resize_zeroed(hierarchy_.slots());
            basis_.resize_zeroed(hierarchy_.slots());
        }
        std::vector<typename Hierarchy::Triangle> triangles;
        std::array<typename Hierarchy::Triangle, 3> parts;
        std::vector<std::uint32_t> of;  // per triangle: its leaf
        std::vector<double> values;
        std::vector<ErrorBasis> basis;
        for (std::size_t begin = 0, size = 0; begin < leaves.size(); begin += size) {
            size = std::min(leaves.size() - begin, block_);
            triangles.clear();
            of.clear();
            for (const LeafId leaf : leaves.subspan(begin, size)) {
                const int count = hierarchy_.triangles(leaf, parts);
                triangles.insert(triangles.end(), parts.begin(), parts.begin() + count);
                of.insert(of.end(), static_cast<std::size_t>(count), leaf.value);
                errors_[leaf.value] = 0;
                basis_[leaf.value] = ErrorBasis::bound;
            }
            values.resize(triangles.size());
            basis.resize(triangles.size());
            const auto start = std::chrono::steady_clock::now();
            estimator_.estimate(triangles, values, basis);
            const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - start;
            estimate_seconds_ += taken.count();
            // A block should take 0.02 to 0.1 s. A leaf of a degenerate surface may take a thousand times the usual.
            constexpr double k_short = 0.02, k_long = 0.1;  // seconds
            constexpr std::size_t k_least = 16, k_most = 1u << 14;
            if (taken.count() < k_short && size == block_) block_ = std::min(k_most, 2 * block_);
            if (taken.count() > k_long)
                block_ = std::max(k_least, static_cast<std::size_t>(k_long / taken.count() * double(size)));
            for (std::size_t t = 0; t < of.size(); ++t) {
                errors_[of[t]] = std::max(errors_[of[t]], values[t]);
                basis_[of[t]] = std::max(basis_[of[t]], basis[t]);
            }
            context_.report("refine", progress_);
        }
    }

    void settle(std::vector<LeafId> fresh) {
        if (options_.max_triangles != 0) return settle_in_budget(fresh);
        std::vector<LeafId> marked;
        for (int pass = 1; !fresh.empty(); ++pass) {
            progress_ = std::max(progress_, 1.0 - 1.0 / pass);
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

    /// A leaf that may be split, or a face whose fan may be opened.
    struct Candidate {
        double error;
        LeafId leaf;  // invalid: a fan
        FaceId fan;
        typename Hierarchy::Key key;  // breaks ties, independent of the history
        bool due = false;             // is split whatever its error
        bool operator<(const Candidate& o) const {
            return error != o.error ? error > o.error : fan != o.fan ? fan < o.fan : key < o.key;
        }
    };

    /// Splits the largest errors first. A round takes as many near the largest one as the budget allows.
    /// @param leaves, fans  are split and opened first, whatever their error
    void settle_in_budget(std::vector<LeafId> fresh, std::span<const LeafId> leaves = {},
                          std::span<const FaceId> fans = {}) {
        constexpr double k_first = std::numeric_limits<double>::infinity();
        constexpr double k_share = 0.7;  // of the largest error; a child has a quarter of its parent's error, or half
        constexpr std::uint64_t k_triangles_per_split = 2;
        std::vector<Candidate> candidates;
        for (const LeafId leaf : leaves) candidates.push_back({k_first, leaf, FaceId{}, hierarchy_.key(leaf), true});
        for (const FaceId face : fans) candidates.push_back({k_first, LeafId{}, face, {}, true});
        std::vector<LeafId> open;                                        // leaves that may have to be split, sorted
        std::uint64_t most = std::numeric_limits<std::uint64_t>::max();  // splits in a round at most
        const auto wanted = [&](LeafId leaf) { return is_first(leaf) ? k_first : error(leaf); };
        const auto fan_wants = [&](double error) { return error > options_.tolerance || options_.min_level > 0; };
        for (;;) {
            const std::uint64_t count = hierarchy_.triangle_count(), budget = options_.max_triangles;
            progress_ = std::clamp(static_cast<double>(count) / static_cast<double>(budget), progress_, 1.0);
            estimate(fresh);
            std::sort(fresh.begin(), fresh.end());
            const auto middle = static_cast<std::ptrdiff_t>(open.size());
            open.insert(open.end(), fresh.begin(), fresh.end());
            std::inplace_merge(open.begin(), open.begin() + middle, open.end());
            open.erase(std::unique(open.begin(), open.end()), open.end());
            double largest = candidates.empty() ? 0 : k_first;
            std::erase_if(open, [&](LeafId leaf) {
                if (!hierarchy_.is_leaf(leaf) || !wants_split(leaf)) return true;
                left_over_ |= !may_split(leaf);
                if (may_split(leaf)) largest = std::max(largest, wanted(leaf));
                return !may_split(leaf);
            });
            hierarchy_.for_each_fan([&](FaceId, double error) {
                if (fan_wants(error)) largest = std::max(largest, error);
            });
            const double least = k_share * largest;
            for (const LeafId leaf : open)
                if (wanted(leaf) >= least) candidates.push_back({wanted(leaf), leaf, FaceId{}, hierarchy_.key(leaf)});
            hierarchy_.for_each_fan([&](FaceId face, double error) {
                if (fan_wants(error) && error >= least) candidates.push_back({error, LeafId{}, face, {}});
            });
            if (candidates.empty()) return;
            std::sort(candidates.begin(), candidates.end());
            for (const Hierarchy before = hierarchy_;; most /= 2, hierarchy_ = before) {
                const std::uint64_t room = count < budget ? (budget - count) / k_triangles_per_split : 0;
                most = std::min({most, std::uint64_t{candidates.size()}, room});
                if (most == 0) {
                    if (std::ranges::any_of(candidates, [&](const Candidate& c) {
                            return c.leaf.valid() && hierarchy_.level(c.leaf) < options_.min_level;
                        }))
                        detail::refuse_least_level(budget);
                    budget_spent_ = left_over_ = true;
                    return;
                }
                check_memory(most);
                fresh.clear();
                std::vector<LeafId> marked;
                for (const Candidate& c : std::span(candidates).first(most))
                    if (c.leaf.valid())
                        marked.push_back(c.leaf);
                    else
                        hierarchy_.open(c.fan, fresh);
                if (!marked.empty()) hierarchy_.refine(marked, fresh);
                if (hierarchy_.triangle_count() <= budget) break;
            }
            // Due candidates that had no room in this round stay due, unless another split has split them.
            std::size_t i = 0;
            const bool all = most == candidates.size();
            std::erase_if(candidates, [&](const Candidate& c) {
                return i++ < most || !c.due ||
                       (c.leaf.valid() && (!hierarchy_.is_leaf(c.leaf) || hierarchy_.key(c.leaf) != c.key));
            });
            if (all) most = std::numeric_limits<std::uint64_t>::max();
        }
    }

    Hierarchy& hierarchy_;
    const ErrorEstimator& estimator_;
    AdaptiveOptions options_;
    const RunContext& context_;
    detail::PodArray<double> errors_;
    detail::PodArray<ErrorBasis> basis_;
    double progress_ = 0;  ///< the used share of the budget; without a budget, it grows with each pass
    double estimate_seconds_ = 0;
    std::size_t block_ = 256;  ///< leaves between two checks for cancellation
    bool budget_spent_ = false, left_over_ = false;
};

}  // namespace tetrakis
