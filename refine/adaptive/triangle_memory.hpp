#pragma once

#include "../../hier/base/error.hpp"
#include "../../hier/base/memory.hpp"

#include <cstdint>
#include <string>

namespace tetrakis::detail {

/// @param triangles  of the mesh that is being made, at least
/// @param bytes      what these take
/// @param limit      0: none
/// @throws Error     memory_limit: they take more than the limit
inline void check_triangle_memory(std::uint64_t triangles, std::uint64_t bytes, std::uint64_t limit) {
    check_memory("more than " + std::to_string(triangles) + " triangles are wanted, which need", bytes, limit,
                 "use a larger tolerance, or allow more");
}

/// @throws Error  unsupported: the levels that all leaves are to get take more triangles than this
[[noreturn]] inline void refuse_least_level(std::uint64_t triangles) {
    throw Error(ErrorCode::unsupported, "the minimum level takes more than the " + std::to_string(triangles) +
                                            " triangles allowed; allow more, or lower the minimum level");
}

}  // namespace tetrakis::detail
