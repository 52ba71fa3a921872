#pragma once

#include "tetrakis/hier/control_mesh.hpp"
#include "tetrakis/hier/sqrt3_lattice.hpp"
#include "tetrakis/refine/vertex_ring.hpp"
#include "tetrakis/schemes/ring_mask.hpp"

#include <array>
#include <span>
#include <vector>

namespace tetrakis::detail {

/// A vertex of a level of sqrt(3) refinement and those around it, counter-clockwise: from the one with the least
/// half-edge, or on the boundary from one end to the other.
struct Sqrt3Ring {
    Vec3d point{0};
    std::vector<Vec3d> around;
    bool closed = true;
    bool corner = false;  ///< of the boundary, and stays
};

/// The sqrt(3) scheme's rules on the rings of simple steps' levels; keeps its masks.
class Sqrt3Rules {
  public:
    static bool is_corner(const ControlMesh& mesh, const Sqrt3Vertex& v) {
        return v.kind == Sqrt3Vertex::Kind::control && mesh.sharpness(VertexId(static_cast<std::uint32_t>(v.key))) > 0;
    }
    static Vec3d centre(const std::array<Vec3d, 3>& corners);
    /// The point of a cut boundary edge beside `near`, which has `beyond` on its other side (a corner: nothing).
    static Vec3d beside(const Vec3d& near, const Vec3d& far, const Vec3d* beyond);
    /// The vertex at the next level.
    Vec3d moved(const Sqrt3Ring& ring, bool cuts_boundary);
    /// Tangents only inside; on the boundary the normal is the mean of those of the faces around. From the ring of a
    /// level before the first of two steps; inside, away from cut edges, of any.
    LimitPoint limit(const Sqrt3Ring& ring);
    /// Its position alone.
    Vec3d limit_position(const Sqrt3Ring& ring);

  private:
    struct Masks {
        RingMask vertex, limit;
        std::vector<double> cosine, sine;  ///< of the ring's directions
    };
    const Masks& masks(std::size_t valence);

    std::vector<Masks> masks_;  // per valence, empty until they are asked for
};

}  // namespace tetrakis::detail
