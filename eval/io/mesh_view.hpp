#pragma once

#include "../../hier/base/vec.hpp"
#include "../../refine/rules/polygon_mesh.hpp"
#include "../surface/triangle_mesh.hpp"

#include <cmath>
#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <vector>

namespace tetrakis::detail {

inline bool fits_float(double x) { return std::abs(x) <= double{std::numeric_limits<float>::max()}; }

/// What the writers see: triangle and polygon meshes alike, nothing copied.
struct MeshView {
    std::span<const Vec3d> positions, normals;
    std::span<const Vec2d> uvs;
    std::span<const std::uint32_t> corners, corner_uvs;  ///< one per face corner; corner_uvs may be empty
    std::span<const std::uint32_t> corner_normals;       ///< one per face corner; empty: normals are by vertex
    std::span<const std::uint32_t> face_offsets;         ///< empty: all faces are triangles
    std::span<const std::uint32_t> face_material, face_group;
    std::span<const std::string> materials, groups;

    explicit MeshView(const TriangleMesh& mesh);
    explicit MeshView(const PolygonMesh& mesh);

    std::uint64_t face_count() const {
        return face_offsets.empty() ? corners.size() / 3 : static_cast<std::uint64_t>(face_offsets.size() - 1);
    }
    std::uint64_t face_begin(std::uint64_t f) const { return face_offsets.empty() ? 3 * f : face_offsets[f]; }
    std::uint64_t face_end(std::uint64_t f) const { return face_begin(f + 1); }
    bool has_uvs() const { return !corner_uvs.empty(); }
    bool has_normals() const { return !normals.empty(); }
    /// The number of a face corner's normal.
    std::uint32_t normal(std::uint64_t corner) const {
        return corner_normals.empty() ? corners[corner] : corner_normals[corner];
    }

    /// @throws Error invalid_input: arrays that do not belong together, an index out of range, a number that is not
    ///         finite, a face with fewer than three corners
    void check() const;
};

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
