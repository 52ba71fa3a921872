#pragma once

#include "../../eval/render/render.hpp"

#include <CLI/CLI.hpp>

#include <string>

namespace tetrakis::cli {

/// --size, --camera and --up, of every command that draws.
void add_view_options(CLI::App& command, RenderOptions& render);

/// The first of these options that the command line of `command` has; empty where it has none.
std::string given_view_option(const CLI::App& command);

}  // namespace tetrakis::cli
