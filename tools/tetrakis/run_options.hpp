#pragma once

#include "../../eval/render/render.hpp"
#include "../../hier/base/run_context.hpp"
#include "console.hpp"

#include <oneapi/tbb/global_control.h>
#include <CLI/CLI.hpp>

#include <array>
#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace tetrakis::cli {

/// The number that a text is; nothing where it is none, or not finite.
std::optional<double> finite_number(const std::string& text);
/// So many finite numbers with commas between them; nothing where the text is anything else.
std::optional<std::vector<double>> finite_numbers(std::string_view text, std::size_t count);
/// Checks that an option's text is a finite number of some kind (the parser itself takes "nan").
/// @param kind  how the refusal calls it, with its article
CLI::Validator number_check(const std::string& kind, bool (*is_of_kind)(double));

/// Two counts from 1 to `most`, as 1200x900; nothing where the text is not that.
std::optional<std::array<int, 2>> parse_counts(std::string_view text, int most);

/// The options that every long command has: --threads and --max-memory.
struct RunOptions {
    int threads = 0;                     ///< 0: one for each processor that the program may use
    std::uint64_t max_memory_bytes = 0;  ///< 0: 80 % of what is free

    void add(CLI::App& command);
    int thread_count() const;  ///< the number that is used
};

/// A command while it runs: the limits of its options, and its progress bar.
class Run {
  public:
    explicit Run(const RunOptions& options);

    const RunContext& context() const { return context_; }
    /// Removes the progress bar before other output.
    void end_progress() { progress_.clear(); }

  private:
    void stop_above_limit();

    oneapi::tbb::global_control threads_;  // what the libraries below us start keeps to the same number
    Progress progress_;
    RunContext context_;
    std::chrono::steady_clock::time_point last_look_;  ///< at the memory in use
};

inline constexpr double k_thousand = 1000, k_binary_thousand = 1024;

/// "500M", "2G", "1.5GiB", "1048576": K, M, G and T are powers of a thousand. Nothing where the text is no size.
/// @param thousand  k_thousand, or k_binary_thousand for bytes
std::optional<std::uint64_t> parse_size(std::string_view text, double thousand);

/// Memory that this process holds now; 0 where the system does not say.
std::uint64_t memory_bytes();

/// Memory that is free for the taking, as the system estimates it; 0 where it does not say.
std::uint64_t free_memory_bytes();

/// Of --samples: more would take days.
inline constexpr std::uint64_t k_most_samples = 10'000'000'000;

/// --size of a picture.
void add_size_option(CLI::App& command, RenderOptions& render);
/// --size, --camera and --up, of every command that draws a mesh.
void add_view_options(CLI::App& command, RenderOptions& render);

/// The first of these options that the command line of `command` has; empty where it has none.
std::string given_view_option(const CLI::App& command);

}  // namespace tetrakis::cli
