#include "report.hpp"

#include "../../hier/base/version.hpp"

namespace tetrakis::cli {
namespace {

template <class T>
Json or_null(const std::optional<T>& value) {
    return value ? Json(*value) : Json(nullptr);
}

}  // namespace

Json json_of(const std::optional<MeasuredError>& error) {
    if (!error) return nullptr;
    return {{"forward", error->forward},
            {"backward", error->backward},
            {"hausdorff", error->hausdorff},
            {"mean", error->mean},
            {"rms", error->rms}};
}

Report Report::of(const std::filesystem::path& input, std::string_view scheme, const LoadedModel& model,
                  const RunOptions& run) {
    Report report;
    report.input = input;
    report.scheme = scheme;
    report.faces = model.mesh.face_count();
    report.threads = run.thread_count();
    report.seconds.load = model.load_seconds;
    report.seconds.build = model.build_seconds;
    report.warnings = model.mesh.warnings();
    return report;
}

Json Report::json() const {
    Json json = {{"input", input.string()},
                 {"scheme", scheme},
                 {"faces", faces},
                 {"vertices", vertices},
                 {"triangles", or_null(triangles)},
                 {"tolerance", or_null(tolerance)},
                 {"tolerance_absolute", or_null(tolerance_absolute)},
                 {"certified_error", or_null(certified_error)},
                 {"measured_error", json_of(measured_error)},
                 {"levels", levels},
                 {"seconds",
                  {{"load", seconds.load},
                   {"build", seconds.build},
                   {"refine", seconds.refine},
                   {"estimate", seconds.estimate},
                   {"measure", seconds.measure},
                   {"write", seconds.write}}},
                 {"peak_memory_bytes", peak_memory_bytes()},
                 {"threads", threads},
                 {"version", std::string(k_version)}};
    json.update(more);
    json["warnings"] = warnings;
    return json;
}

void Report::write(AtomicFile& file) const { file.write(dump(json())); }

std::string dump(const Json& json) { return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n"; }

}  // namespace tetrakis::cli
