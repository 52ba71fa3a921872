#pragma once

#include "surface.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>

namespace tetrakis::detail {

/// Lengths as single bytes, rounded up: 0, then six steps to a doubling. The last code stands for all longer lengths
/// and is decoded as infinity.
class ByteLengths {
  public:
    static constexpr int k_a_doubling = 6;
    /// Steps that multiply a length by lod::k_error_ratio, or more.
    static constexpr int k_nesting = 2;
    static_assert(lod::k_error_ratio * lod::k_error_ratio * lod::k_error_ratio <= 2);

    ByteLengths() = default;
    /// @param largest  largest length before nesting that must not become infinite
    /// @param levels   how often nesting may then add k_nesting steps
    ByteLengths(double largest, int levels) {
        const int top = 254 - k_nesting * (levels + 1);  // one step more for rounding up
        for (int i = 1; i < 255; ++i) length_[i] = largest * std::exp2(double(i - top) / k_a_doubling);
        length_[255] = std::numeric_limits<double>::infinity();
    }

    double length(std::uint8_t code) const { return length_[code]; }
    std::uint8_t code(double length) const {
        if (length <= 0) return 0;
        if (!(length <= length_[254])) return 255;  // also for NaN
        const double steps = 254 + k_a_doubling * std::log2(length / length_[254]);
        int code = static_cast<int>(std::clamp(std::ceil(steps), 1.0, 255.0));
        if (code < 255 && length_[code] < length) ++code;  // rounding
        return static_cast<std::uint8_t>(code);
    }

  private:
    std::array<double, 256> length_{};
};

}  // namespace tetrakis::detail
