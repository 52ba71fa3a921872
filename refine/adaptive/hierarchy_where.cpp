#include "../../hier/base/error.hpp"
#include "../../hier/base/memory.hpp"
#include "../../hier/base/parallel.hpp"
#include "../families/hierarchy_family.hpp"
#include "hierarchy.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <string>

namespace tetrakis {

namespace {

// Number of leaves per call of a predicate: their views still fit into the cache when it reads them.
constexpr std::size_t k_batch = 256;

// Number of leaves that are estimated between two checks for cancellation. It grows with the number of leaves, since an
// estimator may need as long to look around a few leaves as to look around all.
constexpr std::size_t k_least_estimated = 1u << 15, k_most_turns = 16;

/// Calls estimate(begin, count) for parts of `count` leaves or nodes, one after the other.
template <class Estimate>
void estimate_in_turns(std::size_t count, const std::function<void(double)>& report, Estimate&& estimate) {
    const std::size_t turn = std::max(k_least_estimated, (count + k_most_turns - 1) / k_most_turns);
    for (std::size_t begin = 0; begin < count; begin += turn) {
        if (begin != 0) report(static_cast<double>(begin) / static_cast<double>(count));
        estimate(begin, std::min(turn, count - begin));
    }
}

/// @param errors  is resized
void estimate_leaves(const HierarchyFamily& family, std::span<const LeafId> leaves, const ErrorEstimator& estimator,
                     const std::function<void(double)>& report, std::vector<double>& errors) {
    errors.resize(leaves.size());
    estimate_in_turns(leaves.size(), report, [&](std::size_t begin, std::size_t count) {
        family.leaf_errors(leaves.subspan(begin, count), estimator, std::span(errors).subspan(begin, count));
    });
}

void require_estimator(const ErrorEstimator& estimator, const ControlMesh& mesh, const HierarchyTree& tree,
                       double tolerance) {
    if (!estimator.is_for(mesh, tree))
        throw Error(ErrorCode::invalid_input, "the estimator is of another hierarchy; make one of this");
    if (!(tolerance >= 0))
        throw Error(ErrorCode::invalid_input,
                    "the tolerance is " + std::to_string(tolerance) + ", but has to be zero or more");
}

/// Throws if a pass would bring the hierarchy over the memory limit, or has done so.
/// @param memory  bytes of the hierarchy now
/// @param marked  leaves to be split, without the leaves that must be split with them
/// @param open    leaves that the pass has examined
void check_refine_memory(const RunContext& context, std::uint64_t memory, std::uint64_t leaves, std::uint64_t marked,
                         std::uint64_t open, int children) {
    // A new leaf takes as much as an existing one with its reserves, but no more than this: merges leave reserves.
    constexpr std::uint64_t k_most_bytes = 160;
    const std::uint64_t each = std::min(k_most_bytes, memory / std::max<std::uint64_t>(leaves, 1));
    constexpr std::uint64_t k_list_bytes = 2 * sizeof(LeafId) + sizeof(double) + 1;  // open, marked, error, answer
    const auto split = static_cast<std::uint64_t>(children);
    const std::string what = marked == 0 ? " leaves take" : " leaves, " + std::to_string(marked) + " to be split, need";
    detail::check_memory("the hierarchy's " + std::to_string(leaves) + what,
                         memory + marked * ((split - 1) * each + split * sizeof(LeafId)) + open * k_list_bytes,
                         context.max_memory_bytes, "ask for a looser tolerance or a smaller depth, or raise the limit");
}

}  // namespace

void Hierarchy::ask(const LeafPredicate& wanted, std::span<const LeafId> leaves,
                    detail::PoolVector<std::uint8_t>& answers) const {
    answers.assign(leaves.size(), 0);
    std::vector<LeafView> views(std::min(k_batch, leaves.size()));
    for (std::size_t begin = 0; begin < leaves.size(); begin += k_batch) {
        const std::size_t count = std::min(k_batch, leaves.size() - begin);
        const std::span batch = std::span(views).first(count);
        family_->views(leaves.subspan(begin, count), batch);
        for (LeafView& view : batch) view.leaf = handle(view.leaf.slot);
        wanted(batch, std::span(answers).subspan(begin, count));
    }
}

/// @param open   the leaves to examine first
/// @param marks  marks(leaves, answers, report) decides which of the leaves are split
template <class Marks>
std::size_t Hierarchy::refine_until(std::vector<LeafId> open, int max_depth, const RunContext& context, Marks&& marks) {
    if (max_depth < 0 || max_depth > tree().max_depth)
        throw Error(ErrorCode::invalid_input, "the depth is " + std::to_string(max_depth) +
                                                  ", but has to be between 0 and " + std::to_string(tree().max_depth));
    detail::PoolVector<LeafId> marked;
    detail::PoolVector<std::uint8_t> answers;
    FamilyUpdate update;
    std::size_t created = 0;
    for (int pass = 0; !open.empty(); ++pass) {
        const auto report = [&](double done) { context.report("refine", 1.0 - std::ldexp(1.0 - done / 2, -pass)); };
        report(0);
        std::erase_if(open, [&](LeafId leaf) { return family_->node(leaf).depth >= max_depth; });
        marks(open, answers, report);
        marked.clear();
        marked.reserve(open.size());
        for (std::size_t i = 0; i < open.size(); ++i)
            if (answers[i]) marked.push_back(open[i]);
        if (marked.empty()) break;
        check_refine_memory(context, memory_bytes(), leaf_count(), marked.size(), open.size(), tree().child_count);
        apply_refine(marked, update);
        created += update.created.size();
        std::swap(open, update.created);
        open.insert(open.end(), update.reshaped.begin(), update.reshaped.end());
        check_refine_memory(context, memory_bytes(), leaf_count(), 0, 0, tree().child_count);
    }
    context.report("refine", 1);
    return created;
}

template <class Marks>
std::size_t Hierarchy::coarsen_until(const RunContext& context, Marks&& marks) {
    std::vector<LeafId> open = family_->ordered_leaves(), wanted;
    detail::PoolVector<std::uint8_t> answers;
    FamilyUpdate update;
    std::size_t created = 0;
    for (int pass = 0; !open.empty(); ++pass) {
        const auto report = [&](double done) { context.report("coarsen", 1.0 - std::ldexp(1.0 - done / 2, -pass)); };
        report(0);
        marks(open, answers, report);
        for (std::size_t i = 0; i < open.size(); ++i)
            if (answers[i]) wanted.push_back(open[i]);
        const std::vector<LeafHandle> before = handles(wanted);
        apply_coarsen(wanted, update);
        if (update.created.empty()) break;
        created += update.created.size();
        // Leaves that are wanted and still exist may be merged with the new leaves.
        wanted.clear();
        for (LeafHandle leaf : before)
            if (is_leaf(leaf)) wanted.push_back(leaf.slot);
        open = update.created;
    }
    context.report("coarsen", 1);
    return created;
}

std::size_t Hierarchy::refine_where(const LeafPredicate& wanted, int max_depth, const RunContext& context) {
    require_not_lost();
    return with_threads(context, [&] {
        return refine_until(family_->ordered_leaves(), max_depth, context,
                            [&](const auto& leaves, auto& answers, const auto&) { ask(wanted, leaves, answers); });
    });
}

/// @param spared  sorted nodes; leaves below them are split only if a neighbour requires it
std::size_t Hierarchy::refine_over(const ErrorEstimator& estimator, double tolerance, std::vector<LeafId> open,
                                   int max_depth, const RunContext& context, std::span<const HierarchyNode> spared) {
    const auto is_spared = [&](HierarchyNode node) {
        for (;; node = tree().parent(node)) {
            if (std::binary_search(spared.begin(), spared.end(), node)) return true;
            if (node.depth == 0) return false;
        }
    };
    std::vector<double> errors;
    return refine_until(std::move(open), max_depth, context,
                        [&](std::span<const LeafId> leaves, detail::PoolVector<std::uint8_t>& answers,
                            const std::function<void(double)>& report) {
                            answers.resize(leaves.size());
                            estimate_leaves(*family_, leaves, estimator, report, errors);
                            // A NaN error is not within the tolerance.
                            for (std::size_t i = 0; i < leaves.size(); ++i)
                                answers[i] = !(errors[i] <= tolerance) &&
                                             (spared.empty() || !is_spared(family_->node(leaves[i])));
                        });
}

std::size_t Hierarchy::refine_where(const ErrorEstimator& estimator, double tolerance, int max_depth,
                                    const RunContext& context) {
    require_not_lost();
    require_estimator(estimator, mesh(), tree(), tolerance);
    return with_threads(
        context, [&] { return refine_over(estimator, tolerance, family_->ordered_leaves(), max_depth, context, {}); });
}

std::size_t Hierarchy::coarsen_where(const LeafPredicate& wanted, const RunContext& context) {
    require_not_lost();
    return with_threads(context, [&] {
        return coarsen_until(context,
                             [&](const auto& leaves, auto& answers, const auto&) { ask(wanted, leaves, answers); });
    });
}

std::size_t Hierarchy::coarsen_where(const ErrorEstimator& estimator, double tolerance, const RunContext& context) {
    require_not_lost();
    require_estimator(estimator, mesh(), tree(), tolerance);
    return with_threads(context, [&] {
        std::vector<HierarchyNode> parents;
        std::vector<std::size_t> parent;  // per leaf
        std::vector<double> errors;
        const std::vector<LeafId> first = family_->ordered_leaves();
        estimate_leaves(
            *family_, first, estimator, [&](double) { context.report("coarsen", 0); }, errors);
        int deepest = 0;
        std::vector<HierarchyNode> over;
        for (std::size_t i = 0; i < first.size(); ++i) {
            deepest = std::max<int>(deepest, family_->node(first[i]).depth);
            if (!(errors[i] <= tolerance)) over.push_back(family_->node(first[i]));
        }
        std::sort(over.begin(), over.end());
        const auto within = [&](std::span<const LeafId> leaves, detail::PoolVector<std::uint8_t>& answers,
                                const std::function<void(double)>& report) {
            constexpr auto k_root = std::numeric_limits<std::size_t>::max();
            answers.assign(leaves.size(), 0);
            parents.clear();
            parent.assign(leaves.size(), k_root);
            for (std::size_t i = 0; i < leaves.size(); ++i) {
                const HierarchyNode node = family_->node(leaves[i]);
                if (node.depth == 0) continue;
                // Siblings mostly follow one another.
                if (const HierarchyNode above = tree().parent(node); parents.empty() || parents.back() != above)
                    parents.push_back(above);
                parent[i] = parents.size() - 1;
            }
            errors.resize(parents.size());
            estimate_in_turns(parents.size(), report, [&](std::size_t begin, std::size_t count) {
                family_->node_errors(std::span(parents).subspan(begin, count), estimator,
                                     std::span(errors).subspan(begin, count));
            });
            for (std::size_t i = 0; i < leaves.size(); ++i)
                if (parent[i] != k_root) answers[i] = errors[parent[i]] <= tolerance;
        };
        const std::size_t created = coarsen_until(context, within);
        // Leaves beside a merged leaf have other triangles now, whose errors are not known yet.
        if (created != 0) refine_over(estimator, tolerance, family_->ordered_leaves(), deepest, context, over);
        return created;
    });
}

}  // namespace tetrakis
