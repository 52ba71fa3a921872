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

/// What a run has done, for programs to read. Lengths are in the unit of the model; what does not apply is null.
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
    Json more = Json::object();  ///< keys of one command alone; they follow the others

    /// What is known of every command's report once the model is there.
    static Report of(const std::filesystem::path& input, std::string_view scheme, const LoadedModel& model,
                     const RunOptions& run);

    Json json() const;
};

/// The end of a command that makes a mesh. Writes its files, all or none; then prints the warnings.
/// @param write  writes the files but the report, whose path may be empty
void write_results(Run& process, Report& report, const std::filesystem::path& report_path,
                   const std::function<void(FileSet&)>& write);
/// Adds the last rows of its summary, time, memory and the files written, and prints it. Empty paths are passed over.
void finish_summary(Table& table, const Report& report, std::initializer_list<std::filesystem::path> written);

/// {forward, backward, hausdorff, mean, rms}, or null.
Json json_of(const std::optional<MeasuredError>& error);
/// Text of any encoding becomes valid JSON; numbers are the shortest that read back the same.
std::string dump(const Json& json);

}  // namespace tetrakis::cli
