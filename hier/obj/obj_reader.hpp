#pragma once

#include "../base/run_context.hpp"
#include "../mesh/control_mesh.hpp"

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

namespace tetrakis {

struct ReadOptions {
    /// Join vertices within this distance by weld() (mesh_repair.hpp), before any repair; 0: only at equal positions.
    /// The results become warnings.
    std::optional<double> weld{};
    bool repair = false;  ///< do what repair() can (mesh_repair.hpp); each repair becomes a warning
};

/// Reads a Wavefront OBJ file: polygons of any size, texture coordinates and normals by index, groups and materials,
/// and OpenSubdiv's tag lines (`t crease`, `t corner`, `t hole`, `t interpolateboundary`, ...; see obj_text.hpp).
/// Positions are correctly rounded; names are returned in UTF-8. Without `repair` the data may have faults, which
/// ControlMesh::build reports with their lines.
/// @param context  progress ("load"), cancelling, and a memory limit for the file's size
/// @throws Error  io (missing, a directory, unreadable), invalid_input (a malformed line: file, line and advice),
///                cancelled, memory_limit
ControlMeshData read_obj(const std::filesystem::path& path, const ReadOptions& options = {},
                         const RunContext& context = {});

/// The same from memory. @param source  name for messages. @param context  progress ("load") and cancelling
ControlMeshData parse_obj(std::string_view text, std::string source, const ReadOptions& options = {},
                          const RunContext& context = {});

/// Calls read_obj() and ControlMesh::build().
ControlMesh load_control_mesh(const std::filesystem::path& path, const ReadOptions& options = {},
                              const RunContext& context = {});

}  // namespace tetrakis
