#include "hierarchy.hpp"

#include "../../hier/base/error.hpp"
#include "../../hier/base/memory.hpp"
#include "../../hier/base/parallel.hpp"
#include "../../schemes/core/rule_step.hpp"
#include "../families/hierarchy_families.hpp"
#include "../points/row_points.hpp"
#include "../points/vertex_links.hpp"
#include "../uniform/refine.hpp"

#include <algorithm>
#include <new>
#include <string>
#include <tuple>
#include <utility>

namespace tetrakis {

Hierarchy::Hierarchy(std::unique_ptr<HierarchyFamily> family, const SchemeInfo& scheme, const RuleOptions& rules)
    : family_(std::move(family)), scheme_(&scheme), rules_(rule_choices(rules)), generation_(family_->leaf_slots(), 0) {
    for (std::uint32_t f = 0; f < mesh().face_count(); ++f) has_holes_ |= mesh().is_hole(FaceId(f));
}

Hierarchy::Hierarchy(Hierarchy&&) noexcept = default;
Hierarchy& Hierarchy::operator=(Hierarchy&&) noexcept = default;
Hierarchy::~Hierarchy() = default;

const ControlMesh& Hierarchy::mesh() const { return family_->mesh(); }
std::string_view Hierarchy::family() const { return family_->name(); }
const HierarchyTree& Hierarchy::tree() const { return family_->tree(); }
std::uint32_t Hierarchy::leaf_count() const { return family_->leaf_count(); }
std::uint32_t Hierarchy::point_slots() const { return family_->point_slots(); }

// Handles.

void Hierarchy::require_not_lost() const {
    if (lost_)
        throw Error(
            ErrorCode::memory_limit,
            "the system ran out of memory while this hierarchy was being changed, and its leaves are lost; load() "
            "saved ones, or make it anew");
}

void Hierarchy::require_leaf(LeafHandle leaf) const {
    require_not_lost();
    if (is_leaf(leaf)) return;
    const std::string name = "leaf " + std::to_string(leaf.slot.value);
    if (leaf.slot.value >= generation_.size())
        throw Error(ErrorCode::invalid_input,
                    name + " does not exist: the hierarchy has " + std::to_string(generation_.size()) + " slots");
    throw Error(ErrorCode::invalid_input,
                name + " of generation " + std::to_string(leaf.generation) +
                    " is no leaf any more: it was split or merged" +
                    (family_->is_leaf(leaf.slot)
                         ? " (its slot holds generation " + std::to_string(generation_[leaf.slot.value]) + " now)"
                         : std::string()));
}

std::vector<LeafId> Hierarchy::require_leaves(std::span<const LeafHandle> leaves) const {
    std::vector<LeafId> slots;
    slots.reserve(leaves.size());
    for (LeafHandle leaf : leaves) {
        require_leaf(leaf);
        slots.push_back(leaf.slot);
    }
    return slots;
}

void Hierarchy::require_node(const HierarchyNode& node) const {
    if (!tree().is_valid(node) || !family_->has_root(node.root))
        throw Error(ErrorCode::invalid_input, "node (root " + std::to_string(node.root) + ", depth " +
                                                  std::to_string(node.depth) +
                                                  ") is none of this hierarchy: no such root, depth or path");
}

std::vector<LeafHandle> Hierarchy::handles(std::span<const LeafId> slots) const {
    std::vector<LeafHandle> result;
    detail::reserve_large(result, slots.size());
    for (LeafId slot : slots) result.push_back(handle(slot));
    return result;
}

std::span<const LeafHandle> Hierarchy::leaves() const {
    require_not_lost();
    const std::scoped_lock lock(cache_->mutex);
    if (!cache_->valid) {
        cache_->leaves = handles(family_->leaves_on_curve());
        cache_->valid = true;
    }
    return cache_->leaves;
}

bool Hierarchy::is_leaf(LeafHandle leaf) const {
    return !lost_ && leaf.slot.value < generation_.size() && family_->is_leaf(leaf.slot) &&
           generation_[leaf.slot.value] == leaf.generation;
}

HierarchyNode Hierarchy::node(LeafHandle leaf) const {
    require_leaf(leaf);
    return family_->node(leaf.slot);
}

LeafView Hierarchy::view(LeafHandle leaf) const {
    require_leaf(leaf);
    LeafView view = family_->view(leaf.slot);
    view.leaf = leaf;
    return view;
}

NodeView Hierarchy::view(const HierarchyNode& node) const {
    require_node(node);
    return family_->view(node);
}

std::optional<LeafHandle> Hierarchy::find(const HierarchyNode& node) const {
    require_not_lost();
    require_node(node);
    if (const std::optional<LeafId> slot = family_->find(node))
        return slot->valid() ? std::optional(handle(*slot)) : std::nullopt;
    const auto all = leaves();
    const auto found =
        std::partition_point(all.begin(), all.end(), [&](LeafHandle leaf) { return family_->node(leaf.slot) < node; });
    if (found == all.end() || family_->node(found->slot) != node) return std::nullopt;
    return *found;
}

std::optional<HierarchyNode> Hierarchy::parent(const HierarchyNode& node) const {
    require_node(node);
    if (node.depth == 0) return std::nullopt;
    return tree().parent(node);
}

std::vector<HierarchyNode> Hierarchy::children(const HierarchyNode& node) const {
    require_node(node);
    std::vector<HierarchyNode> result;
    if (node.depth >= tree().max_depth) return result;
    for (int k = 0; k < tree().children_of(node); ++k) result.push_back(tree().child(node, k));
    return result;
}

LeafNeighbours Hierarchy::neighbours(LeafHandle leaf, int side) const {
    require_leaf(leaf);
    if (side < 0 || side >= family_->view(leaf.slot).sides())
        throw Error(ErrorCode::invalid_input, "a leaf has no side " + std::to_string(side));
    LeafNeighbours result;
    for (LeafId slot : family_->neighbours(leaf.slot, side))
        if (slot.valid()) result.leaf[result.count++] = handle(slot);
    return result;
}

// Changes.

/// Makes a change that cannot be undone if memory runs out: then the leaves are lost.
template <class Change>
auto Hierarchy::all_or_lost(Change&& change) {
    require_not_lost();
    try {
        return change();
    } catch (const std::bad_alloc&) {
        lost_ = true;
        throw;
    }
}

/// @param make  changes the family's leaves and fills `update`
template <class Make>
void Hierarchy::apply(std::span<const LeafId> marked, FamilyUpdate& update, Make&& make) {
    std::vector<JournalLeaf> removed;
    for (std::size_t i = 0; i < marked.size() && journal_.active(); ++i)
        removed.push_back({handle(marked[i]), family_->node(marked[i])});
    all_or_lost([&] {
        make();
        for (const auto& [slot, node] : update.removed) removed.push_back({handle(slot), node});
        update.removed.clear();
        if (const std::size_t slots = family_->leaf_slots(); slots > generation_.capacity())
            detail::reserve_large(generation_, std::max(slots, 2 * generation_.capacity()));
        generation_.resize(family_->leaf_slots(), first_generation_);
        // A slot with a new leaf gets a new generation.
        for (LeafId slot : update.created) ++generation_[slot.value];
        cache_->valid = false;
        if (!journal_.active()) return;
        std::erase_if(removed, [&](const JournalLeaf& leaf) { return is_leaf(leaf.leaf); });
        std::ranges::sort(removed, {}, &JournalLeaf::leaf);
        removed.erase(std::ranges::unique(removed, {}, &JournalLeaf::leaf).begin(), removed.end());
        using Kind = HierarchyJournal::Kind;
        try {
            journal_.begin_change();
            for (const JournalLeaf& leaf : removed) journal_.add(Kind::removed, leaf);
            for (LeafId slot : update.created) journal_.add(Kind::added, {handle(slot), family_->node(slot)});
            for (LeafId slot : update.reshaped) journal_.add(Kind::reshaped, {handle(slot), family_->node(slot)});
            journal_.end_change();
        } catch (const std::bad_alloc&) {
            journal_.restart();  // the change is complete; readers are told to read everything
        }
    });
}

void Hierarchy::apply_refine(std::span<const LeafId> marked, FamilyUpdate& update) {
    apply(marked, update, [&] { family_->refine(marked, journal_.active(), update); });
}

void Hierarchy::apply_coarsen(std::span<const LeafId> marked, FamilyUpdate& update) {
    apply(marked, update, [&] { family_->coarsen(marked, update); });
}

std::vector<LeafHandle> Hierarchy::refine(std::span<const LeafHandle> leaves) {
    const std::vector<LeafId> marked = require_leaves(leaves);
    for (LeafId slot : marked)
        if (family_->node(slot).depth >= tree().max_depth)
            throw Error(ErrorCode::unsupported, "leaf " + std::to_string(slot.value) + " is at depth " +
                                                    std::to_string(tree().max_depth) +
                                                    ", the deepest one; it cannot be split");
    FamilyUpdate update;
    apply_refine(marked, update);
    return all_or_lost([&] { return handles(update.created); });
}

bool Hierarchy::can_coarsen(LeafHandle leaf) const {
    require_leaf(leaf);
    return !family_->diamond(leaf.slot).empty();
}

std::vector<LeafHandle> Hierarchy::coarsen(LeafHandle diamond) {
    require_leaf(diamond);
    const std::vector<LeafId> members = family_->diamond(diamond.slot);
    if (members.empty())
        throw Error(ErrorCode::invalid_input,
                    "leaf " + std::to_string(diamond.slot.value) +
                        " is not part of a diamond of leaves: it is a root, another leaf of the diamond is split "
                        "further, or a neighbour would be too fine beside the merged leaf");
    FamilyUpdate update;
    apply_coarsen(members, update);
    return all_or_lost([&] { return handles(update.created); });
}

std::vector<LeafHandle> Hierarchy::coarsen(std::span<const LeafHandle> leaves) {
    FamilyUpdate update;
    apply_coarsen(require_leaves(leaves), update);
    return all_or_lost([&] { return handles(update.created); });
}

// Points.

void Hierarchy::require_sites(std::span<const Site> sites, std::size_t out) const {
    if (sites.size() != out)
        throw Error(ErrorCode::invalid_input, "there are " + std::to_string(sites.size()) + " sites, but room for " +
                                                  std::to_string(out) + " results");
    for (const Site& site : sites)
        if (const std::string fault = family_->check_site(site); !fault.empty())
            throw Error(ErrorCode::invalid_input, "a site is none of this hierarchy: " + fault);
}

void Hierarchy::require_level(std::span<const Site> sites, int level) const {
    const int deepest = family_->source().max_level();
    if (level > deepest)
        throw Error(ErrorCode::invalid_input,
                    "level " + std::to_string(level) + " is beyond the deepest one, " + std::to_string(deepest));
    for (const Site& site : sites)
        if (const int first = family_->source().first_level(site); level < first)
            throw Error(ErrorCode::invalid_input, "level " + std::to_string(level) +
                                                      " does not have that vertex yet: its first level is " +
                                                      std::to_string(first));
}

int Hierarchy::first_level(const Site& site) const {
    require_sites({&site, 1}, 1);
    return family_->source().first_level(site);
}

void Hierarchy::positions(std::span<const Site> sites, int level, std::span<Vec3d> out) const {
    require_sites(sites, out.size());
    require_level(sites, level);
    family_->source().positions(sites, level, out);
}

void Hierarchy::frames(std::span<const Site> sites, int level, std::span<LimitPoint> out) const {
    require_sites(sites, out.size());
    require_level(sites, level);
    family_->source().frames(sites, level, out);
}

void Hierarchy::limit_positions(std::span<const Site> sites, std::span<Vec3d> out) const {
    require_sites(sites, out.size());
    family_->source().limit_positions(sites, out);
}

void Hierarchy::limits(std::span<const Site> sites, std::span<LimitPoint> out) const {
    require_sites(sites, out.size());
    family_->source().limits(sites, out);
}

void Hierarchy::normals(std::span<const Site> sites, std::span<Vec3d> out) const {
    require_sites(sites, out.size());
    family_->source().normals(sites, out);
}

Vec3d Hierarchy::position(const Site& site, int level) const {
    Vec3d result;
    positions({&site, 1}, level, {&result, 1});
    return result;
}

LimitPoint Hierarchy::limit(const Site& site) const {
    LimitPoint result;
    limits({&site, 1}, {&result, 1});
    return result;
}

LimitPoint Hierarchy::frame(const Site& site, int level) const {
    LimitPoint result;
    frames({&site, 1}, level, {&result, 1});
    return result;
}

std::array<Vec3d, 2> Hierarchy::tangents(const Site& site) const {
    const LimitPoint point = limit(site);
    return {point.tangent1, point.tangent2};
}

std::array<Vec3d, 2> Hierarchy::tangents(const Site& site, int level) const {
    const LimitPoint point = frame(site, level);
    return {point.tangent1, point.tangent2};
}

std::uint64_t Hierarchy::memory_bytes() const {
    return family_->memory_bytes() + generation_.capacity() * sizeof(std::uint32_t) + journal_.memory_bytes() +
           cache_->leaves.capacity() * sizeof(LeafHandle);
}

// A hierarchy of each family.

Hierarchy make_hierarchy(const ControlMesh& mesh, const SchemeInfo& scheme, const HierarchyOptions& options) {
    if (const int steps = averaging_steps(scheme, options.rules); steps < 0 || steps > k_most_averaging_steps)
        throw Error(ErrorCode::invalid_input, "the number of averaging steps must be from 0 to 64");
    const auto by_rows = [&](const RuleOptions& rules, const VertexRoots* roots) {
        return detail::row_points(mesh, scheme, rules, roots, options.context, options.whole_levels,
                                  options.limit_positions);
    };
    if (scheme.family != MeshFamily::hexagons && fan_lattice(scheme, options.rules) == FanLattice::dual) {
        VertexRoots roots = vertex_roots(mesh, scheme, options.rules);
        std::shared_ptr<const LevelSource> of_cells = by_rows(options.rules, &roots);
        return Hierarchy(vertex_family(mesh, std::move(of_cells), std::move(roots)), scheme, options.rules);
    }
    if (boundary_recedes(scheme, options.rules) && mesh.has_boundary())
        throw Error(ErrorCode::unsupported,
                    "a boundary that recedes leaves sites without vertex; hierarchies need one that is replicated");
    if (scheme.refinement == Refinement::sqrt3) {
        if (!mesh.all_triangles())
            throw Error(ErrorCode::invalid_input, "sqrt3 needs a triangle mesh; triangulate() makes one");
        std::shared_ptr<const LevelSource> levels =
            sqrt3_levels(mesh, scheme, options.rules, options.context, options.whole_levels, options.limit_positions);
        return Hierarchy(sqrt3_family(mesh, std::move(levels)), scheme, options.rules);
    }
    if (scheme.refinement == Refinement::honeycomb)
        throw Error(ErrorCode::unsupported, "there is no hierarchy for " + std::string(scheme.name) +
                                                ": its vertices are no sites of corner cells or triangles");
    const auto source = by_rows(detail::with_crease_method(mesh, scheme, options.rules), nullptr);
    const bool triangles = scheme.family == MeshFamily::triangles;
    return Hierarchy(triangles ? triangle_family(mesh, source) : bisection_family(mesh, source), scheme, options.rules);
}

Hierarchy make_hierarchy(const ControlMesh& mesh, std::string_view scheme, const HierarchyOptions& options) {
    return make_hierarchy(mesh, scheme_named(scheme), options);
}

}  // namespace tetrakis
