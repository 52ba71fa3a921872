#pragma once

#include "../../hier/base/run_context.hpp"

#include <chrono>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace tetrakis::cli {

/// Each prints one line to standard error: "tetrakis: error: ..." or "tetrakis: warning: ...".
void print_error(std::string_view text);
void print_warning(std::string_view text);
/// Prints each warning once. Of many warnings it prints the first ones and the number of the others.
void print_warnings(const std::vector<std::string>& warnings);

/// Named values for standard output, in two aligned columns. A row with an empty name continues the value above.
class Table {
  public:
    void row(std::string name, std::string value) { rows_.emplace_back(std::move(name), std::move(value)); }
    void print() const;

  private:
    std::vector<std::pair<std::string, std::string>> rows_;
};

/// Flushes standard output. Returns whether all output could be written.
bool flush_output();

/// Numbers for people: "1 234 567", "12.3 MB", "420 ms", and lengths with four digits.
std::string format_count(unsigned long long n);
std::string format_bytes(unsigned long long bytes);
std::string format_seconds(double seconds);
std::string format_length(double length);

/// A progress bar on standard error, if that is a terminal. It also polls for Ctrl-C. The destructor removes the bar.
class Progress {
  public:
    Progress();
    ~Progress() { clear(); }
    Progress(const Progress&) = delete;
    Progress& operator=(const Progress&) = delete;

    /// The function for RunContext::progress. Returns false after Ctrl-C.
    bool update(std::string_view stage, double fraction);
    /// Removes the bar, so that other output can go to the terminal.
    void clear();

  private:
    bool terminal_;
    bool drawn_ = false;
    std::chrono::steady_clock::time_point last_drawn_;
};

/// From now on the first SIGINT (Ctrl-C) or SIGTERM only sets a flag, so that the running call can end cleanly. A
/// second signal ends the program at once. In both cases the exit code is ExitCode::cancelled.
void catch_interrupts();

/// From now on such a signal ends the program at once. For long work that cannot be cancelled and writes no file.
void let_interrupts_end();

/// Whether such a signal has arrived.
bool interrupted() noexcept;

}  // namespace tetrakis::cli
