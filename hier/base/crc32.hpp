#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace tetrakis::detail {

/// CRC-32 of IEEE 802.3, reflected: that of ISO 3309, as PNG and zlib have it.
inline std::uint32_t crc32(std::span<const std::byte> bytes) {
    static constexpr std::array<std::uint32_t, 256> k_table = [] {
        std::array<std::uint32_t, 256> table{};
        for (std::uint32_t i = 0; i < 256; ++i) {
            table[i] = i;
            for (int bit = 0; bit < 8; ++bit) table[i] = table[i] >> 1 ^ ((table[i] & 1) != 0 ? 0xEDB8'8320u : 0);
        }
        return table;
    }();
    std::uint32_t remainder = 0xFFFF'FFFFu;
    for (const std::byte b : bytes)
        remainder = k_table[(remainder ^ static_cast<std::uint32_t>(b)) & 0xFF] ^ remainder >> 8;
    return ~remainder;
}

}  // namespace tetrakis::detail
