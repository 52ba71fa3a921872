#pragma once

#include "../../hier/base/run_context.hpp"
#include "factored_mesh.hpp"

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace tetrakis {

/// Half-steps of FactoredMesh that differ from place to place (Velho; refine/README.md): the leaves of a restricted 4-8
/// bisection hierarchy, each a triangle of the 4-8 mesh after a number of half-steps of its own. Neighbouring leaves
/// differ by one half-step at most, and the mesh is conforming.
///
/// A vertex has the point that FactoredMesh gives it after the half-steps of the finest leaf around it. Dual schemes:
/// its state is the one that it has then, too, and an inactive vertex rests at the mean of the active ones around it.
///
/// By invariant 6 these points are those of whole levels, or means of them: after half-steps 2 l - 1 and 2 l
/// Catmull-Clark's vertices are points of level l; after 2 l and 2 l + 1 a dual scheme's vertices are means of the
/// points of level l whose cells they touch.
class AdaptiveFactoredMesh {
  public:
    /// Where a triangle is from: its handle for the next refine(), and how many half-steps it stands at.
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

    /// All leaves at first_half_step(). Keeps a copy of the mesh.
    /// @param context  max_memory_bytes: what hierarchy and output may take, by an estimate
    /// @throws Error  unsupported: the scheme's half-steps do not adapt; a dual scheme on a mesh with creases, or with
    ///                an inner vertex between two faces
    AdaptiveFactoredMesh(const ControlMesh& mesh, FactoredScheme scheme, const RunContext& context = {});
    ~AdaptiveFactoredMesh();
    AdaptiveFactoredMesh(AdaptiveFactoredMesh&&) noexcept;
    AdaptiveFactoredMesh& operator=(AdaptiveFactoredMesh&&) noexcept;

    /// Half-steps of the coarsest leaves: 1 for Catmull-Clark, 2 (a whole step) for dual schemes.
    int first_half_step() const;
    int max_half_steps() const;

    /// One half-step more for these leaves, and for whatever else keeps the mesh restricted. Cost: O(leaves created).
    /// @throws Error  invalid_input: one is no leaf, or has been split since; unsupported: more than max_half_steps();
    ///                memory_limit
    void refine(std::span<const Leaf> leaves);
    /// refine() until all triangles of mesh() that meet the sphere have so many half-steps. Triangles count as larger
    /// by half of their longest edge: the surface can be so far away from them.
    /// @throws Error  invalid_input: centre or radius is not finite, radius <= 0; as refine(); cancelled
    void refine_near(const Vec3d& centre, double radius, int half_steps);

    /// Cost: O(vertices times levels), in parallel; the same bytes for any number of threads, and for any order of the
    /// calls that led to the same leaves (except Leaf::id).
    Output mesh() const;

  private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace tetrakis
