#pragma once

#include "../forest/site.hpp"
#include "../mesh/control_mesh.hpp"

#include <cstdint>
#include <optional>
#include <vector>

namespace tetrakis {

/// A point of a triangle root's lattice, continued beyond the sides of the root (coordinates may be negative).
///
/// Side s of a root runs from corner s to corner s + 1 (mod 3), along the half-edge `root + s`: side 0 is y = 0, side 1
/// is x + y = 2^level, side 2 is x = 0.
struct TrianglePoint {
    HalfedgeId root;
    std::int64_t x = 0, y = 0;
    friend constexpr auto operator<=>(const TrianglePoint&, const TrianglePoint&) = default;
};

/// The same point seen from the root across `side`: the frame of the next root continues the lattice across the shared
/// edge, so the map is affine, and going there and back is the identity. Empty where the side is a boundary.
/// @param mesh   a mesh whose faces are triangles
/// @param point  at the given lattice level, anywhere in the plane of the frame
std::optional<TrianglePoint> cross_triangle_side(const ControlMesh& mesh, int side, int level,
                                                 const TrianglePoint& point);

/// Canonical sites of a triangle mesh: of all addresses of a point the one of minimal level, and then of smallest root.
/// Hole faces count as roots: the surface is defined over them too. Keeps a reference to the mesh.
class TriangleSites {
  public:
    /// O(H): finds the smallest root around each vertex once.
    explicit TriangleSites(const ControlMesh& mesh);
    explicit TriangleSites(const ControlMesh&&) = delete;

    /// @param site  any address, with x + y <= 2^level. O(1).
    Site canonical(const Site& site) const;
    /// The canonical site of a control vertex; the root is invalid for an isolated one.
    Site vertex(VertexId v) const;

  private:
    const ControlMesh* mesh_;
    std::vector<std::uint32_t> first_corner_;  // per vertex: smallest outgoing half-edge
};

/// As TriangleSites::canonical(), for single questions: costs a walk around the vertex where the point is one.
Site canonical_triangle_site(const ControlMesh& mesh, const Site& site);

}  // namespace tetrakis
