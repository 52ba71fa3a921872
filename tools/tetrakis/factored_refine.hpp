#pragma once

#include "exit_code.hpp"
#include "files.hpp"
#include "run_options.hpp"
#include "scheme_option.hpp"

#include <filesystem>
#include <string>

namespace tetrakis::cli {

/// `refine --factored`: what it takes from the command line.
struct FactoredRefine {
    std::filesystem::path input, output, report;
    std::string scheme;
    RuleOptionFlags rules;
    int half_steps = 0;
    bool active = false;  ///< write the scheme's own faces
    ReadOptions read;
    RunOptions run;
};

/// Those that `refine --factored` takes, with commas between.
std::string factored_scheme_names();

/// Refines by half-steps of the 4-8 mesh and writes it.
/// @throws UsageError: the scheme has no factored form (the message lists those that have)
ExitCode run_factored_refine(const FactoredRefine& options);

}  // namespace tetrakis::cli
