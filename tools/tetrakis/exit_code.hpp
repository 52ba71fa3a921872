#pragma once

#include <stdexcept>

namespace tetrakis::cli {

/// What the program's exit code says. The numbers are documented in the README and do not change.
enum class ExitCode {
    done = 0,
    failure = 1,                ///< at run time: disk full, out of memory, ...
    usage = 2,                  ///< the command line makes no sense
    bad_input = 3,              ///< an input file is missing or wrong
    tolerance_not_reached = 4,  ///< the best result is written all the same
    cancelled = 130,            ///< 128 + SIGINT
};

/// The command line makes no sense, in a way that the option parser cannot see.
class UsageError : public std::runtime_error {
    using std::runtime_error::runtime_error;
};

/// An input file is missing, unreadable or wrong.
class InputError : public std::runtime_error {
    using std::runtime_error::runtime_error;
};

}  // namespace tetrakis::cli
