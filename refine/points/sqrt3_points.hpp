#pragma once

#include "../../hier/base/vec.hpp"
#include "../../hier/forest/site.hpp"
#include "../../hier/trees/sqrt3_lattice.hpp"
#include "../rules/limit_point.hpp"
#include "level_source.hpp"
#include "sqrt3_rules.hpp"

#include <cstddef>
#include <memory>
#include <unordered_map>
#include <utility>
#include <vector>

namespace tetrakis {

/// Points of the sqrt(3) scheme at vertices of any levels, each from the ring of the level before it, and so on up to
/// the control mesh. Keeps what it has found, up to a bound: cheap side by side, not to be shared by threads.
///
/// A vertex is named by a half-edge that leaves it at the level. A result depends on the vertex and the level alone.
class Sqrt3Points {
  public:
    /// @param mesh  as Sqrt3Forest takes it. Keeps a reference.
    explicit Sqrt3Points(const ControlMesh& mesh) : Sqrt3Points(Sqrt3Lattice(mesh)) {}
    explicit Sqrt3Points(const ControlMesh&&) = delete;
    explicit Sqrt3Points(Sqrt3Lattice lattice) : mesh_(&lattice.mesh()), lattice_(std::move(lattice)) {}

    Sqrt3Lattice& lattice() { return lattice_; }
    /// The position in the net of a level.
    Vec3d position(int level, std::uint64_t leaving);
    /// Limit position and normal; tangents where the scheme has masks for them (not at creases and corners: there the
    /// normal is the mean of those of the faces around).
    LimitPoint limit(int level, std::uint64_t leaving);
    /// The vertex and those around it in the net of a level.
    detail::Sqrt3Ring ring(int level, std::uint64_t leaving);

  private:
    /// What surrounds a vertex, counter-clockwise from a start that all its half-edges agree on.
    struct Fan {
        std::vector<std::uint64_t> leaving;  ///< the half-edges that leave it
        std::vector<std::uint64_t> around;   ///< half-edges that leave the vertices around, as the rules see them
        bool closed = true;
        std::vector<std::pair<std::size_t, float>> sharp;  ///< as Sqrt3Ring has them
    };
    Fan fan(int level, std::uint64_t leaving);
    /// Beyond the edge of a half-edge's face that the next step cuts, where it is a kept edge that is smooth, as a
    /// half-edge that leaves the opposite corner; else none.
    std::uint64_t opposite_of_kept(int level, std::uint64_t h);
    detail::Sqrt3Ring ring(int level, std::uint64_t leaving, const Fan& at);
    /// The same, where around a crease the vertices along it are enough, around others none.
    detail::Sqrt3Ring sharp_ring(int level, std::uint64_t leaving, const Fan& at);
    bool beside_cut(int level, std::uint64_t leaving);
    bool beside_dart(int level, const Fan& at);
    Vec3d compute(int level, std::uint64_t leaving, const Sqrt3Vertex& v);

    const ControlMesh* mesh_;
    Sqrt3Lattice lattice_;
    detail::Sqrt3Rules rules_;
    std::vector<std::unordered_map<Sqrt3Vertex, Vec3d>> known_;  // per level
};

/// A vertex of sqrt(3) refinement written as a site, for hierarchies: its kind in place of a root, its key in two
/// halves, its first level.
inline Site sqrt3_site(const Sqrt3Vertex& v) {
    return {HalfedgeId(static_cast<std::uint32_t>(v.kind)),
            {static_cast<std::uint32_t>(v.key), static_cast<std::uint32_t>(v.key >> 32)},
            v.birth};
}
inline Sqrt3Vertex site_sqrt3(const Site& site) {
    return {std::uint64_t{site.at.y} << 32 | site.at.x, site.level, static_cast<Sqrt3Vertex::Kind>(site.root.value)};
}

/// The sqrt(3) scheme's points over such sites. Levels are simple steps, two of which are one level of refine(). Keeps
/// a reference to the mesh, which is one as Sqrt3Forest takes it.
/// @param max_level  that positions() answers for
std::unique_ptr<LevelSource> sqrt3_levels(const ControlMesh& mesh, int max_level);

}  // namespace tetrakis
