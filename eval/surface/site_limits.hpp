#pragma once

#include "../../hier/base/run_context.hpp"
#include "../../refine/adaptive/hierarchy.hpp"

#include <functional>
#include <span>

namespace tetrakis::detail {

/// Limit positions of canonical sites, with a report before each block of them, which may cancel.
void limit_positions(const Hierarchy& points, std::span<const Site> sites, std::span<Vec3d> out,
                     const std::function<void(double)>& report);

/// The same for sites in any order and with repetitions: each site is evaluated once. O(n log n), parallel.
void limit_positions_once(
    const Hierarchy& points, std::span<const Site> sites, std::span<Vec3d> out,
    const std::function<void(double)>& report = [](double) {});

}  // namespace tetrakis::detail
