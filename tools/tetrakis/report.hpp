#pragma once

#include "console.hpp"
#include "files.hpp"
#include "run_options.hpp"

#include "../../eval/tessellate/tessellate.hpp"
#include "../../hier/base/files.hpp"

#include <nlohmann/json.hpp>

#include <cstdint>
#include <filesystem>
#include <functional>
#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace tetrakis::cli {

using Json = nlohmann::ordered_json;

/// Results of a run, for other programs. Lengths are in the unit of the model; fields that do not apply are null.
struct Report {
    std::filesystem::path input;
    std::string scheme;
    std::uint64_t faces = 0;                 ///< of the control mesh as read
    std::uint64_t vertices = 0;              ///< of the result
    std::optional<std::uint64_t> triangles;  ///< of the result, if it is made of triangles
    std::optional<double> tolerance, tolerance_absolute, certified_error;
    std::optional<MeasuredError> measured_error;
    int levels = 0;
    StageSeconds seconds;
    int threads = 0;
    std::vector<std::string> warnings;
    Json more = Json::object();  ///< additional keys of this command, after the common ones

    /// A report with the fields that are known once the model is loaded.
    static Report of(const std::filesystem::path& input, std::string_view scheme, const LoadedModel& model,
                     const RunOptions& run);

    Json json() const;
};

/// Ends a command that makes a mesh: writes its files, all or none, then prints the warnings.
/// @param write  writes all files but the report. @param report_path  may be empty
void write_results(Run& process, Report& report, const std::filesystem::path& report_path,
                   const std::function<void(FileSet&)>& write);
/// Adds time, memory and the files written to a summary and prints it. Empty paths are ignored.
void finish_summary(Table& table, const Report& report, std::initializer_list<std::filesystem::path> written);

/// {forward, backward, hausdorff, mean, rms}, or null.
Json json_of(const std::optional<MeasuredError>& error);
/// JSON as text. It is valid for text of any encoding; numbers are as short as possible for the same value.
std::string dump(const Json& json);

}  // namespace tetrakis::cli
