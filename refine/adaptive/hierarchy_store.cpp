#include "../../hier/base/error.hpp"
#include "../../hier/base/files.hpp"
#include "../families/hierarchy_family.hpp"
#include "hierarchy.hpp"
#include "hierarchy_file.hpp"

#include <algorithm>
#include <filesystem>
#include <span>
#include <string>
#include <utility>

namespace tetrakis {

namespace {

detail::HierarchyFileHeader header(const HierarchyFamily& family, const SchemeInfo& scheme, std::string_view rules) {
    return {scheme.name, family.name(), rules, detail::mesh_fingerprint(family.mesh())};
}

[[noreturn]] void not_conforming() {
    throw Error(ErrorCode::invalid_input, "saved hierarchy: its leaves are no conforming refinement");
}

/// Splits leaves of `family` that are ancestors of the nodes until its leaves are the nodes.
void restore(HierarchyFamily& family, std::span<const HierarchyNode> nodes) {
    const HierarchyTree& tree = family.tree();
    FamilyUpdate update;
    std::vector<LeafId> marked, open = family.ordered_leaves();
    while (!open.empty()) {
        marked.clear();
        for (LeafId leaf : open) {
            const HierarchyNode node = family.node(leaf);
            const auto found = std::lower_bound(nodes.begin(), nodes.end(), node);
            if (found != nodes.end() && *found == node) continue;
            if (found == nodes.end() || !tree.is_ancestor(node, *found)) not_conforming();
            marked.push_back(leaf);
        }
        if (marked.empty()) break;
        family.refine(marked, false, update);
        open = update.created;
    }
    if (family.leaf_count() != nodes.size()) not_conforming();
}

}  // namespace

std::vector<std::byte> Hierarchy::saved() const {
    require_not_lost();
    std::vector<HierarchyNode> nodes;
    nodes.reserve(leaf_count());
    for (LeafId leaf : family_->ordered_leaves()) nodes.push_back(family_->node(leaf));
    return detail::encode_hierarchy(
        header(*family_, *scheme_, rules_), tree(), [&](const HierarchyNode& node) { return family_->has_node(node); },
        nodes);
}

void Hierarchy::save(const std::filesystem::path& path) const {
    AtomicFile file(path);
    file.write(saved());
    file.commit();
}

void Hierarchy::load(std::span<const std::byte> bytes) {
    replace_leaves(
        rebuilt(detail::decode_hierarchy(bytes, header(*family_, *scheme_, rules_), tree(),
                                         [&](const HierarchyNode& node) { return family_->has_node(node); })));
}

std::unique_ptr<HierarchyFamily> Hierarchy::rebuilt(std::span<const HierarchyNode> nodes) const {
    std::unique_ptr<HierarchyFamily> family = family_->fresh();
    restore(*family, nodes);
    // As many leaves need not be the same ones: a split takes others with it.
    const std::vector<LeafId> leaves = family->ordered_leaves();
    if (!std::equal(leaves.begin(), leaves.end(), nodes.begin(), nodes.end(),
                    [&](LeafId leaf, const HierarchyNode& node) { return family->node(leaf) == node; }))
        not_conforming();
    return family;
}

// All slots are of a generation that no handle has, and so are those to come.
void Hierarchy::replace_leaves(std::unique_ptr<HierarchyFamily> family) {
    std::uint32_t newest = first_generation_;
    for (const std::uint32_t g : generation_) newest = std::max(newest, g);
    detail::PoolVector<std::uint32_t> generation(family->leaf_slots(), newest + 1);
    family_ = std::move(family);
    generation_ = std::move(generation);
    first_generation_ = newest + 1;
    lost_ = false;
    cache_->valid = false;
    journal_.restart();
}

bool Hierarchy::shrink() {
    require_not_lost();
    const bool closes_up = family_->has_free_slots();
    if (closes_up) {
        std::vector<HierarchyNode> nodes;
        nodes.reserve(leaf_count());
        for (LeafId leaf : family_->ordered_leaves()) nodes.push_back(family_->node(leaf));
        replace_leaves(rebuilt(nodes));
    }
    family_->shrink();
    generation_.shrink_to_fit();
    cache_->valid = false;
    std::vector<LeafHandle>().swap(cache_->leaves);
    return closes_up;
}

void Hierarchy::load(const std::filesystem::path& path) {
    const std::string bytes = detail::read_file(path);
    try {
        load(std::as_bytes(std::span(bytes)));
    } catch (const Error& e) {
        throw Error(e.code(), e.what(), path);
    }
}

std::optional<std::string> Hierarchy::check() const {
    if (lost_) return "the system ran out of memory in a change";
    if (auto fault = family_->check()) return fault;
    if (generation_.size() < family_->leaf_slots()) return "slots without generation";
    const std::vector<LeafHandle> all = handles(family_->ordered_leaves());
    if (all.size() != leaf_count()) return "the leaves in order are not all leaves";
    const auto sorted = [](std::span<const LeafHandle> leaves) {
        std::vector<LeafHandle> copy(leaves.begin(), leaves.end());
        std::sort(copy.begin(), copy.end());
        return copy;
    };
    if (sorted(leaves()) != sorted(all)) return "the leaves along the curve are others than those in order";
    for (std::size_t i = 0; i < all.size(); ++i) {
        const HierarchyNode node = family_->node(all[i].slot);
        const std::string name = "leaf " + std::to_string(all[i].slot.value);
        if (!is_leaf(all[i])) return name + ": its handle is stale";
        if (!tree().is_valid(node)) return name + ": its node is none of the tree";
        if (i > 0 && !(family_->node(all[i - 1].slot) < node)) return name + ": it is out of order";
        if (i > 0 && tree().is_ancestor(family_->node(all[i - 1].slot), node))
            return name + ": it lies in another leaf";
        // Its corners are where its node has them, and neighbours see each other.
        const LeafView view = family_->view(all[i].slot);
        const NodeView expected = family_->view(node);
        for (std::size_t k = 0; k < view.corner_count; ++k) {
            if (view.corner[k] != expected.corner[k])
                return name + ": corner " + std::to_string(k) + " is not where its node has it";
        }
        for (int k = 0; k < view.sides(); ++k) {
            for (LeafId across : family_->neighbours(all[i].slot, k)) {
                if (!across.valid()) continue;
                bool back = false;
                const int sides = family_->is_leaf(across) ? family_->view(across).sides() : 0;
                for (int side = 0; side < sides; ++side)
                    for (LeafId leaf : family_->neighbours(across, side)) back |= leaf == all[i].slot;
                if (!back)
                    return name + ": side " + std::to_string(k) +
                           " leads to no leaf, or to one that does not lead back";
            }
        }
    }
    return std::nullopt;
}

}  // namespace tetrakis
