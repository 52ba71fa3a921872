#pragma once

#include "tetrakis/hier/sqrt3_lattice.hpp"
#include "tetrakis/hier/vec.hpp"
#include "tetrakis/refine/sqrt3_rules.hpp"
#include "tetrakis/refine/vertex_ring.hpp"

#include <unordered_map>
#include <vector>

namespace tetrakis {

/// Points of the sqrt(3) scheme at vertices of any levels, each from the ring of the level before it, and so on up to
/// the control mesh. Keeps what it has found, up to a bound: cheap side by side, not to be shared by threads.
///
/// A vertex is named by a half-edge that leaves it at the level. A result depends on the vertex and the level alone.
class Sqrt3Points {
  public:
    /// @param mesh  as Sqrt3Forest takes it. Keeps a reference.
    explicit Sqrt3Points(const ControlMesh& mesh) : mesh_(&mesh), lattice_(mesh) {}

    Sqrt3Lattice& lattice() { return lattice_; }
    /// The position in the net of a level.
    Vec3d position(int level, std::uint64_t leaving);
    /// Limit position and normal; tangents where the scheme has masks for them (not on the boundary: there the normal
    /// is the mean of those of the faces around).
    LimitPoint limit(int level, std::uint64_t leaving);
    /// The vertex and those around it in the net of a level.
    detail::Sqrt3Ring ring(int level, std::uint64_t leaving);

  private:
    /// The half-edges that leave a vertex, counter-clockwise from a start that all of them agree on.
    struct Fan {
        std::vector<std::uint64_t> leaving;
        bool closed = true;
    };
    Fan fan(int level, std::uint64_t leaving);
    Vec3d compute(int level, std::uint64_t leaving, const Sqrt3Vertex& v);

    const ControlMesh* mesh_;
    Sqrt3Lattice lattice_;
    detail::Sqrt3Rules rules_;
    std::vector<std::unordered_map<Sqrt3Vertex, Vec3d>> known_;  // per level
};

}  // namespace tetrakis
