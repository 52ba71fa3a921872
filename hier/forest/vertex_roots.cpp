#include "vertex_roots.hpp"

#include <bit>

namespace tetrakis {

VertexCell VertexRoots::existing(const VertexCell& cell) const {
    if (all_stay() || cell.root >= count()) return cell;
    VertexCell at{cell.root, {0, 0}, 0};
    VertexJoint::Child known{true, crease[cell.root], {}};
    std::copy_n(smooth_from.begin() + 4 * std::ptrdiff_t{cell.root}, 4, known.smooth_from.begin());
    constexpr int child_at[2][2] = {{0, 1}, {3, 2}};
    while (at.level < cell.level) {
        const int bit = cell.level - 1 - at.level;
        int child = child_at[cell.at.y >> bit & 1][cell.at.x >> bit & 1];
        const unsigned sides = known.crease & (1u << child | 1u << (child + 3) % 4);
        VertexJoint::Child next{true, static_cast<std::uint8_t>(sides), known.smooth_from};
        if (const JointCell* joint = find_joint(at)) {
            const auto& children = joints[joint->joint].children[joint->place];
            while (!children[static_cast<std::size_t>(child)].exists) child = (child + 1) % 4;
            next = children[static_cast<std::size_t>(child)];
        } else if (const int side = std::countr_zero(known.crease);
                   std::has_single_bit(known.crease) && known.smooth_from[static_cast<std::size_t>(side)] <= at.level) {
            if (child == side || child == (side + 1) % 4) child = child == side ? (side + 3) % 4 : (side + 2) % 4;
            next = {true, 0, {}};
        }
        at = {cell.root,
              {2 * at.at.x + (child == 1 || child == 2 ? 1 : 0), 2 * at.at.y + (child >= 2 ? 1 : 0)},
              static_cast<std::uint8_t>(at.level + 1)};
        known = next;
    }
    return at;
}

}  // namespace tetrakis
