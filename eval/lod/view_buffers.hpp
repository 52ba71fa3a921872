#pragma once

#include "../../hier/base/vec.hpp"
#include "view.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

namespace tetrakis::detail {

/// Slots of a buffer that have changed.
class DirtySlots {
  public:
    void resize(std::size_t slots) {
        words_.assign((slots + 63) / 64, 0);
        first_ = words_.size();
        last_ = 0;
    }
    void mark(std::uint32_t slot) {
        const std::size_t word = slot / 64;
        words_[word] |= std::uint64_t{1} << (slot % 64);
        first_ = std::min(first_, word);
        last_ = std::max(last_, word + 1);
    }
    template <class Visit>
    void for_each(const Visit& visit) const {
        for (std::size_t w = first_; w < last_; ++w)
            for (std::uint64_t word = words_[w]; word != 0; word &= word - 1)
                visit(static_cast<std::uint32_t>(w * 64) + static_cast<std::uint32_t>(std::countr_zero(word)));
    }
    /// Those below `slots` in at most so many ranges, between which the gaps are the largest; none is dirty afterwards.
    void take_ranges(std::uint32_t slots, std::uint32_t most, std::vector<lod::Update::Range>& ranges) {
        std::uint32_t gap = 3;  // of a few slots, which cost less than another range
        const auto append = [&](const lod::Update::Range& range) {
            if (!ranges.empty() && range.first <= ranges.back().first + ranges.back().count + gap)
                ranges.back().count = range.first + range.count - ranges.back().first;
            else
                ranges.push_back(range);
        };
        ranges.clear();
        for_each([&](std::uint32_t slot) {
            if (slot < slots) append({slot, 1});
        });
        std::fill(words_.begin() + static_cast<std::ptrdiff_t>(std::min(first_, last_)),
                  words_.begin() + static_cast<std::ptrdiff_t>(last_), 0);
        first_ = words_.size();
        last_ = 0;
        while (ranges.size() > most) {
            gap += gap / 8 + 1;
            for (const lod::Update::Range& range : std::exchange(ranges, {})) append(range);
        }
    }
    std::uint64_t memory_bytes() const { return words_.capacity() * sizeof(std::uint64_t); }

  private:
    std::vector<std::uint64_t> words_;
    std::size_t first_ = 0, last_ = 0;  // words that may hold marks
};

/// A unit vector as two numbers (Meyer et al. 2010): 32767 is 1. A vector of length 0 is packed as (0, 0, 1).
inline std::array<std::int16_t, 2> octahedral(const Vec3d& n) {
    const double sum = std::max(std::abs(n.x) + std::abs(n.y) + std::abs(n.z), std::numeric_limits<double>::min());
    double x = n.x / sum, y = n.y / sum;
    if (n.z < 0) {
        const double folded = (1 - std::abs(y)) * (x < 0 ? -1 : 1);
        y = (1 - std::abs(x)) * (y < 0 ? -1 : 1);
        x = folded;
    }
    return {static_cast<std::int16_t>(std::lround(32767 * x)), static_cast<std::int16_t>(std::lround(32767 * y))};
}

inline Vec3d from_octahedral(const std::array<std::int16_t, 2>& packed) {
    Vec3d n(packed[0] / 32767.0, packed[1] / 32767.0, 0);
    n.z = 1 - std::abs(n.x) - std::abs(n.y);
    if (n.z < 0) n = {(1 - std::abs(n.y)) * (n.x < 0 ? -1 : 1), (1 - std::abs(n.x)) * (n.y < 0 ? -1 : 1), n.z};
    return glm::normalize(n);
}

inline std::array<float, 3> packed(const Vec3d& v) {
    return {static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)};
}
inline Vec3d unpacked(const std::array<float, 3>& v) { return {v[0], v[1], v[2]}; }

}  // namespace tetrakis::detail
