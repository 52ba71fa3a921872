#pragma once

#include <cstdint>

namespace tetrakis::detail {

/// Puts a zero before each bit of a number below 2^32.
constexpr std::uint64_t spread_bits(std::uint64_t x) {
    x = (x | x << 16) & 0x0000'FFFF'0000'FFFFull;
    x = (x | x << 8) & 0x00FF'00FF'00FF'00FFull;
    x = (x | x << 4) & 0x0F0F'0F0F'0F0F'0F0Full;
    x = (x | x << 2) & 0x3333'3333'3333'3333ull;
    return (x | x << 1) & 0x5555'5555'5555'5555ull;
}

}  // namespace tetrakis::detail
