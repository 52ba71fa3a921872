#pragma once

#include "level_source.hpp"

#include <span>

namespace tetrakis {

/// Control points of quad or dual schemes, each at the level that its site is written at: lattice level l is scheme
/// level l + 1.
void written_positions(const LevelSource& source, std::span<const Site> sites, std::span<Vec3d> out);

}  // namespace tetrakis
