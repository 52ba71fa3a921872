#pragma once

#include "../../hier/base/vec.hpp"
#include "../../refine/rules/polygon_mesh.hpp"
#include "../surface/triangle_mesh.hpp"

#include <cstdint>
#include <span>
#include <string>

namespace tetrakis {

struct ControlMeshData;

/// A view, without copies, of the triangle or polygon mesh that is written to a file.
struct MeshView {
    std::span<const Vec3d> positions, normals;
    std::span<const Vec2d> uvs;
    std::span<const std::uint32_t> corners, corner_uvs;  ///< one per face corner; corner_uvs may be empty
    std::span<const std::uint32_t> corner_normals;       ///< one per face corner; empty: normals are by vertex
    std::span<const std::uint32_t> face_offsets;         ///< empty: all faces are triangles
    std::span<const std::uint32_t> face_material, face_group;
    std::span<const std::string> materials, groups;

    MeshView(const TriangleMesh& mesh);
    MeshView(const PolygonMesh& mesh);
    explicit MeshView(const ControlMeshData& mesh);

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

  private:
    template <class Polygons>
    MeshView(const Polygons& mesh, std::span<const std::uint32_t> normal_numbers);
};

}  // namespace tetrakis
