#pragma once

#include "../../hier/base/run_context.hpp"

#include <chrono>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace tetrakis::cli {

/// One line on standard error: "tetrakis: error: ..." and "tetrakis: warning: ...".
void print_error(std::string_view text);
void print_warning(std::string_view text);
/// Each warning once; of many, the first few and how many more there are.
void print_warnings(const std::vector<std::string>& warnings);

/// A list of named values on standard output, the values one below the other. An empty name continues the value above.
class Table {
  public:
    void row(std::string name, std::string value) { rows_.emplace_back(std::move(name), std::move(value)); }
    void print() const;

  private:
    std::vector<std::pair<std::string, std::string>> rows_;
};

/// Whether everything printed has reached standard output.
bool flush_output();

/// "1 234 567", "12.3 MB", "0.42 s" and lengths as people read them.
std::string format_count(unsigned long long n);
std::string format_bytes(unsigned long long bytes);
std::string format_seconds(double seconds);
std::string format_length(double length);

/// A bar on standard error, if that is a terminal, and the place where Ctrl-C is noticed. Gone when it is destroyed.
class Progress {
  public:
    Progress();
    ~Progress() { clear(); }
    Progress(const Progress&) = delete;
    Progress& operator=(const Progress&) = delete;

    /// What RunContext::progress is to call. False once Ctrl-C was pressed.
    bool update(std::string_view stage, double fraction);
    /// Removes the bar, so that other output can go to the terminal.
    void clear();

  private:
    bool terminal_;
    bool drawn_ = false;
    std::chrono::steady_clock::time_point last_drawn_;
};

/// From now on the first Ctrl-C (SIGINT) or SIGTERM only sets a flag, so that the running call can end cleanly; a
/// second one ends the program at once. Either way its exit code is ExitCode::cancelled.
void catch_interrupts();

/// From now on such a signal ends the program at once: for long work that nothing can cancel, while no file is written.
void let_interrupts_end();

/// Whether such a signal has arrived.
bool interrupted() noexcept;

}  // namespace tetrakis::cli
