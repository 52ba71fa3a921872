#include "scheme_option.hpp"

#include "exit_code.hpp"
#include "run_options.hpp"

#include "../../hier/mesh/triangulate.hpp"
#include "../../refine/uniform/refine.hpp"

#include <algorithm>
#include <charconv>
#include <initializer_list>
#include <numbers>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

namespace tetrakis::cli {

namespace {

constexpr int k_most_averaging_steps = 64;
constexpr std::string_view k_measured = "measured";

double corner_degrees(const std::string& text) {
    double degrees = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), degrees);
    return error == std::errc() && end == text.data() + text.size() ? degrees : 0;
}

std::string check_corner_angle(const std::string& text) {
    const double degrees = corner_degrees(text);
    if (text == k_measured || (degrees >= 1 && degrees <= 359 && degrees != 180)) return {};
    return text + " is neither " + std::string(k_measured) + " nor a number of degrees from 1 to 359 other than 180";
}

}  // namespace

const SchemeInfo& chosen_scheme(const std::string& text) {
    try {
        return scheme_named(text);
    } catch (const Error& error) {
        throw UsageError(error.what());
    }
}

void RuleOptionFlags::add_averaging_steps(CLI::App& command) {
    command.add_option("--steps", rules_.averaging_steps, "averaging: number of steps (3)")
        ->type_name("M")
        ->check(CLI::Range(0, k_most_averaging_steps).description(""));
}

void RuleOptionFlags::set_averaging_steps(int steps, std::string option) {
    if (steps < 0 || steps > k_most_averaging_steps)
        throw CLI::ValidationError(option, "averaging takes 0 to " + std::to_string(k_most_averaging_steps));
    rules_.averaging_steps = steps;
    steps_option_ = std::move(option);
}

std::vector<CLI::Option*> RuleOptionFlags::add(CLI::App& command) {
    return {
        command.add_option("--tuning", rules_.tuning, "tuned-loop: 0 (loop) to 1 (the default)")
            ->type_name("T")
            ->check(number_check("a number from 0 to 1", [](double t) { return t >= 0 && t <= 1; })),
        command
            .add_option("--edge-rule", edge_rule_,
                        "loop, tuned-loop, catmull-clark: edges beside creases: plain, cosine or brief")
            ->type_name("R")
            ->check(CLI::IsMember({"plain", "cosine", "brief"}).description("")),
        command
            .add_option("--beta", rules_.catmull_clark_beta,
                        "catmull-clark: total weight of the edge neighbours at extraordinary vertices between quads")
            ->type_name("B"),
        command.add_option("--gamma", rules_.catmull_clark_gamma, "catmull-clark: that of the opposite corners")
            ->type_name("G"),
        command
            .add_option("--corner-angle", corner_angle_,
                        "loop, tuned-loop, catmull-clark: interior angle at corners without a tag of their own, in "
                        "degrees, or measured: in the control mesh")
            ->type_name("A")
            ->check(CLI::Validator(check_corner_angle, "")),
        command.add_flag("--warren", warren_, "loop: Warren's weights"),
        command.add_flag("--hoppe", hoppe_, "loop: Hoppe's crease rule"),
        command.add_flag("--reflect", rules_.reflect_at_boundary,
                         "modified-butterfly: points beyond the boundary by reflection"),
        command
            .add_option(
                "--ten-point", rules_.butterfly_w,
                "butterfly, modified-butterfly: tension w of the ten-point rule at regular edges (0: eight points)")
            ->type_name("W")
            ->check(number_check("a finite number", [](double) { return true; })),
        command.add_flag(recede_option, recede_,
                         "biquartic, averaging: use up the outer ring of an open mesh instead of copying it"),
    };
}

RuleOptions RuleOptionFlags::rules() const {
    RuleOptions rules = rules_;
    if (warren_) rules.loop_weights = LoopWeights::warren;
    rules.hoppe_crease = hoppe_;
    rules.measure_corner_angles = corner_angle_ == k_measured;
    rules.corner_angle = corner_degrees(corner_angle_) * std::numbers::pi / 180;
    if (recede_) rules.averaging_boundary = AveragingBoundary::recede;
    if (edge_rule_ == "cosine") rules.edge_beside_crease = EdgeBesideCrease::cosine;
    if (edge_rule_ == "brief") rules.edge_beside_crease = EdgeBesideCrease::brief;
    return rules;
}

std::vector<std::string> RuleOptionFlags::unused(const SchemeInfo& scheme) const {
    const RuleOptions plain;
    const auto is_one_of = [&](std::initializer_list<std::string_view> names) {
        return std::find(names.begin(), names.end(), scheme.name) != names.end();
    };
    std::vector<std::string> warnings;
    const auto look = [&](bool given, std::initializer_list<std::string_view> users, const char* option) {
        if (given && !is_one_of(users))
            warnings.push_back(std::string(option) + " has no effect on " + std::string(scheme.name));
    };
    look(rules_.tuning != plain.tuning, {"tuned-loop"}, "--tuning");
    look(edge_rule_ != "plain", {"loop", "tuned-loop", "catmull-clark"}, "--edge-rule");
    look(rules_.catmull_clark_beta.has_value(), {"catmull-clark"}, "--beta");
    look(rules_.catmull_clark_gamma.has_value(), {"catmull-clark"}, "--gamma");
    look(!corner_angle_.empty(), {"loop", "tuned-loop", "catmull-clark"}, "--corner-angle");
    look(warren_, {"loop"}, "--warren");
    look(hoppe_, {"loop"}, "--hoppe");
    look(rules_.reflect_at_boundary, {"modified-butterfly"}, "--reflect");
    look(rules_.butterfly_w != plain.butterfly_w, {"butterfly", "modified-butterfly"}, "--ten-point");
    look(recede_, {"biquartic", "averaging"}, recede_option);
    look(rules_.averaging_steps != plain.averaging_steps, {"averaging"}, steps_option_.c_str());
    return warnings;
}

void prepare_for(const SchemeInfo& scheme, ControlMesh& mesh, const RunContext& context) {
    if (scheme.family == MeshFamily::triangles && !mesh.all_triangles()) mesh = triangulate(mesh, context);
}

}  // namespace tetrakis::cli
