#pragma once

#include "../../hier/base/run_context.hpp"
#include "../../refine/adaptive/hierarchy.hpp"

#include <functional>
#include <span>

namespace tetrakis::detail {

/// Limit positions of canonical sites, with a report before every block of them, for the chance to cancel.
void limit_positions(const Hierarchy& points, std::span<const Site> sites, std::span<Vec3d> out,
                     const std::function<void(double)>& report);

/// The same of sites in any order, many of them several times: each is evaluated once. O(n log n), parallel.
void limit_positions_once(
    const Hierarchy& points, std::span<const Site> sites, std::span<Vec3d> out,
    const std::function<void(double)>& report = [](double) {});

}  // namespace tetrakis::detail
