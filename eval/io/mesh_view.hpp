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

/// A view for the writers of a triangle or polygon mesh, without copies.
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
    /// Index of a face corner's normal.
    std::uint32_t normal(std::uint64_t corner) const {
        return corner_normals.empty() ? corners[corner] : corner_normals[corner];
    }

    /// @throws Error invalid_input: arrays whose sizes do not match, an index out of range, a number that is not
    ///         finite, a face with fewer than three corners
    void check() const;
};

/// Vertices for formats with one normal, and perhaps one UV, per vertex. A vertex keeps the normal and UV of its first
/// corner; each further pair makes a copy. Copies come after all vertices, in the order of the corners.
struct SplitVertices {
    std::vector<std::uint32_t> corner_vertex;  ///< per corner; empty: as in the mesh
    std::vector<std::uint32_t> copy_of;        ///< per copy: its vertex in the mesh
    std::vector<std::uint32_t> vertex_normal;  ///< normal per vertex and copy; empty: normals are by vertex
    std::vector<std::uint32_t> vertex_uv;      ///< UV per vertex and copy (isolated: k_no_uv); empty: no UVs
    std::uint64_t count = 0;                   ///< number of vertices and copies

    static constexpr std::uint32_t k_no_uv = 0xFFFF'FFFFu;

    /// @param uvs  whether different UVs split vertices, too
    /// @throws Error unsupported: more than 2^32 - 2 vertices
    SplitVertices(const MeshView& mesh, bool uvs);

    /// The mesh's vertex for a vertex or copy.
    std::uint32_t original(std::uint64_t v) const {
        return copy_of.size() + v < count ? static_cast<std::uint32_t>(v) : copy_of[v - (count - copy_of.size())];
    }
    /// Index of its normal in the mesh's normals.
    std::uint32_t normal(std::uint64_t v) const { return vertex_normal.empty() ? original(v) : vertex_normal[v]; }
};

/// Undoes SplitVertices: vertices with the same position bits are replaced by the first of them. If their normals
/// differ, the mesh's normals are by corner afterwards.
/// @param mesh  has one normal a vertex, or none. O(V log V)
void join_split_vertices(TriangleMesh& mesh);

}  // namespace tetrakis::detail
