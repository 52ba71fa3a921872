#pragma once

#include "command_line.hpp"
#include "run_options.hpp"

#include "../../eval/terrain/height_source.hpp"
#include "../../hier/base/error.hpp"
#include "../../hier/base/files.hpp"
#include "../../hier/base/run_context.hpp"
#include "../../hier/mesh/control_mesh.hpp"
#include "../../hier/obj/obj_reader.hpp"

#include <chrono>
#include <filesystem>
#include <memory>
#include <new>
#include <string>
#include <utility>
#include <vector>

namespace tetrakis::cli {

/// Measures the seconds since its construction.
class Stopwatch {
  public:
    double seconds() const { return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count(); }

  private:
    std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

/// Runs `work`. An error that names no file is thrown again with the file name `input`.
template <class Work>
auto about(const std::filesystem::path& input, Work&& work) {
    try {
        return std::forward<Work>(work)();
    } catch (const Error& error) {
        if (!error.file().empty() || error.code() == ErrorCode::cancelled) throw;
        throw Error(error.code(), error.what(), input);
    } catch (const std::bad_alloc&) {
        throw Error(ErrorCode::memory_limit,
                    "out of memory; ask for less (a larger tolerance, fewer levels, --max-triangles)", input);
    }
}

/// Runs `read`, which reads the file `input`. Errors but memory_limit and cancelled become an InputError.
template <class Read>
auto reading(const std::filesystem::path& input, Read&& read) {
    try {
        return about(input, std::forward<Read>(read));
    } catch (const Error& error) {
        if (error.code() == ErrorCode::memory_limit || error.code() == ErrorCode::cancelled) throw;
        throw InputError(error.what());
    }
}

/// A control mesh read from a file, and the time that this took.
struct LoadedModel {
    ControlMesh mesh;
    std::uint64_t faces = 0;  ///< as read, before faces are cut into triangles
    double load_seconds = 0, build_seconds = 0;
};

/// Adds --weld and --repair, the options of every command that loads a control mesh.
void add_read_options(CommandLine command, ReadOptions& options);

/// @param scheme  scheme that will refine the mesh, or null. For triangle schemes faces are cut into triangles, with a
///                warning.
/// @throws InputError, Error (memory_limit, cancelled)
LoadedModel load_model(const std::filesystem::path& path, const ReadOptions& options, const RunContext& context,
                       const SchemeInfo* scheme = nullptr);

/// Options of the command line that name a file of heights and say how to read it.
struct HeightInput {
    std::filesystem::path path;
    HeightReadOptions read;
    double spacing = 0;  ///< 0: the file's own

    /// Adds the options to a command. @param what  help text of the file's option, which is returned
    Option add(CommandLine command, const std::string& what = {});
    /// @param warnings  receives a warning if missing heights were filled
    /// @throws InputError, Error (memory_limit, cancelled)
    HeightGrid load(const Run& process, std::vector<std::string>& warnings) const;
    /// @throws InputError, Error (memory_limit, cancelled)
    std::unique_ptr<HeightSource> open(const Run& process) const;

  private:
    HeightReadOptions options(const Run& process) const;
};

using tetrakis::detail::lower_extension;

/// The files that a command will write, checked before it does any work.
class OutputFiles {
  public:
    enum class Kind { mesh, picture, report, table, tiles };
    /// An empty path is ignored, except a mesh's. @param option  name of the file's option, for messages
    /// @throws UsageError: a mesh without a path, or an extension that cannot be written
    void add(Kind kind, const std::string& option, const std::filesystem::path& path);
    /// @throws UsageError: two files are the same, or a file is among `inputs`; Error io: a file cannot be written
    void check(const std::vector<std::filesystem::path>& inputs) const;

  private:
    std::vector<std::pair<std::string, std::filesystem::path>> files_;
};

}  // namespace tetrakis::cli
