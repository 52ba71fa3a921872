#pragma once

#include "../../schemes/core/scheme_table.hpp"

#include <string>
#include <vector>

namespace tetrakis::test {

/// What each scheme is looked at with: itself, and its choices.
struct SchemeVariant {
    std::string name;
    const SchemeInfo* scheme;
    RuleOptions options{};
};

inline std::vector<SchemeVariant> scheme_variants() {
    std::vector<SchemeVariant> result;
    for (const SchemeInfo& scheme : scheme_table()) {
        if (scheme.name == "averaging") {
            for (int m = 0; m <= 5; ++m) {
                result.push_back({"averaging " + std::to_string(m), &scheme, {}});
                result.back().options.averaging_steps = m;
            }
            continue;
        }
        result.push_back({std::string(scheme.name), &scheme, {}});
    }
    const auto with = [&](const char* name, const char* what, auto&& change) {
        result.push_back({std::string(name) + ", " + what, find_scheme(name), {}});
        change(result.back().options);
    };
    with("loop", "Warren's weights", [](RuleOptions& o) { o.loop_weights = LoopWeights::warren; });
    for (const char* name : {"loop", "tuned-loop", "catmull-clark"}) {
        with(name, "cosine", [](RuleOptions& o) { o.edge_beside_crease = EdgeBesideCrease::cosine; });
        with(name, "brief", [](RuleOptions& o) { o.edge_beside_crease = EdgeBesideCrease::brief; });
    }
    with("loop", "Hoppe's creases", [](RuleOptions& o) { o.hoppe_crease = true; });
    with("tuned-loop", "half tuned", [](RuleOptions& o) { o.tuning = 0.5; });
    with("modified-butterfly", "reflection", [](RuleOptions& o) { o.reflect_at_boundary = true; });
    with("modified-butterfly", "ten points", [](RuleOptions& o) { o.butterfly_w = 0.01; });
    with("catmull-clark", "other weights", [](RuleOptions& o) {
        o.catmull_clark_beta = 0.3;
        o.catmull_clark_gamma = 0.1;
    });
    return result;
}

}  // namespace tetrakis::test
