#include "tetrakis/hier/radix_sort.hpp"
#include "tetrakis/hier/vec.hpp"
#include "tetrakis/refine/hierarchy.hpp"

#include <algorithm>
#include <limits>
#include <utility>

// The leaves along a curve that parts are cut from.
namespace tetrakis {

namespace {

/// Every third bit, from the lowest on: those of a number below 2^21.
std::uint64_t spread(std::uint64_t x) {
    constexpr std::pair<int, std::uint64_t> k_moves[] = {{32, 0x1F00000000FFFFu},
                                                         {16, 0x1F0000FF0000FFu},
                                                         {8, 0x100F00F00F00F00Fu},
                                                         {4, 0x10C30C30C30C30C3u},
                                                         {2, 0x1249249249249249u}};
    for (const auto& [bits, mask] : k_moves) x = (x | x << bits) & mask;
    return x;
}

}  // namespace

std::vector<LeafHandle> Hierarchy::leaves_for_parts() const {
    const std::span<const LeafHandle> in_order = leaves();
    if (family() != "sqrt3") return {in_order.begin(), in_order.end()};
    const HierarchyMesh triangles = to_mesh({.positions = MeshPositions::finest});
    const PolygonMesh& mesh = triangles.mesh;
    const Box3d box = bounding_box(mesh.positions);
    constexpr double k_cells = 1u << 21;
    const double scale = k_cells / std::max({box.upper.x - box.lower.x, box.upper.y - box.lower.y,
                                             box.upper.z - box.lower.z, std::numeric_limits<double>::min()});
    struct Item {
        std::uint64_t key;
        LeafHandle leaf;
    };
    std::vector<Item> items(triangles.leaves.size()), spare;
    for (std::size_t f = 0; f < items.size(); ++f) {
        Vec3d centre(0);
        for (std::size_t c = 3 * f; c < 3 * f + 3; ++c) centre += mesh.positions[mesh.face_vertices[c]];
        std::uint64_t key = 0;
        for (int k = 0; k < 3; ++k) {
            const double at = std::clamp((centre[k] / 3 - box.lower[k]) * scale, 0.0, k_cells - 1);
            key |= spread(static_cast<std::uint64_t>(at)) << k;
        }
        items[f] = {key, triangles.leaves[f]};
    }
    radix_sort(items, spare, [](const Item& item) { return item.key; });
    std::vector<LeafHandle> result;
    result.reserve(items.size());
    for (const Item& item : items) result.push_back(item.leaf);
    return result;
}

}  // namespace tetrakis
