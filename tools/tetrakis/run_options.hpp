#pragma once

#include "../../eval/render/render.hpp"
#include "../../hier/base/run_context.hpp"
#include "../../schemes/core/scheme_table.hpp"
#include "command_line.hpp"
#include "console.hpp"

#include <oneapi/tbb/global_control.h>

#include <array>
#include <chrono>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace tetrakis::cli {

/// Parses `count` finite numbers with commas between them; nothing if the text is anything else.
std::optional<std::vector<double>> finite_numbers(std::string_view text, std::size_t count);
/// Parses two counts from 1 to `most`, such as 1200x900; nothing if the text is anything else.
std::optional<std::array<int, 2>> parse_counts(std::string_view text, int most);

/// The options of all commands that can take long: --threads and --max-memory.
struct RunOptions {
    int threads = 0;                     ///< 0: one for each processor that the program may use
    std::uint64_t max_memory_bytes = 0;  ///< 0: 80 % of the free memory

    void add(CommandLine command);
    int thread_count() const;  ///< number of threads in use
};

/// A running command: enforces the limits of its options and shows its progress bar.
class Run {
  public:
    explicit Run(const RunOptions& options);

    const RunContext& context() const { return context_; }
    /// Removes the progress bar before other output.
    void end_progress() { progress_.clear(); }

  private:
    void stop_above_limit();

    oneapi::tbb::global_control threads_;  // also limits the threads of other libraries
    Progress progress_;
    RunContext context_;
    std::chrono::steady_clock::time_point last_look_;  ///< last check of the memory in use
};

inline constexpr double k_thousand = 1000;

/// Parses a size: "500M", "2G", "1.5GiB", "1048576". K, M, G and T are powers of `thousand`. Nothing if it is no size.
/// @param thousand  k_thousand, or 1024 for bytes
std::optional<std::uint64_t> parse_size(std::string_view text, double thousand);
/// Adds an option whose value is a size in bytes.
void add_bytes_option(CommandLine command, const std::string& name, std::uint64_t& bytes, const std::string& help);

/// Memory that this process uses now; 0 if the system does not say.
std::uint64_t memory_bytes();

/// Available memory as the system estimates it; 0 if the system does not say.
std::uint64_t free_memory_bytes();

/// Largest value of --samples: more would take days.
inline constexpr std::uint64_t k_most_samples = 10'000'000'000;

/// Adds --size, the size of a picture.
void add_size_option(CommandLine command, RenderOptions& render);
/// Adds --size, --camera and --up, the options of every command that draws a mesh.
void add_view_options(CommandLine command, RenderOptions& render);

/// The first option of add_view_options() that was given on the command line; empty if there is none.
std::string given_view_option(const CommandLine& command);

/// The scheme of that name, upper or lower case. @throws UsageError: unknown; names the nearest and all schemes
const SchemeInfo& chosen_scheme(std::string text);

/// An option of the command line that sets one of the RuleOptions, for the schemes that have it.
struct RuleOption {
    std::string_view flag;
    std::string_view users;      ///< names of the schemes that have this option, with commas between
    std::string_view help;       ///< the help text is "users: help"
    std::string_view type_name;  ///< empty for an option without a value
    /// Parses a value; returns an error message, or an empty text.
    std::string (*set)(RuleOptions& rules, const std::string& text);
    void (*reset)(RuleOptions& rules);  ///< back to the default
};

inline constexpr std::string_view k_steps_option = "--steps", k_recede_option = "--recede";

std::span<const RuleOption> rule_options();
enum class StepsOption { leave_out, add };
/// Adds rule_options() to the command.
/// @param steps  whether the number of averaging steps is added, too
void add_rule_options(CommandLine command, RuleOptions& rules, StepsOption steps = StepsOption::add);
/// Warnings for the options in `rules` that differ from the default and that the scheme does not have.
/// @param steps_option  the command's option for the number of averaging steps
std::vector<std::string> unused_rule_options(const RuleOptions& rules, const SchemeInfo& scheme,
                                             std::string_view steps_option = k_steps_option);

/// Names of the schemes with a certified bound, with commas between.
std::string certified_scheme_names();

}  // namespace tetrakis::cli
