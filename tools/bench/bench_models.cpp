#include "bench_models.hpp"

#include "../../hier/obj/obj_reader.hpp"

#include <algorithm>
#include <array>
#include <cstdlib>

namespace tetrakis::bench {

namespace {

constexpr std::array<BenchModel, 7> k_models{{
    {"spot-control", "data/models/spot-control.obj", SchemeKind::catmull_clark},
    {"rook", "data/osd-shapes/catmark_rook.obj", SchemeKind::catmull_clark},
    {"pawn", "data/osd-shapes/catmark_pawn.obj", SchemeKind::catmull_clark},
    {"helmet", "data/osd-shapes/catmark_helmet.obj", SchemeKind::catmull_clark},
    {"suzanne", "data/models/suzanne.obj", SchemeKind::catmull_clark},
    {"fandisk", "data/models/fandisk.obj", SchemeKind::loop},
    {"cow", "data/models/cow.obj", SchemeKind::loop},
}};

}  // namespace

std::span<const BenchModel> bench_models() { return k_models; }

const BenchModel* find_bench_model(std::string_view name) {
    const auto found = std::ranges::find(k_models, name, &BenchModel::name);
    return found == k_models.end() ? nullptr : &*found;
}

std::optional<std::filesystem::path> shared_folder() {
    if (const char* named = std::getenv("TETRAKIS_SHARED_DIR")) return named;
    std::filesystem::path beside = std::filesystem::path(TETRAKIS_SOURCE_DIR).parent_path() / "shared";
    if (std::filesystem::is_directory(beside)) return beside;
    return std::nullopt;
}

ControlMeshData load_bench_model(const BenchModel& model) {
    const auto folder = shared_folder();
    if (!folder)
        throw Error(ErrorCode::io, "the shared test data are not here; name their folder in TETRAKIS_SHARED_DIR");
    return read_obj(*folder / model.path, {.repair = true});
}

}  // namespace tetrakis::bench
