#pragma once

#include "tetrakis/eval/render.hpp"

#include <CLI/CLI.hpp>

namespace tetrakis::cli {

/// --size, --camera and --up, of every command that draws.
void add_view_options(CLI::App& command, RenderOptions& render);

}  // namespace tetrakis::cli
