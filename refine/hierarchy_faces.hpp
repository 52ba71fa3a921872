#pragma once

#include "tetrakis/hier/exported_triangles.hpp"
#include "tetrakis/hier/huge_memory.hpp"
#include "tetrakis/hier/parallel.hpp"
#include "tetrakis/refine/hierarchy_family.hpp"

#include <utility>

namespace tetrakis::detail {

/// The output mesh of a family whose leaves are exported as triangles. `level(leaf)` is its level as NodeView has it.
template <class Level>
HierarchyFaces faces_of(ExportedTriangles exported, const Level& level) {
    const auto count = static_cast<std::uint32_t>(exported.triangles.size());
    HierarchyFaces faces;
    resize_large(faces.face_offsets, count + std::size_t{1});
    resize_large(faces.face_vertices, 3 * std::size_t{count});
    resize_large(faces.levels, count);
    for_each_index(count, [&](std::uint32_t t) {
        faces.face_offsets[t + std::size_t{1}] = 3 * (t + 1);
        for (std::size_t k = 0; k < 3; ++k) faces.face_vertices[3 * std::size_t{t} + k] = exported.triangles[t][k];
        faces.levels[t] = level(exported.leaves[t]);
    });
    faces.control_faces = std::move(exported.faces);
    faces.sites = std::move(exported.sites);
    faces.leaves = std::move(exported.leaves);
    faces.points = std::move(exported.points);
    return faces;
}

}  // namespace tetrakis::detail
