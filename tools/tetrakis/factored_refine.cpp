#include "factored_refine.hpp"

#include "commands.hpp"
#include "run_options.hpp"

#include "../../refine/factored/adaptive_factored_mesh.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>
#include <utility>

namespace tetrakis::cli {

namespace {

template <class Has>
std::string names(Has&& has) {
    std::string result;
    for (const FactoredScheme scheme : factored_schemes())
        if (has(scheme)) result += fmt::format("{}{}", result.empty() ? "" : ", ", name(scheme));
    return result;
}

}  // namespace

HalfStepSphere half_step_sphere(const std::string& near, const std::string& radius) {
    const auto centre = finite_numbers(near, 3), length = finite_numbers(radius, 1);
    if (!centre) throw UsageError(fmt::format("--near: \"{}\" is no point such as 0.5,1,-2 (three numbers)", near));
    if (!length || (*length)[0] <= 0) throw UsageError(fmt::format("--radius: \"{}\" is no length above 0", radius));
    return {{(*centre)[0], (*centre)[1], (*centre)[2]}, (*length)[0]};
}

std::string factored_scheme_names() {
    return names([](FactoredScheme) { return true; });
}

FactoredScheme chosen_factored_scheme(const SchemeInfo& scheme, bool adaptive) {
    const auto factored = factored_scheme_from_name(scheme.name);
    if (!factored)
        throw UsageError(
            fmt::format("{} has no factored form; these have one: {}", scheme.name, factored_scheme_names()));
    if (adaptive && !half_steps_adapt(*factored))
        throw UsageError(fmt::format("--near: half-steps of {} do not adapt; those of these do: {}", scheme.name,
                                     names(half_steps_adapt)));
    return *factored;
}

FactoredResult refine_by_half_steps(const ControlMesh& mesh, FactoredScheme scheme, int half_steps, bool active,
                                    const RuleOptions& rules, const RunContext& context) {
    FactoredMesh factored(mesh, scheme, context.max_memory_bytes, rules);
    factored.check_half_steps(half_steps);
    FactoredResult result{.mesh = {}, .levels = half_steps / factored.half_steps_per_level(), .half_steps = half_steps};
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

FactoredResult refine_by_adaptive_half_steps(const ControlMesh& mesh, FactoredScheme scheme, int half_steps,
                                             const HalfStepSphere& sphere, const RunContext& context) {
    // The coarsest leaves have two half-steps (Catmull-Clark: one); fewer are the same everywhere.
    if (half_steps < 2) return refine_by_half_steps(mesh, scheme, half_steps, false, {}, context);
    AdaptiveFactoredMesh adaptive(mesh, scheme, context);
    adaptive.refine_near(sphere.centre, sphere.radius, half_steps);
    AdaptiveFactoredMesh::Output output = adaptive.mesh();
    FactoredResult result{.mesh = std::move(output.mesh)};
    for (const AdaptiveFactoredMesh::Leaf& leaf : output.leaves)
        result.half_steps = std::max<int>(result.half_steps, leaf.half_steps);
    result.levels = result.half_steps / 2;
    for (std::size_t v = 0; v < output.states.size(); ++v)
        if (output.states[v] == FactoredVertex::inactive) result.inactive.push_back(v);
    result.active = output.states.size() - result.inactive.size();
    return result;
}

}  // namespace tetrakis::cli
