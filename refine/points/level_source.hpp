#pragma once

#include "../../hier/base/vec.hpp"
#include "../../hier/forest/site.hpp"
#include "../rules/limit_point.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace tetrakis {

/// Points of a scheme's surface at the sites of its family, on any level and in the limit; hierarchies evaluate their
/// schemes by this interface. A result depends on the mesh, the scheme with its options, the site and the level alone:
/// any batch, order and number of threads gives the same bytes. All calls are const and safe from several threads.
///
/// Levels are steps of the scheme, as in refine(): level 0 is the control mesh.
class LevelSource {
  public:
    virtual ~LevelSource() = default;
    /// The first level that has the site as a vertex. @param site  valid, see HierarchyFamily::check_site()
    virtual int first_level(const Site& site) const = 0;
    /// The deepest level that positions() can evaluate.
    virtual int max_level() const = 0;
    /// Control positions of the sites on a level, equal to those of uniform refinement.
    /// @param level  first_level(site) <= level <= max_level() for all sites
    virtual void positions(std::span<const Site> sites, int level, std::span<Vec3d> out) const = 0;
    /// Frames of a level's mesh at the sites: position, area-weighted mean normal of the surrounding faces, and two
    /// directions orthogonal to it. `has_tangent_plane` is false where the normals cancel out.
    virtual void frames(std::span<const Site> sites, int level, std::span<LimitPoint> out) const = 0;
    virtual void limit_positions(std::span<const Site> sites, std::span<Vec3d> out) const = 0;
    /// Limit positions, tangents and normals. @throws Error  unsupported: the scheme has no limit mask for a vertex
    virtual void limits(std::span<const Site> sites, std::span<LimitPoint> out) const = 0;
    /// The unit normals of limits().
    virtual void normals(std::span<const Site> sites, std::span<Vec3d> out) const = 0;
};

/// Control points of quad or dual schemes, each on the level that its site names: site level l is scheme level l + 1.
inline void written_positions(const LevelSource& source, std::span<const Site> sites, std::span<Vec3d> out) {
    std::array<std::vector<std::uint32_t>, k_max_level + 1> by_level;
    for (std::uint32_t i = 0; i < sites.size(); ++i) by_level[sites[i].level].push_back(i);
    for (std::size_t level = 0; level < by_level.size(); ++level) {
        std::vector<Site> some;
        for (const std::uint32_t i : by_level[level]) some.push_back(sites[i]);
        std::vector<Vec3d> found(some.size());
        if (!some.empty()) source.positions(some, static_cast<int>(level) + 1, found);
        for (std::size_t k = 0; k < some.size(); ++k) out[by_level[level][k]] = found[k];
    }
}

}  // namespace tetrakis
