#pragma once

#include "../../hier/base/run_context.hpp"
#include "../../hier/mesh/control_mesh.hpp"
#include "../../schemes/core/scheme_table.hpp"
#include "command_line.hpp"

#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace tetrakis::cli {

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

/// Makes the mesh one that the scheme can refine: for triangle schemes its faces are cut into triangles, with a
/// warning.
void prepare_for(const SchemeInfo& scheme, ControlMesh& mesh, const RunContext& context);

}  // namespace tetrakis::cli
