#pragma once

#include "../../hier/base/run_context.hpp"

#include <chrono>
#include <string_view>

namespace tetrakis::cli {

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

/// Throws Error(cancelled) where Ctrl-C was pressed: for the stretches between the library's calls.
void stop_if_interrupted();

}  // namespace tetrakis::cli
