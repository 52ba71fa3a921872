#pragma once

#include "mesh_view.hpp"

#include <cmath>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

namespace tetrakis::detail {

inline bool fits_float(double x) { return std::abs(x) <= double{std::numeric_limits<float>::max()}; }

/// Vertices for formats with one normal, and perhaps one UV, per vertex. A vertex keeps the normal and UV of its first
/// corner; each further pair makes a copy. Copies come after all vertices, in the order of the corners.
class SplitVertices {
  public:
    static constexpr std::uint32_t k_no_uv = 0xFFFF'FFFFu;
    /// Indices into the mesh's positions, normals and UVs (k_no_uv: without UVs, or of no face).
    struct Vertex {
        std::uint32_t position, normal, uv = k_no_uv;
    };

    /// Keeps references to the mesh's arrays.
    /// @param uvs  whether different UVs split vertices, too
    /// @throws Error unsupported: more than 2^32 - 2 vertices
    SplitVertices(const MeshView& mesh, bool uvs);

    const std::vector<Vertex>& vertices() const { return vertices_; }
    std::span<const std::uint32_t> corners() const { return own_corners_.empty() ? mesh_corners_ : own_corners_; }

  private:
    std::vector<Vertex> vertices_;
    std::span<const std::uint32_t> mesh_corners_;
    std::vector<std::uint32_t> own_corners_;  ///< empty: as in the mesh
};

/// Undoes SplitVertices: vertices at the same position are replaced by the first of them. If their normals differ, the
/// mesh's normals are by corner afterwards.
/// @param mesh  has one normal a vertex, or none. O(V log V)
void join_split_vertices(TriangleMesh& mesh);

}  // namespace tetrakis::detail
