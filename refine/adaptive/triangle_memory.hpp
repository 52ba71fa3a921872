#pragma once

#include "../../hier/base/error.hpp"

#include <cstdint>
#include <string>

namespace tetrakis::detail {

/// @param triangles  of the mesh that is being made, at least
/// @param bytes      what these take
/// @param limit      0: none
/// @throws Error     memory_limit: they take more than the limit
inline void check_triangle_memory(std::uint64_t triangles, std::uint64_t bytes, std::uint64_t limit) {
    if (limit == 0 || bytes <= limit) return;
    throw Error(ErrorCode::memory_limit, "more than " + std::to_string(triangles) + " triangles are needed, about " +
                                             std::to_string(bytes >> 20) + " MiB, and the limit is " +
                                             std::to_string(limit >> 20) +
                                             " MiB; use a larger tolerance or a larger limit");
}

}  // namespace tetrakis::detail
