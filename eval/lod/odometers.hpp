#pragma once

#include "candidates.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace tetrakis::detail {

/// How far a camera has moved. Odometer 0 reads its travel; each other one has a length, and adds to the travel what
/// turns move at that distance from the eye.
class Odometers {
  public:
    static constexpr std::size_t k_travel = 0;

    /// @param extent  of what the camera looks at
    explicit Odometers(double extent) : extent_(extent > 0 ? extent : 1) {
        for (std::size_t i = 1; i < lengths_.size(); ++i)
            lengths_[i] = extent_ * std::exp2(static_cast<double>(i) / 2 + k_lowest);
        readings_.fill(k_start * extent_);
    }

    double reading(std::size_t odometer) const { return readings_[odometer]; }
    void move(double travel, double turn, Candidates& candidates) {
        // Beyond its end a reading has no digits left for short ways.
        if (!(readings_.back() + travel < k_end * extent_)) {
            readings_.fill(k_start * extent_);
            return candidates.restart(k_start * extent_);
        }
        for (std::size_t i = 0; i < readings_.size(); ++i) {
            readings_[i] += travel + lengths_[i] * turn;
            candidates.advance(i, readings_[i]);
        }
    }

    /// The odometer for what is at most so far away: the one with the next larger length.
    std::size_t at(double reach) const {
        constexpr int k_last = Candidates::k_odometers - 1;
        // By halves of doublings; what rounding may do is made up for by way().
        const int octave = 2 * (exponent_of(std::max(reach / extent_, 1e-300)) - k_lowest);
        if (octave >= k_last) return k_last;
        if (octave < 1) return 1;
        const auto i = static_cast<std::size_t>(octave);
        return i + (lengths_[i] < reach) + (i + 1 < k_last && lengths_[i + 1] < reach);
    }
    /// What that odometer may move before a point that is at most `reach` away can have moved by `gap`, as seen from
    /// the camera. A point moves by the travel, and by the turn times its distance, which travel adds to: by
    /// (w + w^2 / (4 m)) m / length at most where the odometer moves by w, with the larger of reach and length as m.
    double way(std::size_t odometer, double gap, double reach) const {
        const double length = lengths_[odometer], m = std::max(reach, length);
        return 2 * m * (std::sqrt(1 + gap * length / (m * m)) - 1);
    }

  private:
    static constexpr int k_lowest = -14;  // lengths are multiples of 2^k_lowest extents
    // In extents. From the start on, readings have equal exponents for long: candidates are sorted by the digits that
    // they differ in.
    static constexpr double k_start = 16, k_end = 1 << 24;

    double extent_;
    std::array<double, Candidates::k_odometers> lengths_{}, readings_{};
};

}  // namespace tetrakis::detail
