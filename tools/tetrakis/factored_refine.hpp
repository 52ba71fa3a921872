#pragma once

#include "../../hier/base/vec.hpp"
#include "../../refine/factored/factored_mesh.hpp"
#include "../../schemes/core/scheme_table.hpp"

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace tetrakis::cli {

/// Where half-steps adapt: as many as asked for inside, fewer outside.
struct HalfStepSphere {
    Vec3d centre{0};
    double radius = 0;
};
/// The sphere of --near X,Y,Z and --radius R.
/// @throws UsageError  they are no three finite numbers and one above 0
HalfStepSphere half_step_sphere(const std::string& near, const std::string& radius);

/// Names of the schemes that `refine --factored` takes, with commas between.
std::string factored_scheme_names();
/// @param adaptive  half-steps are to adapt
/// @throws UsageError: the scheme has no factored form, or none that adapts (the message lists those that have)
FactoredScheme chosen_factored_scheme(const SchemeInfo& scheme, bool adaptive);

/// A mesh refined by half-steps of the 4-8 mesh.
struct FactoredResult {
    PolygonMesh mesh;
    int levels = 0;      ///< whole ones
    int half_steps = 0;  ///< of the finest triangles
    std::uint64_t active = 0;
    std::vector<std::size_t> inactive{};  ///< of the mesh's vertices
};

/// @param active  make the scheme's own faces, not the triangles of the 4-8 mesh
FactoredResult refine_by_half_steps(const ControlMesh& mesh, FactoredScheme scheme, int half_steps, bool active,
                                    const RuleOptions& rules, const RunContext& context);
/// All half-steps inside of the sphere, as few as the mesh allows outside.
FactoredResult refine_by_adaptive_half_steps(const ControlMesh& mesh, FactoredScheme scheme, int half_steps,
                                             const HalfStepSphere& sphere, const RunContext& context);

}  // namespace tetrakis::cli
