#include "report.hpp"

#include "../../hier/base/memory.hpp"
#include "../../hier/base/version.hpp"

#include <fmt/format.h>

#include <array>
#include <utility>

namespace tetrakis::cli {
namespace {

template <class T>
Json or_null(const std::optional<T>& value) {
    return value ? Json(*value) : Json(nullptr);
}

std::array<std::pair<const char*, double>, 6> stages(const StageSeconds& s) {
    return {{{"load", s.load},
             {"build", s.build},
             {"refine", s.refine},
             {"estimate", s.estimate},
             {"measure", s.measure},
             {"write", s.write}}};
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
    report.faces = model.faces;
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
                 {"seconds", Json::object()},
                 {"peak_memory_bytes", peak_memory_bytes()},
                 {"threads", threads},
                 {"version", std::string(k_version)}};
    for (const auto& [stage, taken] : stages(seconds)) json["seconds"][stage] = taken;
    json.update(more);
    json["warnings"] = warnings;
    return json;
}

void write_results(Run& process, Report& report, const std::filesystem::path& report_path,
                   const std::function<void(FileSet&)>& write) {
    const Stopwatch time;
    FileSet files;
    write(files);
    files.finish();
    report.seconds.write = time.seconds();
    if (!report_path.empty()) files.add(report_path).write(dump(report.json()));
    files.commit();
    process.end_progress();
    print_warnings(report.warnings);
}

void finish_summary(Table& table, const Report& report, std::initializer_list<std::filesystem::path> written) {
    std::string times;
    for (const auto& [stage, seconds] : stages(report.seconds))
        if (seconds > 0) times += fmt::format("{}{} {}", times.empty() ? "" : ", ", stage, format_seconds(seconds));
    table.row("time", times);
    table.row("memory", format_bytes(peak_memory_bytes()) + " at the peak");
    std::string label = "written";
    for (const auto& path : written) {
        if (path.empty()) continue;
        table.row(std::exchange(label, {}), path.string());
    }
    table.print();
}

std::string dump(const Json& json) { return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n"; }

}  // namespace tetrakis::cli
