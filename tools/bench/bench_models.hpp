#pragma once

#include "../../hier/mesh/control_mesh.hpp"
#include "../../schemes/core/scheme_table.hpp"

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace tetrakis::bench {

/// A model of the comparison with other tessellators, below the folder of shared test data.
struct BenchModel {
    std::string_view name;
    std::string_view path;
    SchemeKind scheme;
};

/// The seven models of the tables in the README.
std::span<const BenchModel> bench_models();
const BenchModel* find_bench_model(std::string_view name);

/// The shared test data: $TETRAKIS_SHARED_DIR, or ../shared beside the project; empty where neither exists.
std::optional<std::filesystem::path> shared_folder();

/// Reads a model, repaired, so that all methods get the same manifold mesh. @throws Error io, invalid_input
ControlMeshData load_bench_model(const BenchModel& model);

}  // namespace tetrakis::bench
