#pragma once

#include "../../hier/base/run_context.hpp"
#include "../../hier/mesh/control_mesh.hpp"
#include "../../schemes/core/scheme_table.hpp"

#include <CLI/CLI.hpp>

#include <string>
#include <vector>

namespace tetrakis::cli {

/// The scheme of that name in the whole table. @throws UsageError: an unknown one; says the nearest and all names
const SchemeInfo& chosen_scheme(const std::string& text);

/// The choices that rules offer, as options: --tuning, --edge-rule, --warren, --hoppe, ...
class RuleOptionFlags {
  public:
    static constexpr const char* recede_option = "--recede";

    /// All but --steps; returns them.
    std::vector<CLI::Option*> add(CLI::App& command);
    void add_averaging_steps(CLI::App& command);
    /// @param option  the one that says so
    /// @throws CLI::ValidationError  more than the rules allow
    void set_averaging_steps(int steps, std::string option = "--steps");
    RuleOptions rules() const;
    /// Of those given, the ones that the scheme has no use for, as warnings.
    std::vector<std::string> unused(const SchemeInfo& scheme) const;

  private:
    RuleOptions rules_;
    std::string steps_option_ = "--steps";
    std::string edge_rule_ = "plain";
    std::string corner_angle_;  // degrees, or k_measured; empty: none
    bool warren_ = false, hoppe_ = false, recede_ = false;
};

/// Makes the mesh one that the scheme can refine: for triangle schemes its faces are cut into triangles, with a
/// warning.
void prepare_for(const SchemeInfo& scheme, ControlMesh& mesh, const RunContext& context);

}  // namespace tetrakis::cli
