#pragma once

#include <string_view>

/// For `#if`, where a program supports several versions: 10000 major + 100 minor + patch.
#define TETRAKIS_VERSION_NUMBER 100

namespace tetrakis {

/// The version of the headers, "major.minor.patch"; reports carry it. CMake reads it from this line.
inline constexpr std::string_view k_version = "0.1.0";

}  // namespace tetrakis
