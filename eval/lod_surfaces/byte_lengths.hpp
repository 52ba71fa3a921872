#pragma once

#include "surface.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>

namespace tetrakis::detail {

/// Lengths as single bytes, rounded up: 0, then six steps to a doubling. The last code is infinite: it stands for all
/// lengths above these.
class ByteLengths {
  public:
    static constexpr int k_a_doubling = 6;
    /// Steps that make a length lod::k_error_ratio times as large, or more.
    static constexpr int k_nesting = 2;
    static_assert(lod::k_error_ratio * lod::k_error_ratio * lod::k_error_ratio <= 2);

    ByteLengths() = default;
    /// @param largest  that is to be told from others before it is nested
    /// @param levels   how often it then grows by k_nesting steps, at most
    ByteLengths(double largest, int levels) {
        const int top = 254 - k_nesting * (levels + 1);  // what was rounded up is a step more
        for (int i = 1; i < 255; ++i) length_[i] = largest * std::exp2(double(i - top) / k_a_doubling);
        length_[255] = std::numeric_limits<double>::infinity();
    }

    double length(std::uint8_t code) const { return length_[code]; }
    std::uint8_t code(double length) const {
        if (length <= 0) return 0;
        if (!(length <= length_[254])) return 255;  // no number, too
        const double steps = 254 + k_a_doubling * std::log2(length / length_[254]);
        int code = static_cast<int>(std::clamp(std::ceil(steps), 1.0, 255.0));
        if (code < 255 && length_[code] < length) ++code;  // rounding
        return static_cast<std::uint8_t>(code);
    }

  private:
    std::array<double, 256> length_{};
};

}  // namespace tetrakis::detail
