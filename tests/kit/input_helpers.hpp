#pragma once

#include "../../hier/base/error.hpp"
#include "../../hier/mesh/control_mesh.hpp"
#include "../../hier/mesh/mesh_check.hpp"
#include "random_mesh.hpp"

#include <doctest/doctest.h>

#include <cstdint>
#include <random>
#include <string>
#include <vector>

namespace tetrakis::test {

inline std::vector<Vec3d> random_points(std::uint32_t count, std::mt19937_64& random) {
    std::uniform_real_distribution<double> coordinate(-1.0, 1.0);
    std::vector<Vec3d> points(count);
    for (Vec3d& p : points) p = {coordinate(random), coordinate(random), coordinate(random)};
    return points;
}

inline bool contains(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

/// The error that `call` throws; fails the test if it throws none.
template <class Call>
Error error_of(Call&& call) {
    try {
        call();
    } catch (const Error& error) {
        return error;
    }
    FAIL("no error was thrown");
    return Error(ErrorCode::unsupported, "");
}

inline RunContext with_thread_count(int threads) {
    RunContext context;
    context.threads = threads;
    return context;
}

}  // namespace tetrakis::test

// Parts of PNG files.
namespace tetrakis::test {

inline std::string big_endian(std::uint32_t number) {
    std::string bytes;
    for (int shift = 24; shift >= 0; shift -= 8) bytes += static_cast<char>(number >> shift & 0xFF);
    return bytes;
}

/// CRC-32 as PNG uses it, computed bit by bit.
inline std::uint32_t png_checksum(const std::string& bytes) {
    std::uint32_t remainder = ~0u;
    for (const char c : bytes)
        for (int bit = 0; bit < 8; ++bit) {
            const bool odd = ((remainder ^ static_cast<std::uint8_t>(c) >> bit) & 1) != 0;
            remainder = remainder >> 1 ^ (odd ? 0xEDB88320u : 0u);
        }
    return ~remainder;
}

/// @param text  the chunk's type (4 characters), then its data
inline std::string png_chunk(const std::string& text) {
    return big_endian(static_cast<std::uint32_t>(text.size() - 4)) + text + big_endian(png_checksum(text));
}

}  // namespace tetrakis::test
