#include "mesh_change.hpp"

#include "../../hier/base/parallel.hpp"

#include <algorithm>

namespace tetrakis {

MeshChange::MeshChange(const ExportedTriangles& before, Triangles triangles_before, const ExportedTriangles& now,
                       Triangles triangles)
    : vertex(now.points.size(), k_new), triangle(triangles.size(), k_new) {
    // Refinement keeps the handles of points, and those of leaves that it does not split.
    std::vector<std::uint32_t> number, first;
    for (std::uint32_t v = 0; v < before.points.size(); ++v) {
        const std::uint32_t point = before.points[v].value;
        if (point >= number.size()) number.resize(std::size_t{point} + point / 2 + 1, k_new);
        number[point] = v;
    }
    for_each_index(static_cast<std::uint32_t>(now.points.size()), [&](std::uint32_t v) {
        if (now.points[v].value < number.size()) vertex[v] = number[now.points[v].value];
    });
    for (auto t = static_cast<std::uint32_t>(triangles_before.size()); t-- > 0;) {
        if (!before.leaves[t].valid()) continue;
        const std::uint32_t leaf = before.leaves[t].value;
        if (leaf >= first.size()) first.resize(std::size_t{leaf} + leaf / 2 + 1, k_new);
        first[leaf] = t;
    }
    for_each_index(static_cast<std::uint32_t>(triangles.size()), [&](std::uint32_t t) {
        const LeafId leaf = now.leaves[t];
        if (!leaf.valid() || leaf.value >= first.size()) return;
        const auto& v = triangles[t];
        const std::array<std::uint32_t, 3> corners{vertex[v[0]], vertex[v[1]], vertex[v[2]]};
        // A leaf's triangles stand next to each other.
        for (std::uint32_t s = first[leaf.value]; s < triangles_before.size() && before.leaves[s] == leaf; ++s)
            if (triangles_before[s] == corners) triangle[t] = s;
    });
}

}  // namespace tetrakis
