#pragma once

#include "rule_step.hpp"

#include <string>

namespace tetrakis {

/// The options that choose other rules than the default ones, as text: "averaging_steps 2, tuning 0.5", in the order of
/// their declaration; empty for plain rules. Equal texts are equal rules: numbers are written to their last bit.
std::string rule_choices(const RuleOptions& options);

}  // namespace tetrakis
