#pragma once

#include "../../hier/base/disjoint_sets.hpp"
#include "../../hier/mesh/control_mesh.hpp"

#include <algorithm>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

// Topology of face lists by counting edges, for comparing output meshes with their control mesh.
namespace tetrakis::test {

struct SurfaceTopology {
    std::string fault;  ///< first violation of manifoldness at edges, or empty
    std::int64_t euler = 0;
    std::uint32_t boundary_loops = 0;  ///< connected components of the boundary
    bool operator==(const SurfaceTopology&) const = default;
};

/// @param faces  vertex numbers of each face, in cyclic order
template <class Faces>
SurfaceTopology topology(const Faces& faces) {
    const auto key = [](std::uint32_t a, std::uint32_t b) { return (std::uint64_t{a} << 32) | b; };
    SurfaceTopology result;
    std::vector<std::uint64_t> directed;
    std::vector<std::uint32_t> vertices;
    std::int64_t face_count = 0;
    for (const auto& face : faces) {
        ++face_count;
        const std::size_t n = face.size();
        for (std::size_t i = 0; i < n; ++i) {
            const std::uint32_t a = face[i], b = face[(i + 1) % n];
            vertices.push_back(a);
            directed.push_back(key(a, b));
            if (a == b && result.fault.empty()) result.fault = "a face repeats vertex " + std::to_string(a);
        }
    }
    std::sort(vertices.begin(), vertices.end());
    const auto vertex_count = std::unique(vertices.begin(), vertices.end()) - vertices.begin();
    std::sort(directed.begin(), directed.end());
    if (const auto twice = std::adjacent_find(directed.begin(), directed.end()); twice != directed.end()) {
        if (result.fault.empty())
            result.fault = "edge " + std::to_string(*twice >> 32) + " -> " +
                           std::to_string(static_cast<std::uint32_t>(*twice)) + " is used twice";
        directed.erase(std::unique(directed.begin(), directed.end()), directed.end());
    }
    std::int64_t edge_count = 0;
    std::vector<std::pair<std::uint32_t, std::uint32_t>> open;
    for (const std::uint64_t edge : directed) {
        const auto a = static_cast<std::uint32_t>(edge >> 32), b = static_cast<std::uint32_t>(edge);
        const bool alone = !std::binary_search(directed.begin(), directed.end(), key(b, a));
        edge_count += alone || a < b;
        if (alone) open.emplace_back(a, b);
    }
    result.euler = static_cast<std::int64_t>(vertex_count) - edge_count + face_count;

    std::vector<std::uint32_t> boundary;
    for (const auto& [a, b] : open) boundary.insert(boundary.end(), {a, b});
    std::sort(boundary.begin(), boundary.end());
    boundary.erase(std::unique(boundary.begin(), boundary.end()), boundary.end());
    tetrakis::detail::DisjointSets loops(boundary.size());
    const auto number = [&](std::uint32_t v) {
        return static_cast<std::uint32_t>(std::ranges::lower_bound(boundary, v) - boundary.begin());
    };
    for (const auto& [a, b] : open) loops.unite(number(a), number(b));
    for (std::uint32_t i = 0; i < boundary.size(); ++i) result.boundary_loops += loops.find(i) == i;
    return result;
}

/// Topology of the control mesh without its holes.
inline SurfaceTopology surface_topology(const ControlMesh& mesh) {
    std::vector<std::vector<std::uint32_t>> faces;
    for (std::uint32_t f = 0; f < mesh.face_count(); ++f) {
        if (mesh.is_hole(FaceId(f))) continue;
        const std::uint32_t h = mesh.face_halfedge(FaceId(f)).value;
        faces.emplace_back();
        for (std::uint32_t i = 0; i < mesh.face_size(FaceId(f)); ++i)
            faces.back().push_back(mesh.origin(HalfedgeId(h + i)).value);
    }
    return topology(faces);
}

}  // namespace tetrakis::test
