#pragma once

#include "command_line.hpp"

namespace tetrakis::cli {

/// Each function adds one command to the program.
void add_info_command(CommandLine program);
void add_tessellate_command(CommandLine program);
void add_terrain_command(CommandLine program);
void add_tiles_command(CommandLine program);
void add_lod_command(CommandLine program);
void add_refine_command(CommandLine program);
void add_compare_command(CommandLine program);
void add_render_command(CommandLine program);
void add_scheme_command(CommandLine program);
void add_schemes_command(CommandLine program);

}  // namespace tetrakis::cli
