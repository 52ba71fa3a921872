#pragma once

#include "../../hier/mesh/control_mesh.hpp"
#include "../families/hierarchy_leaf.hpp"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string_view>
#include <vector>

namespace tetrakis::detail {

/// What a file of leaves says besides the leaves; a file is read only into what has the same.
struct HierarchyFileHeader {
    std::string_view scheme, family, rules;  ///< rules: rule_choices()
    std::uint64_t mesh_fingerprint = 0;
};

/// Of faces, holes, creases and corners: what leaves are numbered by. Points may be others when they come back.
std::uint64_t mesh_fingerprint(const ControlMesh& mesh);

/// Leaves as bits: per root, its tree in preorder, 1 for a split node, 0 for a leaf. A file is: 8 bytes of magic; a
/// version, bytes of names, bytes of bits (4, 4, 8); fingerprint, leaves (8, 8); scheme, family and choices of
/// rules, each ended by a zero byte; the bits, from the lowest of each byte; CRC-32 of all before. Numbers are
/// little-endian.
/// @param has_root  whether a root exists; those that do not take no bit
/// @param nodes     leaves in order
std::vector<std::byte> encode_hierarchy(const HierarchyFileHeader& header, const HierarchyTree& tree,
                                        const std::function<bool(std::uint32_t)>& has_root,
                                        std::span<const HierarchyNode> nodes);
/// @throws Error  invalid_input: what is wrong with the bytes, or does not fit the header
std::vector<HierarchyNode> decode_hierarchy(std::span<const std::byte> bytes, const HierarchyFileHeader& header,
                                            const HierarchyTree& tree,
                                            const std::function<bool(std::uint32_t)>& has_root);

}  // namespace tetrakis::detail
