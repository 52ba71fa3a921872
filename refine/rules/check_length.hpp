#pragma once

#include "../../hier/base/error.hpp"

#include <cstddef>
#include <string>

namespace tetrakis::detail {

/// @throws Error invalid_input, with both numbers, where a caller's array has the wrong length
inline void check_length(const char* what, std::size_t length, std::size_t expected) {
    if (length != expected)
        throw Error(ErrorCode::invalid_input, "there are " + std::to_string(length) + " " + what + ", but " +
                                                  std::to_string(expected) + " are needed");
}

}  // namespace tetrakis::detail
