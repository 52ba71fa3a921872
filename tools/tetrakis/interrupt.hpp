#pragma once

namespace tetrakis::cli {

/// From now on the first Ctrl-C (SIGINT) or SIGTERM only sets a flag, so that the running call can end cleanly; a
/// second one ends the program at once. Either way its exit code is ExitCode::cancelled.
void catch_interrupts();

/// From now on such a signal ends the program at once: for long work that nothing can cancel, while no file is written.
void let_interrupts_end();

/// Whether such a signal has arrived.
bool interrupted() noexcept;

}  // namespace tetrakis::cli
