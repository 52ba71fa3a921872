#pragma once

#include "tetrakis/hier/control_mesh.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <map>
#include <numeric>
#include <span>
#include <string>
#include <utility>
#include <vector>

// Topology by counting edges, for comparing output meshes with their control mesh.
namespace tetrakis::test {

struct SurfaceTopology {
    std::string fault;  ///< first violation of manifoldness at edges, or empty
    std::int64_t euler = 0;
    std::uint32_t boundary_loops = 0;  ///< connected components of the boundary
    bool operator==(const SurfaceTopology&) const = default;
};

/// @param faces  vertex numbers, in cycles
template <class Faces>
SurfaceTopology topology(const Faces& faces) {
    SurfaceTopology result;
    std::map<std::pair<std::uint32_t, std::uint32_t>, int> directed;
    std::map<std::uint32_t, std::uint32_t> parent;  // of boundary vertices
    std::int64_t face_count = 0;
    std::vector<std::uint32_t> vertices;
    for (const auto& face : faces) {
        ++face_count;
        const std::size_t n = face.size();
        for (std::size_t i = 0; i < n; ++i) {
            const std::uint32_t a = face[i], b = face[(i + 1) % n];
            vertices.push_back(a);
            if (a == b && result.fault.empty()) result.fault = "a face repeats vertex " + std::to_string(a);
            if (++directed[{a, b}] > 1 && result.fault.empty())
                result.fault = "edge " + std::to_string(a) + " -> " + std::to_string(b) + " is used twice";
        }
    }
    std::sort(vertices.begin(), vertices.end());
    const auto vertex_count = std::unique(vertices.begin(), vertices.end()) - vertices.begin();
    const auto find = [&](std::uint32_t v) {
        while (parent.at(v) != v) v = parent.at(v);
        return v;
    };
    std::int64_t edge_count = 0;
    for (const auto& [edge, uses] : directed) {
        const auto [a, b] = edge;
        const bool open = directed.count({b, a}) == 0;
        edge_count += open || a < b;
        if (!open) continue;
        parent.try_emplace(a, a);
        parent.try_emplace(b, b);
        parent[find(a)] = find(b);
    }
    for (const auto& [v, p] : parent) result.boundary_loops += v == p;
    result.euler = static_cast<std::int64_t>(vertex_count) - edge_count + face_count;
    return result;
}

/// Of the control mesh less its holes.
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
