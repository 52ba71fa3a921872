#pragma once

#include "../../hier/base/vec.hpp"
#include "../../hier/forest/site.hpp"
#include "../rules/limit_point.hpp"

#include <span>

namespace tetrakis {

/// The points of a scheme's surface over the sites of its family, at any level and in the limit: what a hierarchy asks
/// of its scheme. A result depends on the mesh, the scheme with its options, the site and the level alone: any batch,
/// order and number of threads gives the same bytes. All calls are const and safe from several threads.
///
/// Levels are steps of the scheme, as in refine(): level 0 is the control mesh.
class LevelSource {
  public:
    virtual ~LevelSource() = default;
    /// The first level that has the site as a vertex. @param site  valid, see HierarchyFamily::check_site()
    virtual int first_level(const Site& site) const = 0;
    /// The deepest level that positions() answers for.
    virtual int max_level() const = 0;
    /// Control positions of the sites at a level, as uniform refinement has them there.
    /// @param level  first_level(site) <= level <= max_level() for all of them
    virtual void positions(std::span<const Site> sites, int level, std::span<Vec3d> out) const = 0;
    /// The mesh of one level around its vertices: position, the mean normal of the faces around (by area) and two
    /// directions that span the plane across it. `has_tangent_plane` is false where the normals cancel out.
    virtual void frames(std::span<const Site> sites, int level, std::span<LimitPoint> out) const = 0;
    virtual void limit_positions(std::span<const Site> sites, std::span<Vec3d> out) const = 0;
    /// Limit positions, tangents and normals. @throws Error  unsupported: the scheme has no limit mask for a vertex
    virtual void limits(std::span<const Site> sites, std::span<LimitPoint> out) const = 0;
    /// The unit normals of limits().
    virtual void normals(std::span<const Site> sites, std::span<Vec3d> out) const = 0;
};

}  // namespace tetrakis
