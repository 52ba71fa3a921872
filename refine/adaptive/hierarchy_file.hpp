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

/// Data of a file besides its leaves. A file can be loaded only into a hierarchy with the same data.
struct HierarchyFileHeader {
    std::string_view scheme, family, rules;  ///< rules: rule_choices()
    std::uint64_t mesh_fingerprint = 0;
};

/// Hash of faces, holes, creases and corners, which leaves' numbers depend on. Positions may differ after loading.
std::uint64_t mesh_fingerprint(const ControlMesh& mesh);

/// Encodes leaves as bits: per root, its tree in preorder, 1 for a split node, 0 for a leaf. A file has: 8 bytes of
/// magic; version, number of bytes of names, number of bytes of bits (4, 4, 8 bytes); fingerprint, number of leaves (8,
/// 8); names of scheme, family and rules, each ended by a zero byte; the bits, from the lowest one of each byte; CRC-32
/// of all bytes before it. Numbers are little-endian.
/// @param has_root  whether a root exists; a root that does not exist takes no bit
/// @param nodes     the leaves in order
std::vector<std::byte> encode_hierarchy(const HierarchyFileHeader& header, const HierarchyTree& tree,
                                        const std::function<bool(std::uint32_t)>& has_root,
                                        std::span<const HierarchyNode> nodes);
/// @throws Error  invalid_input: the message says how the bytes are wrong or do not fit the header
std::vector<HierarchyNode> decode_hierarchy(std::span<const std::byte> bytes, const HierarchyFileHeader& header,
                                            const HierarchyTree& tree,
                                            const std::function<bool(std::uint32_t)>& has_root);

}  // namespace tetrakis::detail
