#include "factored_refine.hpp"

#include "exit_code.hpp"

#include <fmt/format.h>

namespace tetrakis::cli {

std::string factored_scheme_names() {
    std::string names;
    for (const FactoredScheme scheme : factored_schemes())
        names += fmt::format("{}{}", names.empty() ? "" : ", ", name(scheme));
    return names;
}

FactoredScheme chosen_factored_scheme(const SchemeInfo& scheme) {
    if (const auto factored = factored_scheme_from_name(scheme.name)) return *factored;
    throw UsageError(fmt::format("{} has no factored form; these have one: {}", scheme.name, factored_scheme_names()));
}

FactoredResult refine_by_half_steps(const ControlMesh& mesh, FactoredScheme scheme, int half_steps, bool active,
                                    const RuleOptions& rules, const RunContext& context) {
    // Whole levels are refined root by root, which is several times faster.
    if (scheme == FactoredScheme::catmull_clark && active && half_steps > 0 && half_steps % 2 == 0 &&
        !mesh.has_corner_angles()) {
        FactoredResult result{.mesh = {}, .levels = half_steps / 2};
        result.mesh =
            refine_uniform(mesh, SchemeKind::catmull_clark, result.levels, {.factored = true, .context = context});
        result.active = result.mesh.positions.size();
        return result;
    }
    FactoredMesh factored(mesh, scheme, context.max_memory_bytes, rules);
    factored.check_half_steps(half_steps);
    FactoredResult result{.mesh = {}, .levels = half_steps / factored.half_steps_per_level()};
    for (int i = 0; i < half_steps; ++i) {
        context.report("refine", static_cast<double>(i) / half_steps);
        factored.half_step();
    }
    std::vector<std::uint32_t> numbers;
    result.mesh = active ? factored.active_mesh() : factored.mesh(&numbers);
    for (std::uint32_t v = 0; v < factored.positions().size(); ++v)
        result.active += factored.state(v) == FactoredVertex::active;
    // The scheme's own mesh has active vertices alone: of that the list is empty.
    for (std::size_t v = 0; v < numbers.size(); ++v)
        if (factored.state(numbers[v]) == FactoredVertex::inactive) result.inactive.push_back(v);
    return result;
}

}  // namespace tetrakis::cli
