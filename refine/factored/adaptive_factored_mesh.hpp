#pragma once

#include "../../hier/base/run_context.hpp"
#include "factored_mesh.hpp"

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace tetrakis {

/// Half-steps of FactoredMesh whose number varies over the mesh (Velho; refine/README.md). Each leaf of a restricted
/// 4-8 bisection hierarchy is a triangle of the 4-8 mesh after its own number of half-steps. Neighbouring leaves differ
/// by one half-step at most, and the mesh is conforming.
///
/// A vertex has the position that FactoredMesh gives it after the half-steps of the finest leaf around it. For dual
/// schemes it also has the state of then, and an inactive vertex is at the mean of the active ones around it.
///
/// By invariant 6 these positions are points of whole levels, or means of them. After half-steps 2 l - 1 and 2 l,
/// Catmull-Clark's vertices are points of level l. After 2 l and 2 l + 1, a dual scheme's vertices are means of the
/// points of level l whose cells they touch.
class AdaptiveFactoredMesh {
  public:
    /// A triangle's number of half-steps, and its handle for the next refine().
    struct Leaf {
        std::uint8_t half_steps = 0;
        LeafId id{};
    };
    struct Output {
        PolygonMesh mesh;                      ///< triangles
        std::vector<Leaf> leaves;              ///< per triangle
        std::vector<std::uint8_t> half_steps;  ///< per vertex
        std::vector<FactoredVertex> states;    ///< per vertex
    };

    /// Starts with all leaves at first_half_step(). Stores a copy of the mesh.
    /// @param context  max_memory_bytes: limit for hierarchy and output, which are estimated
    /// @throws Error  unsupported: the scheme's half-steps do not adapt; or a dual scheme on a mesh with creases, or
    ///                with an interior vertex between only two faces
    AdaptiveFactoredMesh(const ControlMesh& mesh, FactoredScheme scheme, const RunContext& context = {});
    ~AdaptiveFactoredMesh();
    AdaptiveFactoredMesh(AdaptiveFactoredMesh&&) noexcept;
    AdaptiveFactoredMesh& operator=(AdaptiveFactoredMesh&&) noexcept;

    /// Half-steps of the coarsest leaves: 1 for Catmull-Clark, 2 (a whole step) for dual schemes.
    int first_half_step() const;
    int max_half_steps() const;

    /// Makes one more half-step for these leaves, and for others to keep the mesh restricted. Cost: O(leaves created).
    /// @throws Error  invalid_input: not a leaf, or a leaf that was split since; unsupported: more than
    ///                max_half_steps(); memory_limit
    void refine(std::span<const Leaf> leaves);
    /// Calls refine() until all triangles of mesh() that meet the sphere have `half_steps` half-steps. The sphere is
    /// enlarged by half of a triangle's longest edge, since the surface can be so far away from the triangle.
    /// @throws Error  invalid_input: centre or radius is not finite, radius <= 0; as refine(); cancelled
    void refine_near(const Vec3d& centre, double radius, int half_steps);

    /// The mesh of the leaves. Cost: O(vertices times levels), in parallel. The same bytes for any number of threads,
    /// and for any order of calls that leads to the same leaves (except Leaf::id).
    Output mesh() const;

  private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace tetrakis
