#pragma once

#include "../../refine/factored/factored_mesh.hpp"
#include "../../refine/uniform/uniform.hpp"
#include "../../schemes/core/scheme_info.hpp"

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace tetrakis::cli {

/// Names of the schemes that `refine --factored` takes, with commas between.
std::string factored_scheme_names();
/// @throws UsageError: the scheme has no factored form (the message lists those that have)
FactoredScheme chosen_factored_scheme(const SchemeInfo& scheme);

/// A mesh refined by half-steps of the 4-8 mesh.
struct FactoredResult {
    PolygonMesh mesh;
    int levels = 0;  ///< whole ones
    std::uint64_t active = 0;
    std::vector<std::size_t> inactive{};  ///< of the mesh's vertices
};

/// @param active  make the scheme's own faces, not the triangles of the 4-8 mesh
FactoredResult refine_by_half_steps(const ControlMesh& mesh, FactoredScheme scheme, int half_steps, bool active,
                                    const RuleOptions& rules, const RunContext& context);

}  // namespace tetrakis::cli
