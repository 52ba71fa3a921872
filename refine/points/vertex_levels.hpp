#pragma once

#include "../../hier/trees/vertex_roots.hpp"
#include "level_source.hpp"
#include "partial_levels.hpp"

#include <memory>

namespace tetrakis {

/// A cell written as a site, for hierarchies: the root's number in place of a half-edge's, and the lower corner.
inline Site cell_site(const VertexCell& cell) { return {HalfedgeId(cell.root), cell.at, cell.level}; }
inline VertexCell site_cell(const Site& site) { return {site.root.value, site.at, site.level}; }

/// A dual scheme's points over the cells of vertex quadtrees, written as sites. A vertex is one of one level only:
/// positions() and frames() throw Error(unsupported) for any other.
std::unique_ptr<LevelSource> vertex_levels(std::shared_ptr<const PartialLevels> levels);

}  // namespace tetrakis
