#pragma once

#include "mesh_view.hpp"

#include <cstdint>
#include <vector>

namespace tetrakis::detail {

/// Vertices as formats want them that have one normal, and perhaps one UV, for each: the first ones met at a vertex
/// stay with it, each further pair makes a copy after all vertices, in the order of the corners.
struct SplitVertices {
    std::vector<std::uint32_t> corner_vertex;  ///< per corner; empty: as in the mesh
    std::vector<std::uint32_t> copy_of;        ///< per copy: the vertex
    std::vector<std::uint32_t> vertex_normal;  ///< per vertex and copy; empty: normals are by vertex
    std::vector<std::uint32_t> vertex_uv;      ///< per vertex and copy, k_no_uv at isolated vertices; empty: no UVs
    std::uint64_t count = 0;                   ///< vertices and copies

    static constexpr std::uint32_t k_no_uv = 0xFFFF'FFFFu;

    /// @param uvs  whether vertices are split where UVs differ, too
    /// @throws Error unsupported: more than 2^32 - 2 vertices
    SplitVertices(const MeshView& mesh, bool uvs);

    /// The mesh's vertex that a vertex or copy is.
    std::uint32_t original(std::uint64_t v) const {
        return copy_of.size() + v < count ? static_cast<std::uint32_t>(v) : copy_of[v - (count - copy_of.size())];
    }
    /// Its number among the mesh's normals.
    std::uint32_t normal(std::uint64_t v) const { return vertex_normal.empty() ? original(v) : vertex_normal[v]; }
};

/// The way back: vertices with the same bits of position become the first of them. Where their normals differ, normals
/// are by corner from then on.
/// @param mesh  with one normal a vertex, or none. O(V log V)
void join_split_vertices(TriangleMesh& mesh);

}  // namespace tetrakis::detail
