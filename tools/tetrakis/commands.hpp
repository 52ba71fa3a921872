#pragma once

#include "exit_code.hpp"

#include <CLI/CLI.hpp>

#include <functional>

namespace tetrakis::cli {

/// The command that the command line chose, ready to run.
using Command = std::function<ExitCode()>;

/// Each adds one subcommand to the program; parsing it sets `chosen`.
void add_info_command(CLI::App& app, Command& chosen);
void add_tessellate_command(CLI::App& app, Command& chosen);
void add_refine_command(CLI::App& app, Command& chosen);
void add_compare_command(CLI::App& app, Command& chosen);
void add_render_command(CLI::App& app, Command& chosen);
void add_scheme_command(CLI::App& app, Command& chosen);
void add_schemes_command(CLI::App& app, Command& chosen);

}  // namespace tetrakis::cli
