#pragma once

#include "tetrakis/hier/control_mesh.hpp"
#include "tetrakis/hier/run_context.hpp"
#include "tetrakis/schemes/scheme_kind.hpp"

#include <CLI/CLI.hpp>

namespace tetrakis::cli {

/// --scheme, one of the names that the library knows.
void add_scheme_option(CLI::App& command, SchemeKind& scheme);

/// Makes the mesh one that the scheme can refine: for Loop its faces are cut into triangles, with a warning.
void prepare_for(SchemeKind scheme, ControlMesh& mesh, const RunContext& context);

}  // namespace tetrakis::cli
