#include "rule_step.hpp"

#include <array>
#include <charconv>
#include <string_view>
#include <type_traits>

namespace tetrakis {

namespace {

template <class T>
std::string text(const T& value) {
    if constexpr (std::is_enum_v<T>) {
        return std::to_string(static_cast<int>(value));
    } else {
        std::array<char, 32> digits{};
        const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), value).ptr;
        return {digits.data(), end};
    }
}
std::string text(bool value) { return value ? "on" : "off"; }
std::string text(const std::optional<double>& value) { return value ? text(*value) : "none"; }

}  // namespace

std::string rule_choices(const RuleOptions& options) {
    // Binds all members by their number: with a new member this does not compile until it is listed here.
    const auto& [edge_beside_crease, loop_weights, hoppe_crease, beta, gamma, reflect, butterfly_w, tuning, steps,
                 boundary, corner_angle, measure_corner_angles, chaikin_creases, runner] = options;
    static_cast<void>(runner);
    const RuleOptions plain;
    std::string choices;
    const auto add = [&](std::string_view name, const auto& value, const auto& usual) {
        if (value == usual) return;
        choices.append(choices.empty() ? "" : ", ").append(name).append(" ").append(text(value));
    };
    add("edge_beside_crease", edge_beside_crease, plain.edge_beside_crease);
    add("loop_weights", loop_weights, plain.loop_weights);
    add("hoppe_crease", hoppe_crease, plain.hoppe_crease);
    add("catmull_clark_beta", beta, plain.catmull_clark_beta);
    add("catmull_clark_gamma", gamma, plain.catmull_clark_gamma);
    add("reflect_at_boundary", reflect, plain.reflect_at_boundary);
    add("butterfly_w", butterfly_w, plain.butterfly_w);
    add("tuning", tuning, plain.tuning);
    add("averaging_steps", steps, plain.averaging_steps);
    add("averaging_boundary", boundary, plain.averaging_boundary);
    add("corner_angle", corner_angle, plain.corner_angle);
    add("measure_corner_angles", measure_corner_angles, plain.measure_corner_angles);
    add("chaikin_creases", chaikin_creases, plain.chaikin_creases);
    return choices;
}

}  // namespace tetrakis
