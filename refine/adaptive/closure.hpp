#pragma once

#include "../../hier/mesh/control_mesh.hpp"
#include "../../schemes/core/scheme_kind.hpp"
#include "../rules/vertex_ring.hpp"
#include "adaptive.hpp"

#include <memory>
#include <span>

namespace tetrakis {

/// Evaluates any set of sites by subdivision itself: a vertex of one level needs its stencil's vertices one level up,
/// and so on to the control mesh; they are collected downwards and evaluated upwards, in blocks of sites side by side.
///
/// A result depends on the mesh, the scheme and the site alone: every vertex is computed in a frame of its own, so all
/// addresses of a point give the same bits, in any batch and on any number of threads. Holes do not matter: their faces
/// take part in the rules like all others, and their sites have positions too.
///
/// Keeps a reference to the mesh. All calls are const and safe from several threads.
/// Cost: 1 to 2 microseconds a site and level where sites lie far apart, about 0.5 a site where all of a level is asked
/// for and ancestors are shared.
class Closure : public PositionSource {
  public:
    /// @param mesh   control mesh; Loop: triangles only
    /// @throws Error invalid_input: Loop on other faces than triangles; unsupported: corner angles
    Closure(const ControlMesh& mesh, SchemeKind scheme);
    Closure(const ControlMesh&&, SchemeKind) = delete;
    ~Closure() override;
    Closure(Closure&&) noexcept;
    Closure& operator=(Closure&&) noexcept;

    /// Limit positions of the sites.
    /// @param sites  any addresses, not only canonical ones
    void positions(std::span<const Site> sites, std::span<Vec3d> positions) const override;

    /// Limit positions, tangents and normals of the sites.
    void limits(std::span<const Site> sites, std::span<LimitPoint> out) const;
    LimitPoint limit(const Site& site) const;

    /// Control positions of the sites at a lattice level (Catmull-Clark: scheme level + 1), as uniform refinement has
    /// them there.
    /// @param level  >= the level of each site's point in lowest terms, <= k_max_level
    void control_positions(std::span<const Site> sites, int level, std::span<Vec3d> out) const;

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

}  // namespace tetrakis
