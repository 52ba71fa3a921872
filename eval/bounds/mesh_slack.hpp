#pragma once

#include "../../hier/base/run_context.hpp"
#include "edge_slack.hpp"

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace tetrakis {

/// The folds of a conforming triangle mesh, and the room that its triangles leave at their edges (EdgeSlack).
class MeshSlack {
  public:
    /// Of an oriented mesh. Edges of more than two triangles have no slack. Keeps a reference to the triangles. O(T).
    MeshSlack(std::span<const std::array<std::uint32_t, 3>> triangles, std::span<const Vec3d> positions);

    /// What triangle t may slide over: its soft edges that bend by at most k_largest_fold.
    EdgeSlack of(std::uint32_t t, const std::array<bool, 3>& soft) const;

  private:
    static constexpr std::uint32_t k_none = 0xffffffffu;
    struct Facet {
        std::array<float, 3> normal{};   ///< unit length, or none
        std::array<float, 3> tangent{};  ///< a lower bound on that of half the angle at each corner
    };
    /// An upper bound on the angle between two triangles' planes, by its tangent; infinite above 60 degrees.
    static double fold(const Facet& a, const Facet& b);
    double tent(std::uint32_t t, std::size_t k, std::uint32_t twin) const;

    std::span<const std::array<std::uint32_t, 3>> triangles_;
    std::vector<std::uint32_t> twin_;  ///< by 3 t + k: 3 t' + k' across, or k_none
    std::vector<Facet> facets_;
};

}  // namespace tetrakis
