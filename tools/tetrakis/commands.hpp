#pragma once

#include <CLI/CLI.hpp>

#include <functional>
#include <stdexcept>

namespace tetrakis::cli {

/// What the program's exit code says. The numbers are documented in the README and do not change.
enum class ExitCode {
    done = 0,
    failure = 1,                ///< at run time: disk full, out of memory, ...
    usage = 2,                  ///< the command line makes no sense
    bad_input = 3,              ///< an input file is missing or wrong
    tolerance_not_reached = 4,  ///< the best result is written all the same
    cancelled = 130,            ///< 128 + SIGINT
};

/// The command line makes no sense, in a way that the option parser cannot see.
class UsageError : public std::runtime_error {
    using std::runtime_error::runtime_error;
};

/// An input file is missing, unreadable or wrong.
class InputError : public std::runtime_error {
    using std::runtime_error::runtime_error;
};

/// The command that the command line chose, ready to run.
using Command = std::function<ExitCode()>;

/// Each adds one subcommand to the program; parsing it sets `chosen`.
void add_info_command(CLI::App& app, Command& chosen);
void add_tessellate_command(CLI::App& app, Command& chosen);
void add_terrain_command(CLI::App& app, Command& chosen);
void add_tiles_command(CLI::App& app, Command& chosen);
void add_lod_command(CLI::App& app, Command& chosen);
void add_refine_command(CLI::App& app, Command& chosen);
void add_compare_command(CLI::App& app, Command& chosen);
void add_render_command(CLI::App& app, Command& chosen);
void add_scheme_command(CLI::App& app, Command& chosen);
void add_schemes_command(CLI::App& app, Command& chosen);

}  // namespace tetrakis::cli
