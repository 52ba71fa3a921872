#pragma once

#include "../../hier/forest/sqrt3_levels.hpp"

#include <cstdint>
#include <span>
#include <vector>

namespace tetrakis::detail {

/// A leaf as Sqrt3Levels::for_each_leaf() names it.
struct Sqrt3LevelLeaf {
    std::uint32_t face;
    std::uint8_t level;
    bool half;
};

/// Parts of an adaptive sqrt(3) mesh's leaves: what has to be split for them alone.
class Sqrt3Parts {
  public:
    /// Keeps a reference.
    explicit Sqrt3Parts(const Sqrt3Levels& levels);

    std::span<const Sqrt3LevelLeaf> leaves() const { return leaves_; }
    /// The split faces of a forest that has these leaves, and as few others as it can: per level, as Sqrt3Levels takes
    /// them. O(faces around the leaves, of all levels).
    Sqrt3Split split_for(std::span<const Sqrt3LevelLeaf> leaves);
    /// The face, or half-edge where the leaf is half, that a leaf is in the levels of such a forest. O(log faces).
    std::uint32_t find(const Sqrt3LevelLeaf& leaf, const Sqrt3Levels& part) const;

    std::uint64_t memory_bytes() const;

  private:
    void want(std::size_t level, std::uint32_t face);
    void want_above(std::size_t level, std::uint32_t face);

    const Sqrt3Levels& levels_;
    std::vector<Sqrt3LevelLeaf> leaves_;
    std::vector<std::vector<std::uint32_t>> above_;     // per level: the split faces of the level before
    std::vector<std::vector<std::uint8_t>> is_wanted_;  // per level and face
    std::vector<std::vector<std::uint32_t>> wanted_;    // per level
};

}  // namespace tetrakis::detail
