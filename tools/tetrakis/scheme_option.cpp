#include "scheme_option.hpp"

#include "console.hpp"

#include "../../eval/tessellate/tessellate.hpp"
#include "../../hier/mesh/triangulate.hpp"
#include "../../refine/uniform/refine.hpp"
#include "../../schemes/core/rule_options.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <numbers>
#include <optional>

namespace tetrakis::cli {

namespace {

/// Takes a finite number from `low` to `high` into `to`.
template <class Number>
std::string set_number(Number& to, const std::string& text, double low = -HUGE_VAL, double high = HUGE_VAL) {
    const std::optional<double> x = finite_number(text);
    if (!x || *x < low || *x > high)
        return text + (std::isfinite(low) ? fmt::format(" is not a number from {} to {}", low, high)
                                          : std::string(" is not a finite number"));
    to = *x;
    return {};
}

std::string set_edge_rule(RuleOptions& rules, const std::string& text) {
    if (text == "plain")
        rules.edge_beside_crease = EdgeBesideCrease::plain;
    else if (text == "cosine")
        rules.edge_beside_crease = EdgeBesideCrease::cosine;
    else if (text == "brief")
        rules.edge_beside_crease = EdgeBesideCrease::brief;
    else
        return text + " is none of plain, cosine and brief";
    return {};
}

std::string set_corner_angle(RuleOptions& rules, const std::string& text) {
    rules.measure_corner_angles = text == "measured";
    if (rules.measure_corner_angles) return {};
    const double degrees = finite_number(text).value_or(0);
    if (!(degrees >= 1 && degrees <= 359 && degrees != 180))
        return text + " is neither measured nor a number of degrees from 1 to 359 other than 180";
    rules.corner_angle = degrees * std::numbers::pi / 180;
    return {};
}

std::string set_steps(RuleOptions& rules, const std::string& text) {
    constexpr int k_most = 64;
    const double steps = finite_number(text).value_or(-1);
    if (steps != std::floor(steps) || steps < 0 || steps > k_most)
        return fmt::format("{}: averaging takes 0 to {}", text, k_most);
    rules.averaging_steps = static_cast<int>(steps);
    return {};
}

using Text = std::string;
const RuleOptions k_plain;

constexpr RuleOption k_rule_options[] = {
    {k_steps_option, "averaging", "number of steps (3)", "M", set_steps,
     [](RuleOptions& o) { o.averaging_steps = k_plain.averaging_steps; }},
    {"--tuning", "tuned-loop", "0 (loop) to 1 (the default)", "T",
     [](RuleOptions& o, const Text& text) { return set_number(o.tuning, text, 0, 1); },
     [](RuleOptions& o) { o.tuning = k_plain.tuning; }},
    {"--edge-rule", "loop, tuned-loop, catmull-clark", "edges beside creases: plain, cosine or brief", "R",
     set_edge_rule, [](RuleOptions& o) { o.edge_beside_crease = EdgeBesideCrease::plain; }},
    {"--beta", "catmull-clark", "total weight of the edge neighbours at extraordinary vertices between quads", "B",
     [](RuleOptions& o, const Text& text) { return set_number(o.catmull_clark_beta, text); },
     [](RuleOptions& o) { o.catmull_clark_beta.reset(); }},
    {"--gamma", "catmull-clark", "that of the opposite corners", "G",
     [](RuleOptions& o, const Text& text) { return set_number(o.catmull_clark_gamma, text); },
     [](RuleOptions& o) { o.catmull_clark_gamma.reset(); }},
    {"--corner-angle", "loop, tuned-loop, catmull-clark",
     "interior angle at corners without a tag of their own, in degrees, or measured: in the control mesh", "A",
     set_corner_angle,
     [](RuleOptions& o) {
         o.corner_angle = 0;
         o.measure_corner_angles = false;
     }},
    {"--warren", "loop", "Warren's weights", "",
     [](RuleOptions& o, const Text&) { return o.loop_weights = LoopWeights::warren, Text(); },
     [](RuleOptions& o) { o.loop_weights = LoopWeights::loop; }},
    {"--hoppe", "loop", "Hoppe's crease rule", "",
     [](RuleOptions& o, const Text&) { return o.hoppe_crease = true, Text(); },
     [](RuleOptions& o) { o.hoppe_crease = false; }},
    {"--reflect", "modified-butterfly", "points beyond the boundary by reflection", "",
     [](RuleOptions& o, const Text&) { return o.reflect_at_boundary = true, Text(); },
     [](RuleOptions& o) { o.reflect_at_boundary = false; }},
    {"--ten-point", "butterfly, modified-butterfly",
     "tension w of the ten-point rule at regular edges (0: eight points)", "W",
     [](RuleOptions& o, const Text& text) { return set_number(o.butterfly_w, text); },
     [](RuleOptions& o) { o.butterfly_w = k_plain.butterfly_w; }},
    {k_recede_option, "biquartic, averaging", "use up the outer ring of an open mesh instead of copying it", "",
     [](RuleOptions& o, const Text&) { return o.averaging_boundary = AveragingBoundary::recede, Text(); },
     [](RuleOptions& o) { o.averaging_boundary = AveragingBoundary::replicate; }},
};

}  // namespace

std::span<const RuleOption> rule_options() { return k_rule_options; }

void add_rule_options(CommandLine command, RuleOptions& rules, StepsOption steps) {
    for (const RuleOption& option : rule_options()) {
        if (option.flag == k_steps_option && steps == StepsOption::leave_out) continue;
        const std::string flag(option.flag), help = fmt::format("{}: {}", option.users, option.help);
        if (option.type_name.empty())
            command.flag_function(
                flag, [&rules, &option] { option.set(rules, {}); }, help);
        else
            command.option_function(
                flag, std::string(option.type_name),
                [&rules, &option](const std::string& text) { return option.set(rules, text); }, help);
    }
}

std::vector<std::string> unused_rule_options(const RuleOptions& rules, const SchemeInfo& scheme,
                                             std::string_view steps_option) {
    std::vector<std::string> warnings;
    for (const RuleOption& option : rule_options()) {
        RuleOptions without = rules;
        option.reset(without);
        const bool used = fmt::format(", {},", option.users).find(fmt::format(", {},", scheme.name)) != Text::npos;
        if (!used && rule_choices(without) != rule_choices(rules))
            warnings.push_back(fmt::format("{} has no effect on {}",
                                           option.flag == k_steps_option ? steps_option : option.flag, scheme.name));
    }
    return warnings;
}

std::string certified_scheme_names() {
    std::string names;
    for (const SchemeInfo& scheme : scheme_table()) {
        const bool plain = scheme_support(scheme.name).certified;
        if (!plain && !scheme_support(scheme.name, {.averaging_steps = 2}).certified) continue;
        names += fmt::format("{}{}{}", names.empty() ? "" : ", ", scheme.name, plain ? "" : " (even --steps)");
    }
    return names;
}

const SchemeInfo& chosen_scheme(std::string text) {
    std::ranges::transform(text, text.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    try {
        return scheme_named(text);
    } catch (const Error& error) {
        throw UsageError(error.what());
    }
}

void prepare_for(const SchemeInfo& scheme, ControlMesh& mesh, const RunContext& context) {
    if (scheme.family == MeshFamily::triangles && !mesh.all_triangles()) mesh = triangulate(mesh, context);
}

}  // namespace tetrakis::cli
