#pragma once

#include "exit_code.hpp"
#include "files.hpp"
#include "run_options.hpp"
#include "scheme_option.hpp"

#include "../../hier/base/vec.hpp"

#include <filesystem>
#include <optional>
#include <string>

namespace tetrakis::cli {

/// Where half-steps adapt: as many as asked for inside, fewer outside.
struct HalfStepSphere {
    Vec3d centre{0};
    double radius = 0;
};

/// `refine --factored`: what it takes from the command line.
struct FactoredRefine {
    std::filesystem::path input, output, report;
    std::string scheme;
    RuleOptionFlags rules;
    int half_steps = 0;
    bool active = false;  ///< write the scheme's own faces
    std::optional<HalfStepSphere> sphere;
    ReadOptions read;
    RunOptions run;
};

/// The sphere of --near X,Y,Z and --radius R.
/// @throws UsageError  they are no three finite numbers and one above 0
HalfStepSphere half_step_sphere(const std::string& near, const std::string& radius);

/// Those that `refine --factored` takes, with commas between.
std::string factored_scheme_names();

/// Refines by half-steps of the 4-8 mesh and writes it.
/// @throws UsageError: the scheme has no factored form, or with a sphere none that adapts (the message lists those that
///                     have)
ExitCode run_factored_refine(const FactoredRefine& options);

}  // namespace tetrakis::cli
