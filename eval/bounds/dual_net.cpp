#include "dual_net.hpp"

#include <algorithm>
#include <unordered_map>

namespace tetrakis::detail {

namespace {

bool is_at_root_corner(const VertexCell& cell, int corner) {
    const std::uint32_t last = (1u << cell.level) - 1;
    return cell.at.x == (corner == 1 || corner == 2 ? last : 0) && cell.at.y == (corner >= 2 ? last : 0);
}

/// The numbers of leaves that are vertices of a mesh.
std::vector<std::uint32_t> vertices_of_leaves(const VertexForest& forest, const DualFaces& faces) {
    std::vector<std::uint32_t> vertex(forest.leaf_slots(), DualCorners::none);
    for (std::uint32_t v = 0; v < faces.leaves.size(); ++v) vertex[faces.leaves[v].value] = v;
    for (const DualFaces::OtherSide& side : faces.other_sides) vertex[side.leaf.value] = side.vertex;
    return vertex;
}

/// Adds the points where creases end.
void add_ends(const VertexForest& forest, const DualCorners& corners, DualNet& net) {
    const auto key = [](const DualCorners::Member& m) { return 4 * m.root + static_cast<std::uint32_t>(m.corner); };
    std::unordered_map<std::uint32_t, LeafId> leaf_at;
    for (const DualCorners::Point& point : corners.points())
        if (!point.is_face())
            for (const DualCorners::Member& m : point.around) leaf_at.emplace(key(m), LeafId{});
    if (leaf_at.empty()) return;
    const std::vector<std::uint32_t> vertex = vertices_of_leaves(forest, net.faces);
    for (std::uint32_t slot = 0; slot < vertex.size(); ++slot) {
        if (vertex[slot] == DualCorners::none) continue;
        const VertexCell cell = forest.cell(LeafId(slot));
        for (int c = 0; c < 4; ++c)
            if (is_at_root_corner(cell, c))
                if (const auto found = leaf_at.find(key({cell.root, c})); found != leaf_at.end())
                    found->second = LeafId(slot);
    }
    for (std::uint32_t p = 0; p < corners.points().size(); ++p) {
        const DualCorners::Point& point = corners.points()[p];
        if (point.is_face()) continue;
        const auto is_there = [&](const DualCorners::Member& m) { return leaf_at[key(m)].valid(); };
        if (!std::all_of(point.around.begin(), point.around.end(), is_there)) continue;  // in a hole
        for (const DualCorners::Member& m : point.around) {
            const LeafId leaf = leaf_at[key(m)];
            net.faces.corners.push_back({leaf, static_cast<std::uint8_t>(m.corner)});
            net.faces.face_vertices.push_back(vertex[leaf.value]);
        }
        net.faces.face_offsets.push_back(static_cast<std::uint32_t>(net.faces.face_vertices.size()));
        net.point.push_back(p);
        net.open.push_back(point.closed ? 0 : 1);
    }
}

}  // namespace

DualNet dual_net(const VertexForest& forest, const DualCorners& corners) {
    DualNet net;
    net.faces = forest.faces(FaceCorners::leaves);
    net.face_count = net.faces.control_faces.size();
    net.point.resize(net.face_count);
    for (std::size_t f = 0; f < net.face_count; ++f) {
        const DualFaces::Corner& first = net.faces.corners[net.faces.face_offsets[f]];
        const VertexCell cell = forest.cell(first.leaf);
        const bool at_root = first.at < DualFaces::Corner::k_on_side && is_at_root_corner(cell, first.at);
        net.point[f] = at_root ? corners.point(cell.root, first.at) : DualCorners::none;
    }
    net.open.assign(net.face_count, 0);
    add_ends(forest, corners, net);
    return net;
}

}  // namespace tetrakis::detail
