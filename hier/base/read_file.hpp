#pragma once

#include "run_context.hpp"

#include <filesystem>
#include <string>

namespace tetrakis::detail {

/// The bytes of a file, a pipe or a device; progress goes from 0 to 0.3 of the stage "load".
/// @throws Error io: no such file, a directory, not readable; memory_limit; cancelled
std::string read_file(const std::filesystem::path& path, const RunContext& context = {});

}  // namespace tetrakis::detail
