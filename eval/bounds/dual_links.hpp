#pragma once

#include "dual_net.hpp"

#include <compare>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace tetrakis::detail {

/// Which pieces of faces (DualFacePieces) share a side.
class DualLinks {
  public:
    struct Side {
        std::uint32_t face, piece, side;
        auto operator<=>(const Side&) const = default;
    };

    /// @param plane  per face whether its pieces are triangles
    DualLinks(const DualNet& net, std::span<const std::uint8_t> plane);

    /// The side beyond: nothing where the mesh ends, or where it is not the only one (between the two ends of a crease
    /// there is something else).
    std::optional<Side> across(const Side& side) const;

  private:
    struct Entry {
        std::uint32_t low, high;
        Side side;
        auto operator<=>(const Entry&) const = default;
    };
    Entry entry(const Side& side) const;

    const DualNet& net_;
    std::span<const std::uint8_t> plane_;
    std::vector<Entry> entries_;  // sorted
};

}  // namespace tetrakis::detail
