#pragma once

#include "../../eval/terrain/height_source.hpp"
#include "run_options.hpp"

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

namespace tetrakis::cli {

/// A height grid on the command line, and how its file is read.
struct HeightInput {
    std::filesystem::path path;
    HeightReadOptions read;
    double spacing = 0;  ///< 0: the file's own

    /// @param what  the help text of the file
    /// @returns     the file's option
    Option add(CommandLine command, const std::string& what = {});
    /// @param warnings  receives what was filled
    /// @throws InputError, Error (memory_limit, cancelled)
    HeightGrid load(const Run& process, std::vector<std::string>& warnings) const;
    /// @throws InputError, Error (memory_limit, cancelled)
    std::unique_ptr<HeightSource> open(const Run& process) const;

  private:
    HeightReadOptions options(const Run& process) const;
};

}  // namespace tetrakis::cli
