#pragma once

#include "../../hier/base/run_context.hpp"
#include "../../refine/adaptive/hierarchy.hpp"

#include <span>
#include <vector>

namespace tetrakis::detail {

/// Sites in any order, many of them several times, and the distinct ones among them.
class DistinctSites {
  public:
    /// @param sites  canonical. O(n log n), parallel
    explicit DistinctSites(std::span<const Site> sites);

    std::span<const Site> distinct() const { return distinct_; }  ///< in order
    /// Per site given: its number in distinct().
    std::span<const std::uint32_t> number() const { return number_; }

  private:
    std::vector<Site> distinct_;
    std::vector<std::uint32_t> number_;
};

/// Limit positions of canonical sites, with a report before every block of them, for the chance to cancel.
void limit_positions(const Hierarchy& points, std::span<const Site> sites, std::span<Vec3d> out,
                     const std::function<void(double)>& report);

/// The same of sites that come several times: each is evaluated once.
void limit_positions_once(
    const Hierarchy& points, std::span<const Site> sites, std::span<Vec3d> out,
    const std::function<void(double)>& report = [](double) {});

}  // namespace tetrakis::detail
