#pragma once

#include <bit>
#include <cstdint>

namespace tetrakis::detail {

/// A length in 12 bits: a float without its sign and its lowest 19 bits, rounded up by at most a sixteenth. Larger
/// codes are larger lengths.
struct RoundedLength {
    RoundedLength() = default;
    explicit RoundedLength(double length)
        : code(static_cast<std::uint16_t>(std::bit_cast<std::uint32_t>(static_cast<float>(length)) >> k_dropped)) {
        if (value() < length) ++code;
    }
    double value() const { return double{std::bit_cast<float>(std::uint32_t{code} << k_dropped)}; }

    std::uint16_t code = 0;

  private:
    static constexpr int k_dropped = 19;
};

}  // namespace tetrakis::detail
