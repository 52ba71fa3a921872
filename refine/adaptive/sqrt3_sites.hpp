#pragma once

#include "../../hier/forest/site.hpp"
#include "../../hier/forest/sqrt3_lattice.hpp"
#include "level_source.hpp"

#include <memory>

namespace tetrakis {

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
