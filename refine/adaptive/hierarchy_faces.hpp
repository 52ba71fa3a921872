#pragma once

#include "../../hier/base/memory.hpp"
#include "../../hier/base/parallel.hpp"
#include "../../hier/forest/exported_triangles.hpp"
#include "hierarchy_family.hpp"

#include <utility>

namespace tetrakis::detail {

/// The output mesh of a family whose leaves are exported as triangles. `level(leaf)` is its level as NodeView has it.
template <class Level>
HierarchyFaces faces_of(PooledTriangles exported, bool with_levels, const Level& level) {
    const auto count = static_cast<std::uint32_t>(exported.triangles.size());
    HierarchyFaces faces;
    resize_large(faces.face_offsets, count + std::size_t{1});
    for_each_index(count, [&](std::uint32_t t) { faces.face_offsets[t + std::size_t{1}] = 3 * (t + 1); });
    // Appended: to resize it first would go over all of it twice.
    reserve_large(faces.face_vertices, 3 * std::size_t{count});
    for (const auto& triangle : exported.triangles)
        faces.face_vertices.insert(faces.face_vertices.end(), triangle.begin(), triangle.end());
    if (with_levels) {
        faces.levels.resize(count);
        for_each_index(count, [&](std::uint32_t t) { faces.levels[t] = level(exported.leaves[t]); });
    }
    faces.control_faces = std::move(exported.faces);
    faces.sites = std::move(exported.sites);
    faces.leaves = std::move(exported.leaves);
    faces.points = std::move(exported.points);
    return faces;
}

}  // namespace tetrakis::detail
