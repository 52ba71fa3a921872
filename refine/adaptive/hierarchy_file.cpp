#include "hierarchy_file.hpp"

#include "../../hier/base/crc32.hpp"
#include "../../hier/base/error.hpp"
#include "../../hier/base/files.hpp"
#include "../families/hierarchy_family.hpp"
#include "hierarchy.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <filesystem>
#include <span>
#include <string>
#include <utility>

namespace tetrakis::detail {

namespace {

constexpr std::array<char, 8> k_magic{'t', 'e', 't', 'r', 'a', 'k', 'i', 's'};
constexpr std::uint32_t k_version = 3;
constexpr std::size_t k_fixed = 40;  // bytes before the names
constexpr std::size_t k_checksum = 4;

std::uint64_t read_number(std::span<const std::byte> bytes, std::size_t at, int size) {
    std::uint64_t value = 0;
    for (int i = 0; i < size; ++i)
        value |= static_cast<std::uint64_t>(bytes[at + static_cast<std::size_t>(i)]) << 8 * i;
    return value;
}

[[noreturn]] void refuse(const std::string& what) { throw Error(ErrorCode::invalid_input, "saved hierarchy: " + what); }

std::string names(const HierarchyFileHeader& header) {
    std::string text;
    for (const std::string_view name : {header.scheme, header.family, header.rules}) text.append(name) += '\0';
    return text;
}

/// Calls is_split(node) for the nodes of all trees in preorder, and visits a node's children if it returns true.
template <class IsSplit>
void for_each_node(const HierarchyTree& tree, const std::function<bool(std::uint32_t)>& has_root,
                   const IsSplit& is_split) {
    std::vector<HierarchyNode> open;
    for (std::uint32_t r = 0; r < tree.root_bound; ++r) {
        if (has_root(r)) open.push_back({r, 0, 0});
        while (!open.empty()) {
            const HierarchyNode node = open.back();
            open.pop_back();
            if (!is_split(node)) continue;
            for (int k = tree.children_of(node); k-- > 0;) open.push_back(tree.child(node, k));
        }
    }
}

}  // namespace

// FNV-1a on 64-bit words.
std::uint64_t mesh_fingerprint(const ControlMesh& mesh) {
    std::uint64_t state = 0xCBF2'9CE4'8422'2325u;
    const auto add = [&](std::uint64_t word) { state = (state ^ word) * 0x0000'0100'0000'01B3u; };
    const ControlMeshData& data = mesh.data();
    for (const auto* numbers : {&data.face_offsets, &data.face_vertices}) {
        add(numbers->size());
        for (const std::uint32_t number : *numbers) add(number);
    }
    for (std::uint32_t f = 0; f < mesh.face_count(); ++f) add(mesh.is_hole(FaceId(f)));
    for (std::uint32_t e = 0; e < mesh.edge_count(); ++e) add(std::bit_cast<std::uint32_t>(mesh.sharpness(EdgeId(e))));
    for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v)
        add(std::bit_cast<std::uint32_t>(mesh.sharpness(VertexId(v))));
    // Words also differ in their upper bits, which the product alone does not carry down.
    return state ^ state >> 32;
}

std::vector<std::byte> encode_hierarchy(const HierarchyFileHeader& header, const HierarchyTree& tree,
                                        const std::function<bool(std::uint32_t)>& has_root,
                                        std::span<const HierarchyNode> nodes) {
    std::vector<std::byte> bits;
    std::uint64_t bit_count = 0;
    const auto put = [&](bool bit) {
        if (bit_count % 8 == 0) bits.push_back(std::byte{0});
        if (bit) bits.back() |= static_cast<std::byte>(1u << bit_count % 8);
        ++bit_count;
    };
    std::size_t next = 0;
    for_each_node(tree, has_root, [&](const HierarchyNode& node) {
        const bool is_leaf = nodes[next] == node;
        put(!is_leaf);
        if (is_leaf) ++next;
        return !is_leaf;
    });
    const std::string text = names(header);
    std::vector<std::byte> bytes;
    const auto add = [&](std::span<const std::byte> some) {
        for (const std::byte byte : some) bytes.push_back(byte);
    };
    const auto add_number = [&](std::uint64_t value, std::size_t size) {
        for (std::size_t i = 0; i < size; ++i) bytes.push_back(static_cast<std::byte>(value >> 8 * i & 0xFF));
    };
    add(std::as_bytes(std::span(k_magic)));
    add_number(k_version, 4);
    add_number(text.size(), 4);
    add_number(bits.size(), 8);
    add_number(header.mesh_fingerprint, 8);
    add_number(nodes.size(), 8);
    add(std::as_bytes(std::span(text)));
    add(bits);
    add_number(crc32(bytes), k_checksum);
    return bytes;
}

std::vector<HierarchyNode> decode_hierarchy(std::span<const std::byte> bytes, const HierarchyFileHeader& header,
                                            const HierarchyTree& tree,
                                            const std::function<bool(std::uint32_t)>& has_root) {
    if (bytes.size() < k_fixed + k_checksum)
        refuse("its " + std::to_string(bytes.size()) + " bytes are too few for one; the file is cut off or another");
    if (std::memcmp(bytes.data(), k_magic.data(), k_magic.size()) != 0) refuse("it does not begin as one");
    const std::uint64_t version = read_number(bytes, 8, 4);
    if (version != k_version)
        refuse("it has version " + std::to_string(version) + ", but this program reads version " +
               std::to_string(k_version));
    const std::uint64_t text_size = read_number(bytes, 12, 4), bit_bytes = read_number(bytes, 16, 8);
    const std::uint64_t payload = bytes.size() - k_fixed - k_checksum;
    if (text_size > payload || bit_bytes != payload - text_size)
        refuse("it has " + std::to_string(bytes.size()) + " bytes, but says otherwise; the file is cut off or corrupt");
    if (crc32(bytes.first(bytes.size() - k_checksum)) != read_number(bytes, bytes.size() - k_checksum, 4))
        refuse("its checksum does not match; the file is corrupt");
    const std::string text(reinterpret_cast<const char*>(bytes.data()) + k_fixed, text_size);
    if (text != names(header)) {
        const std::string shown = text.substr(0, text.find('\0'));
        // The family follows from scheme and rules, so the message names the rules.
        const std::size_t family_end = text.find('\0', shown.size() + 1);
        if (shown == header.scheme && family_end != std::string::npos && family_end + 1 < text.size()) {
            const std::string rules = text.substr(family_end + 1, text.size() - family_end - 2);
            const auto named = [](const std::string& choices) { return choices.empty() ? "plain rules" : choices; };
            if (rules != header.rules)
                refuse("it was saved with " + named(rules) + " of scheme \"" + shown + "\", this hierarchy has " +
                       named(std::string(header.rules)));
        }
        refuse("it belongs to scheme \"" + shown + "\" or to another family of it, this hierarchy to \"" +
               std::string(header.scheme) + "\"");
    }
    if (read_number(bytes, 24, 8) != header.mesh_fingerprint)
        refuse("it belongs to a control mesh of other faces, holes or tags");

    const std::uint64_t leaf_count = read_number(bytes, 32, 8);
    const std::span<const std::byte> bits = bytes.subspan(k_fixed + text_size, bit_bytes);
    if (leaf_count > 8 * bit_bytes) refuse("it has fewer bits than leaves");
    std::vector<HierarchyNode> nodes;
    nodes.reserve(leaf_count);
    std::uint64_t at = 0;
    for_each_node(tree, has_root, [&](const HierarchyNode& node) {
        if (at == 8 * bit_bytes) refuse("its trees end too early");
        const bool is_split = (static_cast<unsigned>(bits[at / 8]) >> at % 8 & 1u) != 0;
        ++at;
        if (!is_split) nodes.push_back(node);
        if (is_split && node.depth >= tree.max_depth)
            refuse("a tree is deeper than " + std::to_string(tree.max_depth) + " splits");
        return is_split;
    });
    if (nodes.size() != leaf_count || (at + 7) / 8 != bit_bytes) refuse("its trees have another number of leaves");
    if (at % 8 != 0 && static_cast<unsigned>(bits.back()) >> at % 8 != 0) refuse("it has bits after its trees");
    return nodes;
}

}  // namespace tetrakis::detail

namespace tetrakis {

namespace {

detail::HierarchyFileHeader header(const HierarchyFamily& family, const SchemeInfo& scheme, std::string_view rules) {
    return {scheme.name, family.name(), rules, detail::mesh_fingerprint(family.mesh())};
}

[[noreturn]] void not_conforming() {
    throw Error(ErrorCode::invalid_input, "saved hierarchy: its leaves are no conforming refinement");
}

std::vector<HierarchyNode> ordered_nodes(const HierarchyFamily& family) {
    std::vector<HierarchyNode> nodes;
    nodes.reserve(family.leaf_count());
    for (LeafId leaf : family.ordered_leaves()) nodes.push_back(family.node(leaf));
    return nodes;
}

/// Splits leaves of `family` that are ancestors of the nodes. Throws if one is neither a node nor an ancestor of one.
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
}

}  // namespace

std::vector<std::byte> Hierarchy::saved() const {
    require_not_lost();
    return detail::encode_hierarchy(
        header(*family_, *scheme_, rules_), tree(), [&](std::uint32_t root) { return family_->has_root(root); },
        ordered_nodes(*family_));
}

void Hierarchy::save(const std::filesystem::path& path) const {
    AtomicFile file(path);
    file.write(saved());
    file.commit();
}

void Hierarchy::load(std::span<const std::byte> bytes) {
    replace_leaves(rebuilt(detail::decode_hierarchy(bytes, header(*family_, *scheme_, rules_), tree(),
                                                    [&](std::uint32_t root) { return family_->has_root(root); })));
}

std::unique_ptr<HierarchyFamily> Hierarchy::rebuilt(std::span<const HierarchyNode> nodes) const {
    std::unique_ptr<HierarchyFamily> family = family_->fresh();
    restore(*family, nodes);
    // A split may have split other leaves, too.
    if (!std::ranges::equal(ordered_nodes(*family), nodes)) not_conforming();
    return family;
}

// All slots, present and future, get a generation that no handle has.
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
    if (closes_up) replace_leaves(rebuilt(ordered_nodes(*family_)));
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
        // A leaf's corners must be its node's. family_->check() has verified that neighbours see each other.
        const LeafView view = family_->view(all[i].slot);
        const NodeView expected = family_->view(node);
        for (std::size_t k = 0; k < view.corner_count; ++k) {
            if (view.corner[k] != expected.corner[k])
                return name + ": corner " + std::to_string(k) + " is not where its node has it";
        }
    }
    return std::nullopt;
}

}  // namespace tetrakis
