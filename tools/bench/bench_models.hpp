#pragma once

#include "../../hier/mesh/control_mesh.hpp"
#include "../../hier/obj/obj_reader.hpp"
#include "../../schemes/core/scheme_table.hpp"

#include <cstdlib>
#include <filesystem>
#include <string_view>

namespace tetrakis::bench {

/// A model of the comparison with other tessellators, below the folder of shared test data.
struct BenchModel {
    std::string_view name;
    std::string_view path;
    SchemeKind scheme;
};

/// Models of the tables in the README.
inline constexpr BenchModel k_models[] = {
    {"spot-control", "data/models/spot-control.obj", SchemeKind::catmull_clark},
    {"rook", "data/osd-shapes/catmark_rook.obj", SchemeKind::catmull_clark},
    {"pawn", "data/osd-shapes/catmark_pawn.obj", SchemeKind::catmull_clark},
    {"helmet", "data/osd-shapes/catmark_helmet.obj", SchemeKind::catmull_clark},
    {"suzanne", "data/models/suzanne.obj", SchemeKind::catmull_clark},
    {"fandisk", "data/models/fandisk.obj", SchemeKind::loop},
    {"cow", "data/models/cow.obj", SchemeKind::loop},
};

/// The shared test data: $TETRAKIS_SHARED_DIR, or ../shared beside the project.
inline std::filesystem::path shared_folder() {
    const char* named = std::getenv("TETRAKIS_SHARED_DIR");
    return named != nullptr ? named : std::filesystem::path(TETRAKIS_SOURCE_DIR).parent_path() / "shared";
}

/// Reads and repairs a model, so that all methods get the same manifold mesh. @throws Error io, invalid_input
inline ControlMeshData load_bench_model(const BenchModel& model) {
    return read_obj(shared_folder() / model.path, {.repair = true});
}

}  // namespace tetrakis::bench
