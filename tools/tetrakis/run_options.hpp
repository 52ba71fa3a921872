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

/// So many finite numbers with commas between them; nothing where the text is anything else.
std::optional<std::vector<double>> finite_numbers(std::string_view text, std::size_t count);
/// Two counts from 1 to `most`, as 1200x900; nothing where the text is not that.
std::optional<std::array<int, 2>> parse_counts(std::string_view text, int most);

/// The options that every long command has: --threads and --max-memory.
struct RunOptions {
    int threads = 0;                     ///< 0: one for each processor that the program may use
    std::uint64_t max_memory_bytes = 0;  ///< 0: 80 % of what is free

    void add(CommandLine command);
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

inline constexpr double k_thousand = 1000;

/// "500M", "2G", "1.5GiB", "1048576": K, M, G and T are powers of a thousand. Nothing where the text is no size.
/// @param thousand  k_thousand, or 1024 for bytes
std::optional<std::uint64_t> parse_size(std::string_view text, double thousand);
/// An option whose value is a size in bytes.
void add_bytes_option(CommandLine command, const std::string& name, std::uint64_t& bytes, const std::string& help);

/// Memory that this process holds now; 0 where the system does not say.
std::uint64_t memory_bytes();

/// Memory that is free for the taking, as the system estimates it; 0 where it does not say.
std::uint64_t free_memory_bytes();

/// Of --samples: more would take days.
inline constexpr std::uint64_t k_most_samples = 10'000'000'000;

/// --size of a picture.
void add_size_option(CommandLine command, RenderOptions& render);
/// --size, --camera and --up, of every command that draws a mesh.
void add_view_options(CommandLine command, RenderOptions& render);

/// The first of these options that the command line of `command` has; empty where it has none.
std::string given_view_option(const CommandLine& command);

/// The scheme of that name, in any case. @throws UsageError: an unknown one; says the nearest and all names
const SchemeInfo& chosen_scheme(std::string text);

/// A choice that the rules of some schemes offer, as an option of the command line.
struct RuleOption {
    std::string_view flag;
    std::string_view users;      ///< names of the schemes that have this choice, with commas between
    std::string_view help;       ///< the help text is "users: help"
    std::string_view type_name;  ///< empty for an option without a value
    /// Takes a value from the command line; returns what is wrong with it, or an empty text.
    std::string (*set)(RuleOptions& rules, const std::string& text);
    void (*reset)(RuleOptions& rules);  ///< back to the default
};

inline constexpr std::string_view k_steps_option = "--steps", k_recede_option = "--recede";

std::span<const RuleOption> rule_options();
enum class StepsOption { leave_out, add };
/// Adds them to the command.
/// @param steps  whether the number of averaging steps is one of them
void add_rule_options(CommandLine command, RuleOptions& rules, StepsOption steps = StepsOption::add);
/// Of the choices made, those that the scheme does not have, as warnings.
/// @param steps_option  what the command calls the number of averaging steps
std::vector<std::string> unused_rule_options(const RuleOptions& rules, const SchemeInfo& scheme,
                                             std::string_view steps_option = k_steps_option);

/// Names of the schemes with a certified bound, with commas between.
std::string certified_scheme_names();

}  // namespace tetrakis::cli
